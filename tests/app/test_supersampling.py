"""A viewport that is drawn in software is supersampled once it has stopped changing."""

import pytest

from app.ui.pictures import Paint
from app.ui.viewport.panes import arrange_panes
from app.window import gl_pictures

SIZE = (500, 400)


@pytest.fixture
def drawn(opened, monkeypatch):
    """Draws frames; tells of each drawing of the viewport whether it was supersampled."""
    pictures, paints = opened.window.pictures, []
    panes = pictures._painter.panes
    monkeypatch.setattr(gl_pictures, "gains_by_supersampling", lambda pane, slots: True)
    monkeypatch.setattr(
        pictures._painter, "panes", lambda *asked: [panes(*asked), paints.append(asked[3].supersampled)].clear()
    )

    def frames(count, size=SIZE, hurried=False, **paint):
        paints.clear()
        for _ in range(count):
            pictures.begin_frame(0.0, hurried)
            pictures.viewport(arrange_panes(opened.window.state, size).panes, size, Paint(**paint))
            pictures.draw_ahead()
        return list(paints)

    frames.pictures = pictures
    return frames


def test_it_is_drawn_at_once_and_supersampled_after_a_moment(drawn):
    assert drawn(1) == [False]
    assert drawn.pictures.is_unfinished
    assert drawn(20) == [True]
    assert not drawn.pictures.is_unfinished


def test_while_one_thing_follows_another_nobody_waits_for_clean_edges(drawn):
    for step in range(20):
        assert drawn(2, check_px=10.0 + step) == [False]
    assert drawn.pictures.is_unfinished


def test_a_hand_gets_none_and_what_it_leaves_does(drawn):
    assert set(drawn(20, hurried=True)) == {False}
    assert not drawn.pictures.is_unfinished
    assert drawn(20) == [False, True]


@pytest.mark.parametrize(("pixels", "is_supersampled"), [(1_000_000, True), (1_000_001, False)])
def test_what_would_hold_the_window_up_stays_as_it_is(drawn, monkeypatch, pixels, is_supersampled):
    monkeypatch.setattr(gl_pictures, "covered_pixels", lambda panes, size: pixels)
    assert (True in drawn(20)) == is_supersampled
    assert not drawn.pictures.is_unfinished


def test_a_graphics_card_supersamples_as_soon_as_no_hand_moves_anything(drawn, monkeypatch):
    monkeypatch.setattr(drawn.pictures, "_in_software", False)
    assert drawn(20, hurried=True) == [False]
    assert drawn(20) == [True]
