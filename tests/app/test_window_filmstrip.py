"""The filmstrip in the real window: where its pictures lie, what they show, and which of them is framed."""

import numpy as np
import pytest
from window_hand import HEIGHT, WIDTH, places_drawn

from app.ui.panels import filmstrip

NAMES = ["photo", "albedo", "normal", "parsing", "source_light", "specular", "shadow", "composition", "result"]
ACCENT, FAINT, BACKGROUND = (237, 171, 87), (107, 107, 107), (22, 22, 22)


@pytest.fixture
def places(hand, monkeypatch):
    """The middle of each picture, among other things, by its name."""
    places = places_drawn(monkeypatch, filmstrip.imgui, "invisible_button")
    hand.frames(2)
    return places


def around(hand, place, colour):
    """How many pixels of a colour there are in the frame whose middle is at a place."""
    x, y = (round(along) for along in place)
    frame = hand.window.screenshot()[y - 50 : y + 34, x - 50 : x + 50].astype(int)
    return (np.abs(frame - colour).max(-1) <= 3).sum()


def test_the_pictures_lie_side_by_side_in_the_middle_of_the_window(opened, places):
    opened.frames(2)
    assert [name for name in places if name in NAMES] == NAMES
    across = np.array([places[name][0] for name in NAMES])
    assert np.diff(across) == pytest.approx(np.diff(across).mean(), abs=0.6)
    assert 60 < np.diff(across).mean() < WIDTH / 9
    assert across.mean() == pytest.approx(WIDTH / 2, abs=2)
    assert all(HEIGHT - 141 < y < HEIGHT - 28 for _, y in (places[name] for name in NAMES))


def test_each_frame_shows_its_own_picture_whole_and_in_the_middle(opened, places):
    opened.move(opened.centre())
    x, y = (round(along) for along in places["albedo"])
    red = (np.abs(opened.window.screenshot().astype(int) - (255, 0, 0)).max(-1) <= 3)[y - 60 : y + 50, x - 55 : x + 55]
    columns, rows = np.flatnonzero(red.any(0)), np.flatnonzero(red.any(1))
    # The channel is as high as it is wide.
    assert np.ptp(columns) == pytest.approx(np.ptp(rows), abs=2)
    assert 40 < np.ptp(rows) < 100
    assert columns.mean() - 55 == pytest.approx(0, abs=2)
    # On both sides of it the frame is empty.
    assert around(opened, places["albedo"], BACKGROUND) > 200
    for name in NAMES:
        assert around(opened, places[name], (255, 0, 0)) == 0 or name in ("albedo", "parsing")


def test_the_picture_in_the_viewport_is_framed_and_the_one_under_the_mouse_faintly(opened, places):
    opened.click(places["normal"])
    assert opened.window.state.shown == "normal"
    opened.move(opened.centre())
    framed = {name: around(opened, places[name], ACCENT) > 100 for name in ("photo", "normal", "result")}
    assert framed == {"photo": False, "normal": True, "result": False}
    before = around(opened, places["photo"], FAINT)
    opened.move(places["photo"])
    assert around(opened, places["photo"], FAINT) > before + 50


def test_what_is_not_there_yet_can_t_be_chosen(hand, places):
    shown = hand.window.state.shown
    hand.click(places["albedo"])
    assert hand.window.state.shown == shown
    assert around(hand, places["albedo"], ACCENT) == 0


def test_a_picture_s_tip_says_its_title_its_key_and_what_it_is(opened, places, monkeypatch):
    tips = []
    monkeypatch.setattr(filmstrip.imgui, "set_item_tooltip", tips.append)
    opened.frames(1)
    assert "Albedo   2\nThe colour of skin, hair and cloth with all light taken away." in tips
    assert "Result   9\nThe finished picture." in tips


def test_in_a_narrow_window_all_pictures_are_in_sight(opened, places):
    opened.resize((800, HEIGHT))
    opened.frames(2)
    across = [places[name][0] for name in NAMES]
    step = across[1] - across[0]
    assert step / 2 - 8 < across[0]
    assert across[-1] < 800 - step / 2 + 8
