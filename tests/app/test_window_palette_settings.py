"""The panels' settings in the real window, set by their names with the keyboard alone."""

from dataclasses import replace

import glfw
import pytest

from app.engine.jobs import JobStatus
from app.ui.actions.setting_actions import setting_actions
from app.ui.layout import Panels
from app.ui.panels.panorama import add_box


def run(hand, typed, number=None):
    """Enter what is typed into the palette, and then a number or a name into the line that it leads to."""
    hand.key(glfw.KEY_P, ctrl=True)
    hand.type(typed)
    hand.key(glfw.KEY_ENTER)
    assert not hand.window.state.look.palette
    if number is not None:
        hand.frames(4)
        hand.type(number)
        hand.key(glfw.KEY_ENTER)


@pytest.mark.parametrize(
    ("typed", "field"), [("level", "level_ev"), ("saturation", "saturation"), ("blur", "blur_deg")]
)
def test_a_slider_of_the_folded_light_is_set(opened, typed, field):
    state = opened.window.state
    state.panels = Panels(light=False)
    run(opened, f"light's {typed}", "1.5")
    assert (getattr(state.light_edit, field), state.typing) == (1.5, None)


def test_a_soft_box_is_chosen_and_changed(opened):
    state = opened.window.state
    add_box(state, 20.0, 30.0)
    add_box(state, -40.0, 10.0)
    opened.settle()
    run(opened, "lamp soft box 1")
    assert state.selected_box == 0
    untouched = state.light_edit.boxes[1]
    run(opened, "box's brightness", "2.5")
    run(opened, "shape box round")
    run(opened, "box's hole", "0.5")
    first, second = state.light_edit.boxes
    assert (first.intensity, first.form, first.hole) == (2.5, "disc", 0.5)
    assert second == untouched


def test_colours_are_typed_and_a_gel_is_taken_off(opened):
    state = opened.window.state
    state.panels = Panels(light=False)
    add_box(state, 20.0, 30.0)
    opened.settle()
    run(opened, "background's colour", "#2040ff")
    assert (state.edit.background, state.typing) == ("#2040ff", None)
    run(opened, "set coloured gel", "ff0033")
    assert state.light_edit.boxes[0].colour == pytest.approx((1.0, 0.0, 0.0331), abs=1e-4)
    run(opened, "remove coloured gel")
    assert state.light_edit.boxes[0].colour is None


@pytest.mark.parametrize(("typed", "field"), [("blur", "background_blur_deg"), ("width", "background_fov_deg")])
def test_how_the_light_is_seen_behind_the_person_is_set_where_it_is(opened, typed, field):
    state = opened.window.state
    assert not [action for action in setting_actions(state) if action.name == f"Set background {typed}"]
    run(opened, "background light")
    run(opened, f"set background {typed}", "12.5")
    assert (state.edit.background, getattr(state.edit, field)) == ("light", 12.5)


def test_what_is_no_colour_is_told_and_esc_takes_none(opened):
    state = opened.window.state
    run(opened, "background's colour", "mauve")
    assert state.snapshot.message.is_error
    assert "mauve" in state.snapshot.message.text
    run(opened, "background's colour")
    opened.frames(4)
    opened.type("ff0033")
    opened.key(glfw.KEY_ESCAPE)
    assert (state.edit.background, state.typing) == ("keep", None)


def test_the_light_s_adjustments_are_reset_and_its_soft_boxes_stay(opened):
    state = opened.window.state
    add_box(state, 20.0, 30.0)
    boxes = state.light_edit.boxes
    run(opened, "light's saturation", "1.5")
    run(opened, "reset the adjusted")
    assert (state.light_edit.saturation, state.light_edit.boxes) == (1.0, boxes)


def test_how_a_file_is_made_is_set(opened):
    state = opened.window.state
    run(opened, "size 2048")
    run(opened, "16 bit")
    run(opened, "name the export", "mine")
    assert (state.export.longest_side, state.export.deep, state.export_path) == (2048, True, "mine")
    run(opened, "kind jpeg")
    run(opened, "jpeg's quality", "75")
    assert (state.export.quality, state.typing) == (75, None)
    run(opened, "kind exr")
    run(opened, "layer matte")
    assert (state.export.form, "matte" in state.export.layers, len(state.export.layers)) == (".exr", False, 8)


@pytest.mark.parametrize(
    ("typed", "name", "form"),
    [
        ("me.JPEG", "me.JPEG", ".jpg"),
        ("me.tiff", "me.tiff", ".tif"),
        ("me.exr", "me.exr", ".exr"),
        ("v1.2", "v1.2", ".png"),
    ],
)
def test_a_name_that_is_typed_says_which_kind_of_file_it_becomes(opened, typed, name, form):
    run(opened, "name the export", typed)
    assert (opened.window.state.export_path, opened.window.state.export.form) == (name, form)


def test_long_work_is_cancelled(opened, monkeypatch):
    window, cancelled, running = opened.window, [], JobStatus("Turntable", 3, 120, number=2)
    monkeypatch.setattr(window.exporter, "status", lambda: running)
    monkeypatch.setattr(window.exporter, "cancel", cancelled.append)
    opened.frames(2)
    opened.hold(glfw.KEY_P, glfw.MOD_CONTROL)
    opened.release(glfw.KEY_P)
    opened.type("cancel")
    opened.hold(glfw.KEY_ENTER)
    assert cancelled == [running]
    monkeypatch.setattr(window.exporter, "status", lambda: replace(JobStatus("Turntable"), cancelling=True))
    opened.release(glfw.KEY_ENTER)
    opened.hold(glfw.KEY_P, glfw.MOD_CONTROL)
    opened.type("cancel turn")
    opened.hold(glfw.KEY_ENTER)
    assert cancelled == [running]
