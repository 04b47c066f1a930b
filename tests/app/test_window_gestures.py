"""What the mouse does beside clicking and dragging, and the keys of the number pad."""

import glfw
import pytest
from imgui_bundle import imgui
from window_hand import WIDTH, places_drawn

from app.engine.sources import LightSource
from app.ui.asking import Question
from relight_core.lighting.sphere import uv_of


def right_click(hand, at):
    hand.move(at)
    for action in (glfw.PRESS, glfw.RELEASE):
        hand.window.on_mouse_button(None, glfw.MOUSE_BUTTON_RIGHT, action, 0)
        hand.frames(2)


@pytest.fixture
def buttons(opened, monkeypatch):
    """The middle of each button without a face, by its name."""
    return places_drawn(monkeypatch, imgui, "invisible_button")


def test_a_right_click_takes_a_soft_box_away(opened, pair):
    state = opened.window.state
    right_click(opened, opened.panorama(uv_of(pair[1].direction)[0]))
    assert (state.light_edit.boxes, state.selected_box) == (pair[:1], -1)
    right_click(opened, opened.panorama(uv_of(pair[1].direction)[0]))
    assert state.light_edit.boxes == pair[:1]


def test_a_right_click_takes_a_file_s_light_off_the_list_but_no_bundled_one(opened, buttons):
    state, light = opened.window.state, LightSource("panorama", "/lights/sky.hdr")
    state.extra_lights = [light]
    opened.frames(2)
    right_click(opened, buttons["rig:butterfly"])
    assert state.extra_lights == [light]
    right_click(opened, buttons["panorama:/lights/sky.hdr"])
    assert state.extra_lights == []
    assert state.light.name == "rembrandt"


@pytest.mark.parametrize(("shift", "wheel_deg", "drag_deg"), [(False, 5.0, 36.0), (True, 1.0, 7.2)])
def test_the_light_turns_with_the_wheel_and_the_panorama_and_with_shift_in_small_steps(
    opened, shift, wheel_deg, drag_deg
):
    state, mods = opened.window.state, glfw.MOD_SHIFT if shift else 0
    opened.move(opened.centre())
    if shift:
        opened.hold(glfw.KEY_LEFT_SHIFT, mods)
    opened.window.on_wheel(None, 0.0, 1.0)
    opened.frames(2)
    assert state.edit.yaw_deg == pytest.approx(wheel_deg)
    opened.move(opened.panorama(0.4))
    for action, along in ((glfw.PRESS, 0.5), (glfw.RELEASE, 0.5)):
        opened.window.on_mouse_button(None, glfw.MOUSE_BUTTON_LEFT, action, mods)
        opened.frames(2)
        opened.move(opened.panorama(along))
    assert state.edit.yaw_deg == pytest.approx(wheel_deg + drag_deg, abs=0.05 * drag_deg)


def test_a_click_on_histogram_or_waveform_shows_the_other(opened, buttons):
    look = opened.window.state.look
    opened.frames(2)
    for shown in ("waveform", "histogram"):
        opened.click(buttons["scope"])
        assert look.scope == shown


def test_the_palette_runs_nothing_that_can_not_be_done_and_a_click_beside_it_puts_it_away(opened):
    state = opened.window.state
    opened.key(glfw.KEY_P, ctrl=True)
    opened.type("REMOVE")
    opened.key(glfw.KEY_ENTER)
    assert state.look.palette
    opened.click((WIDTH / 2, opened.centre()[1] + 150))
    assert not state.look.palette


def test_the_number_pad_shows_pictures_and_answers(opened):
    state, given = opened.window.state, []
    opened.key(glfw.KEY_KP_2)
    assert state.shown == "albedo"
    opened.key(glfw.KEY_KP_9)
    assert state.shown == "result"
    state.asking.ask(Question("asked", "A question.", (("Yes", lambda: given.append("Yes")),)))
    opened.key(glfw.KEY_KP_ENTER)
    assert given == ["Yes"]


def test_ctrl_that_is_let_go_in_the_frame_of_the_wheel_still_makes_it_a_zoom(opened):
    window = opened.window
    opened.move(opened.centre())
    opened.hold(glfw.KEY_LEFT_CONTROL)
    window.on_wheel(None, 0.0, 1.0)
    window.on_wheel(None, 0.0, 1.0)
    window.on_key(None, glfw.KEY_LEFT_CONTROL, 0, glfw.RELEASE, glfw.MOD_CONTROL)
    opened.frames(4)
    zoomed = window.state.view
    assert (zoomed.zoom > 1.2, window.state.edit.yaw_deg) == (True, 0.0)
    window.on_wheel(None, 0.0, 1.0)
    window.on_key(None, glfw.KEY_LEFT_CONTROL, 0, glfw.PRESS, 0)
    opened.frames(4)
    assert window.state.view == zoomed
    assert window.state.edit.yaw_deg != 0.0
