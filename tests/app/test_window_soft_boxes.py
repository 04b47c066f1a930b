"""Soft boxes in the hand while something else happens to them, and the light's own lamps beside them."""

import threading
from dataclasses import replace

import glfw
import numpy as np
import pytest
from imgui_bundle import imgui
from window_hand import PANORAMA_WIDTH, PANORAMA_X, PANORAMA_Y

from app.ui import light_edits, widgets
from relight_core.lighting.rigs import load_rig
from relight_core.lighting.sphere import uv_of


@pytest.fixture
def tracks(monkeypatch):
    """Where the sliders' tracks were drawn last, by their labels."""
    places, draw = {}, widgets._track

    def watched(state, spec, value):
        left = imgui.get_cursor_screen_pos()
        places[spec.label] = left.x + 0.6 * imgui.get_content_region_avail().x, left.y + 6.0
        return draw(state, spec, value)

    monkeypatch.setattr(widgets, "_track", watched)
    return places


def take(hand, box):
    """Press on a box and begin to drag it."""
    u, _ = uv_of(box.direction)
    hand.move(hand.panorama(u))
    hand.button(True)
    hand.move(hand.panorama(u + 0.05))
    assert hand.window.state.held.kind == "move"
    return u + 0.1


def press(hand, key, mods=0):
    hand.hold(key, mods)
    hand.release(key)


def test_a_box_that_is_deleted_in_the_hand_is_gone_and_the_other_stays(opened, pair):
    further = take(opened, pair[0])
    press(opened, glfw.KEY_DELETE)
    opened.move(opened.panorama(further))
    opened.button(False)
    assert opened.window.state.light_edit.boxes == (pair[1],)


def test_a_right_click_deletes_the_box_under_it_and_not_the_selected_one(opened, pair):
    u, _ = uv_of(pair[1].direction)
    opened.move(opened.panorama(u))
    for action in (glfw.PRESS, glfw.RELEASE):
        opened.window.on_mouse_button(None, glfw.MOUSE_BUTTON_RIGHT, action, 0)
        opened.frames(2)
    assert opened.window.state.light_edit.boxes == (pair[0],)


def test_a_turn_moves_what_the_panorama_shows_to_the_right(opened):
    rows = []
    opened.light("split")
    for yaw_deg in (0.0, 90.0):
        opened.window.state.change(yaw_deg=yaw_deg)
        opened.settle()
        shown = opened.window.screenshot()[PANORAMA_Y, PANORAMA_X : PANORAMA_X + PANORAMA_WIDTH]
        rows.append(shown.astype(float))
    to_the_right, to_the_left = (np.abs(np.roll(rows[0], by, 0) - rows[1]).mean() for by in (57, -57))
    assert to_the_right < 0.25 * to_the_left


def test_undo_and_the_lamps_key_take_what_the_hand_holds(opened):
    state = opened.window.state
    opened.light("split")
    opened.key(glfw.KEY_M)
    further = take(opened, state.light_edit.boxes[0])
    press(opened, glfw.KEY_M)
    opened.move(opened.panorama(further))
    opened.button(False)
    assert state.light_edit.boxes == ()
    opened.double_click(opened.panorama(0.5))
    (box,) = state.light_edit.boxes
    further = take(opened, box)
    for _ in range(2):
        press(opened, glfw.KEY_Z, glfw.MOD_CONTROL)
    opened.move(opened.panorama(further))
    opened.button(False)
    assert state.light_edit.boxes == ()


@pytest.mark.parametrize("along", [60.0, None])
def test_a_number_that_was_typed_is_for_the_box_it_was_typed_for(opened, pair, tracks, along):
    state = opened.window.state
    opened.frames(2)
    opened.click(tracks["Brightness"], ctrl=True)
    opened.frames(3)
    opened.type("2.5")
    opened.click(opened.panorama(0.02 if along is None else uv_of(pair[1].direction)[0]))
    opened.frames(4)
    assert [box.intensity for box in state.light_edit.boxes] == [2.5, 1.0]
    assert state.selected_box == (-1 if along is None else 1)


def test_lamps_that_shone_alone_are_put_back_into_the_whole_light(opened):
    state = opened.window.state
    opened.light("split")
    split = opened.picture_pixels(96, 128)
    opened.key(glfw.KEY_M)
    state.light_edit = replace(state.light_edit, base=0.0)
    opened.settle()
    opened.key(glfw.KEY_M)
    assert np.array_equal(opened.picture_pixels(96, 128), split)
    assert state.history.steps[-1].name == "Put the light's lamps back"


def test_with_another_light_nothing_that_was_not_chosen_is_selected(opened):
    state = opened.window.state
    opened.light("split")
    opened.key(glfw.KEY_M)
    opened.key(glfw.KEY_N)
    added = state.light_edit.boxes[1]
    state.selected_box = 0
    opened.light("ring")
    assert (state.light_edit.boxes, state.selected_box) == ((added,), -1)
    opened.key(glfw.KEY_M)
    state.selected_box = 1
    opened.light("split")
    assert (state.light_edit.boxes, state.selected_box) == ((added,), 0)


def test_a_box_added_while_a_broken_light_is_read_stays(opened, tmp_path, monkeypatch):
    state, desk = opened.window.state, opened.window.engine._desk
    (tmp_path / "bad.hdr").write_bytes(b"no picture")
    gate, read = threading.Event(), desk._environment
    monkeypatch.setattr(desk, "_environment", lambda *asked: (gate.wait(20), read(*asked))[1])
    opened.window.on_drop(None, [str(tmp_path / "bad.hdr")], (5, 5))
    opened.frames(3)
    press(opened, glfw.KEY_N)
    (added,) = state.light_edit.boxes
    gate.set()
    opened.settle()
    assert (state.light.name, state.light_edit.boxes) == ("rembrandt", (added,))


def test_a_lamp_is_switched_off_and_on(opened):
    state = opened.window.state
    opened.light("split")
    split = opened.picture_pixels(96, 128).astype(int)
    opened.key(glfw.KEY_M)
    opened.key(glfw.KEY_M, shift=True)
    assert state.light_edit.boxes[0].off
    assert opened.window.engine.snapshot().light.environment.level < 0.5 * load_rig("split").level
    assert np.abs(opened.picture_pixels(96, 128) - split).max() > 5
    assert state.history.steps[-1].name == "Switch off key"
    opened.key(glfw.KEY_M, shift=True)
    assert not state.light_edit.boxes[0].off
    assert np.abs(opened.picture_pixels(96, 128) - split).max() <= 1


def test_a_box_that_is_deleted_while_its_number_is_typed_leaves_no_typing_behind(opened, pair, tracks):
    state = opened.window.state
    opened.frames(2)
    opened.click(tracks["Brightness"], ctrl=True)
    opened.frames(3)
    assert state.typing == "Brightness"
    light_edits.delete_box(state)
    opened.frames(2)
    assert state.typing is None
    opened.click(opened.panorama(uv_of(pair[1].direction)[0]))
    opened.frames(2)
    assert state.selected_box == 0


def accented(hand, places):
    """Of which sliders the track says that they are changed."""
    frame = hand.window.screenshot()[:, :255].astype(int)
    is_accent = (np.abs(frame - (237, 171, 87)) <= 3).all(-1)
    return [name for name, (_, y) in places.items() if is_accent[round(y) - 4 : round(y) + 8].any()]


def test_a_lamp_of_the_light_itself_is_unchanged_as_it_came_and_a_double_click_brings_that_back(opened, tracks):
    state = opened.window.state
    opened.light("rembrandt")
    opened.key(glfw.KEY_M)
    (came, *_) = state.light_edit.boxes
    assert (came.name, came.kelvin) == ("key", 5000.0)
    lamp = ("Brightness", "Soft edge", "Colour")
    tracks.clear()
    opened.frames(2)
    places = {name: tracks[name] for name in lamp}
    assert accented(opened, places) == []
    light_edits.put_box(state, 0, replace(came, intensity=3.0, softness=0.9, kelvin=9000.0))
    opened.settle()
    assert accented(opened, places) == [*lamp]
    for name in lamp:
        opened.double_click(places[name])
    assert state.light_edit.boxes[0] == came


def test_a_double_click_brings_back_the_hole_that_a_ring_light_came_with(opened, tracks):
    state = opened.window.state
    opened.light("ring")
    opened.key(glfw.KEY_M)
    (came,) = state.light_edit.boxes
    assert came.hole > 0.3
    light_edits.put_box(state, 0, replace(came, hole=0.1))
    opened.settle()
    opened.double_click(tracks["Hole"])
    assert state.light_edit.boxes == (came,)
