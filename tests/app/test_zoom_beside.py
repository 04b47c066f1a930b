"""Zooming and moving with the mouse beside the picture."""

import pytest

from app.ui.viewport.view import Frame, View, pan, place, zoom_about

PORTRAIT, WIDE_VIEWPORT = Frame(0, 0, 600, 800), (1000, 600)


def test_zooming_in_beside_a_portrait_never_loses_it():
    for at in ((60.0, 300.0), (990.0, 10.0)):
        view = View()
        for _ in range(8):
            view = zoom_about(view, 1.2, at, PORTRAIT, WIDE_VIEWPORT)
        spot = place(view, PORTRAIT, WIDE_VIEWPORT)
        assert spot.x <= 500
        assert spot.x + spot.width >= 499


def test_zooming_in_on_the_picture_again_does_not_jump_to_its_middle():
    aside = View(False, 0.5, -100.0, 400.0)
    closer = zoom_about(aside, 1.1, (600.0, 300.0), PORTRAIT, WIDE_VIEWPORT)
    assert -100.0 < closer.centre_x < -80.0


def test_zooming_out_beside_a_portrait_leaves_what_is_under_the_mouse_there():
    view, zoom = View(), 0.71
    for _ in range(4):
        view, zoom = zoom_about(view, 0.8, (60.0, 300.0), PORTRAIT, WIDE_VIEWPORT), zoom * 0.8
    assert (view.zoom, view.centre_x) == pytest.approx((zoom, 300 - 440 / 0.71 + 440 / zoom))


def test_a_picture_that_lies_beside_the_middle_moves_with_the_mouse_and_no_further_away():
    aside = View(False, 0.5, -100.0, 900.0)
    back = pan(aside, -3.0, 2.0, PORTRAIT, WIDE_VIEWPORT)
    assert (back.centre_x, back.centre_y) == (-94.0, 896.0)
    assert pan(aside, 3.0, -2.0, PORTRAIT, WIDE_VIEWPORT) == aside
