"""The export's controls in the real window."""

import glfw
import numpy as np
import pytest
from imgui_bundle import imgui
from PIL import Image
from window_hand import EFFECTS_PANEL, HEIGHT, STRIPS, WIDTH

from app.ui.actions.export_actions import export_actions
from app.ui.export_name import choose_form
from app.ui.layout import OpenGroups
from relight_core.imaging.formats.icc_making import DISPLAY_P3, primaries_profile

ROW = 32


def look_and_choose(hand, suffix):
    """The right panel's pixels before and after another kind of file is chosen, other groups folded."""
    state = hand.window.state
    state.groups = OpenGroups(effects=False, background=False)
    panel = slice(WIDTH - EFFECTS_PANEL + 2, WIDTH)
    hand.move((WIDTH / 2, HEIGHT - 3))
    before = hand.window.screenshot()[: HEIGHT - STRIPS, panel]
    choose_form(state, suffix)
    hand.settle()
    return before, hand.window.screenshot()[: HEIGHT - STRIPS, panel]


def changed_rows(before, after):
    (rows,) = (before != after).any(axis=(1, 2)).nonzero()
    return rows


@pytest.mark.parametrize("suffix", [".jpg", ".exr"])
def test_the_export_buttons_stay_where_they_are_whatever_kind_of_file_is_chosen(opened, suffix):
    rows = changed_rows(*look_and_choose(opened, suffix))
    assert len(rows) > 20, "another kind, its quality or layers, another name"
    assert np.ptp(rows) < 110, "three rows of controls, and nothing below them"


def in_p3(hand, photo_path):
    with Image.open(photo_path) as plain:
        plain.save(photo_path, icc_profile=primaries_profile(DISPLAY_P3))
    hand.drop(photo_path)
    hand.see_every_pixel()
    return hand


@pytest.mark.parametrize("suffix", [".jpg", ".exr"])
def test_with_a_choice_of_profile_they_stay_there_too(hand, photo_path, suffix):
    rows = changed_rows(*look_and_choose(in_p3(hand, photo_path), suffix))
    assert np.ptp(rows) < 110 + ROW, "four rows of controls, and nothing below them"


def test_the_photo_s_own_profile_is_offered_where_it_has_one(hand, photo_path):
    state = hand.window.state

    def offered():
        return [action for action in export_actions(state) if action.name == "Export colours: As photo"]

    hand.drop(photo_path)
    assert offered() == []
    in_p3(hand, photo_path.rename(photo_path.with_name("p3.png")))
    (action,) = offered()
    action.run(state)
    assert state.export.profile == "photo"
    choose_form(state, ".exr")
    assert offered() == []


def test_the_quality_of_a_jpeg_is_dragged_and_a_double_click_resets_it(opened):
    state = opened.window.state
    y = changed_rows(*look_and_choose(opened, ".jpg")).min() + 12 + ROW
    opened.drag((WIDTH - 180, y), (WIDTH - EFFECTS_PANEL + 16, y))
    assert state.export.quality < 60
    opened.double_click((WIDTH - 150, y))
    assert state.export.quality == 92


def test_layers_are_chosen_in_a_list_that_escape_closes_before_anything_else(opened):
    state = opened.window.state
    opened.window.engine.say("a line that stays")
    y = changed_rows(*look_and_choose(opened, ".exr")).min() + 12 + 2 * ROW
    opened.click((WIDTH - 60, y))
    opened.click((WIDTH - 122, y + 37))
    assert "albedo" not in state.export.layers
    assert {"normal", "specular", "shadow", "parsing", "composition", "matte", "background"} < {*state.export.layers}
    opened.key(glfw.KEY_ESCAPE)
    assert not imgui.is_popup_open("", imgui.PopupFlags_.any_popup)
    assert state.message().text == "a line that stays"
    opened.key(glfw.KEY_ESCAPE)
    assert state.message() is None


@pytest.mark.parametrize(
    ("typed", "name"), [("best v1.5", "best v1.5.png"), ("best.jpg", "best.jpg"), ("best/../me.png", "me.png")]
)
def test_the_tooltip_of_the_name_says_where_the_picture_goes(opened, photo_path, monkeypatch, typed, name):
    told = []
    monkeypatch.setattr(imgui, "set_item_tooltip", told.append)
    opened.window.state.export_path = typed
    opened.frames(1)
    assert [words.split("\n")[0] for words in told if "A number is added" in words] == [str(photo_path.parent / name)]
