"""Zoom, pan and fit: pure geometry."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.ui.viewport.view import Frame, View, actual_size, pan, photo_point, place, zoom_about

VIEWPORT = (800, 500)
sizes = st.tuples(st.integers(1, 9000), st.integers(1, 9000))
points = st.tuples(st.floats(0, 800), st.floats(0, 500))


@given(sizes)
def test_fit_shows_the_whole_picture_centred_and_touches_the_margin(picture):
    spot = place(View(), Frame(0, 0, *picture), VIEWPORT)
    assert spot.x >= 15
    assert spot.y >= 15
    assert spot.x + spot.width <= 785
    assert spot.y + spot.height <= 485
    assert max(spot.width / 768, spot.height / 468) == pytest.approx(1.0)
    assert spot.width / spot.height == pytest.approx(picture[0] / picture[1])


@given(points, st.floats(0.5, 2.0))
def test_zooming_keeps_the_point_under_the_mouse(at, factor):
    picture = Frame(0, 0, 640, 480)
    view = View(False, 1.3, 300.0, 200.0)
    before = place(view, picture, VIEWPORT)
    after = place(zoom_about(view, factor, at, picture, VIEWPORT), picture, VIEWPORT)
    for axis, start, end in ((0, before.x, after.x), (1, before.y, after.y)):
        point_before = (at[axis] - start) / before.zoom
        point_after = (at[axis] - end) / after.zoom
        assert point_before == pytest.approx(point_after, abs=2.0)
    assert after.zoom == pytest.approx(1.3 * factor)


def test_zoom_has_ends():
    far, near = View(), View()
    for _ in range(200):
        far, near = (zoom_about(v, f, (9, 9), Frame(0, 0, 64, 64), VIEWPORT) for v, f in ((far, 0.5), (near, 2.0)))
    assert far.zoom == 0.02
    assert near.zoom == 64.0


def test_panning_moves_with_the_mouse_and_never_loses_the_picture():
    picture = Frame(0, 0, 640, 480)
    start = View(False, 2.0, 320.0, 240.0)
    moved = pan(start, 30, -12, picture, VIEWPORT)
    assert place(moved, picture, VIEWPORT).x - place(start, picture, VIEWPORT).x == 30
    assert place(moved, picture, VIEWPORT).y - place(start, picture, VIEWPORT).y == -12
    lost = pan(start, 1e9, -1e9, picture, VIEWPORT)
    spot = place(lost, picture, VIEWPORT)
    assert spot.x < 800
    assert spot.x + spot.width > 0
    assert spot.y < 500
    assert spot.y + spot.height > 0


@given(points, st.floats(0.05, 20.0))
def test_a_channel_lies_on_the_photo_where_its_crop_is(at, zoom):
    whole, crop = Frame(0, 0, 640, 480), Frame(-20, 40, 300, 300)
    view = View(False, zoom, 310.0, 250.0)
    over_photo = photo_point(place(view, whole, VIEWPORT), whole, at)
    over_crop = photo_point(place(view, crop, VIEWPORT), crop, at)
    assert over_photo == pytest.approx(over_crop, abs=1.01 / zoom)


def test_actual_size_keeps_the_point_under_the_mouse_and_then_fits_again():
    whole, at = Frame(0, 0, 4000, 3000), (600.0, 100.0)
    before = photo_point(place(View(), whole, VIEWPORT), whole, at)
    close = actual_size(View(), at, whole, VIEWPORT)
    spot = place(close, whole, VIEWPORT)
    assert (spot.width, spot.height, spot.zoom) == (4000, 3000, 1.0)
    assert photo_point(spot, whole, at) == pytest.approx(before, abs=10.0)
    assert actual_size(close, at, whole, VIEWPORT) == View()
    assert actual_size(View(False, 3.0, 5.0, 5.0), at, whole, VIEWPORT).zoom == 1.0


def test_a_picture_begins_at_a_whole_pixel_so_that_it_stays_crisp():
    spot = place(View(False, 1.0, 320.25, 200.75), Frame(0, 0, 640, 480), VIEWPORT)
    assert (spot.x, spot.y) == (80, 49)


def test_a_viewport_smaller_than_its_margin_still_shows_the_picture():
    spot = place(View(), Frame(0, 0, 640, 480), (20, 500))
    assert (spot.width, spot.height) == (1, 0.75)
