"""The real window: a panorama dropped, metered, and put back to what its file says."""

from dataclasses import replace

import glfw
import numpy as np
import pytest

from app.document.session_file import read_session
from relight_core.errors import InputError
from relight_core.imaging.write import write_image
from relight_core.lighting.light_edit import LightEdit

METERED, LEVEL_KNOB, LEVEL_NUMBER = (80, 341), (122, 357), (210, 341)
AS_PHOTO, AS_PHOTO_OF_PANORAMAS = (80, 341), (150, 341)
"""Where in the window they are while *Adjust the light* is open."""


@pytest.fixture
def sunny(tmp_path):
    """A panorama four times as bright as the rigs."""
    write_image(tmp_path / "sunny.exr", np.full((16, 32, 3), 6.0, np.float32))
    return tmp_path / "sunny.exr"


@pytest.fixture
def adjusting(opened):
    opened.window.state.groups = replace(opened.window.state.groups, adjust=True)
    opened.frames(2)
    return opened


def level(hand):
    """Of the light that the picture in sight was relit with."""
    return hand.window.state.snapshot.picture.light.environment.level


def test_a_dropped_panorama_is_metered_without_touching_the_exposure_and_undone_in_one_step(opened, sunny):
    state = opened.window.state
    rig = level(opened)
    opened.drop(sunny)
    assert level(opened) == pytest.approx(1.5)
    assert state.edit.exposure_ev == 0.0
    opened.key(glfw.KEY_Z, ctrl=True)
    assert (state.light.name, state.light_edit, level(opened)) == ("rembrandt", LightEdit(), rig)
    opened.key(glfw.KEY_Y, ctrl=True)
    assert level(opened) == pytest.approx(1.5)


def test_the_switch_and_its_key_turn_metering_off_and_on(adjusting, sunny):
    adjusting.drop(sunny)
    adjusting.click(METERED)
    adjusting.settle()
    assert level(adjusting) == pytest.approx(6.0)
    adjusting.key(glfw.KEY_Z, ctrl=True)
    assert level(adjusting) == pytest.approx(1.5)
    adjusting.key(glfw.KEY_A)
    assert level(adjusting) == pytest.approx(6.0)
    adjusting.click(METERED)
    adjusting.settle()
    assert level(adjusting) == pytest.approx(1.5)


def test_the_level_is_set_on_top_and_stays_when_the_meter_is_switched(adjusting, sunny):
    state = adjusting.window.state
    adjusting.drop(sunny)
    x, y = LEVEL_KNOB
    adjusting.drag((x, y), (x + 40, y))
    stops = state.light_edit.level_ev
    assert stops > 0.5
    assert level(adjusting) == pytest.approx(1.5 * 2.0**stops)
    adjusting.click(METERED)
    adjusting.settle()
    assert level(adjusting) == pytest.approx(6.0 * 2.0**stops)


def test_a_level_is_typed_in_although_the_switch_stands_there(adjusting, sunny):
    adjusting.drop(sunny)
    adjusting.click(LEVEL_NUMBER)
    adjusting.type("2")
    adjusting.key(glfw.KEY_ENTER)
    assert adjusting.window.state.light_edit == LightEdit(level_ev=2.0, metered=True)


def test_rigs_have_no_switch(adjusting):
    adjusting.key(glfw.KEY_A)
    assert adjusting.window.state.light_edit == LightEdit()
    adjusting.click(AS_PHOTO)
    assert not adjusting.window.state.light_edit.metered


def test_the_level_is_matched_to_the_face_by_its_button_and_key_and_undone_in_one_step(adjusting):
    """The faces of these tests want 1.25 stops more than any light gives them."""
    rig = level(adjusting)
    for match in (lambda: adjusting.click(AS_PHOTO), lambda: adjusting.key(glfw.KEY_A, shift=True)):
        match()
        adjusting.settle()
        assert level(adjusting) == pytest.approx(rig * 2.0**1.25)
        adjusting.key(glfw.KEY_Z, ctrl=True)
        assert level(adjusting) == pytest.approx(rig)


@pytest.fixture
def busy(opened, relighter):
    """The window while the networks are held."""
    relighter.gate.clear()
    yield opened
    relighter.gate.set()


def press_as_photo(hand):
    hand.hold(glfw.KEY_A, glfw.MOD_SHIFT)
    hand.release(glfw.KEY_A)


def test_the_level_waits_for_the_picture_under_the_light_that_is_wanted(busy, relighter):
    state = busy.window.state
    state.light_edit = LightEdit(level_ev=2.0)
    busy.frames(2)
    press_as_photo(busy)
    assert state.light_edit.level_ev == 2.0
    glfw.set_window_should_close(busy.window.handle, True)
    assert busy.window.may_close(), "a level is no file that could be lost"
    relighter.gate.set()
    busy.settle()
    assert state.light_edit.level_ev == 3.25


def test_a_level_that_nothing_can_be_told_of_stays_and_that_is_told(busy, relighter):
    busy.window.state.light_edit = LightEdit(level_ev=2.0)
    relighter.fail_with = InputError("no room")
    press_as_photo(busy)
    relighter.gate.set()
    busy.settle()
    assert busy.window.state.light_edit.level_ev == 2.0
    assert "Nothing was changed" in busy.window.state.message().text
    assert busy.window.state.asking.level is None


def test_both_ways_to_a_level_stand_side_by_side_for_panoramas(adjusting, sunny):
    adjusting.drop(sunny)
    adjusting.click(AS_PHOTO_OF_PANORAMAS)
    adjusting.settle()
    assert adjusting.window.state.light_edit == LightEdit(level_ev=1.25, metered=True)


def test_a_saved_session_knows_whether_its_light_is_metered(opened, sunny, photo_path):
    path = photo_path.with_name("person.relight.json")
    opened.drop(sunny)
    for metered, shown_level in ((True, 1.5), (False, 6.0)):
        opened.window.state.light_edit = LightEdit(metered=metered)
        opened.key(glfw.KEY_S, ctrl=True)
        assert read_session(path).document.light_edit.metered is metered
        opened.light("ring")
        opened.drop(path)
        opened.answer("Replace it")
        assert level(opened) == pytest.approx(shown_level)
        assert not opened.window.state.is_unsaved()


def press_undo(hand):
    hand.hold(glfw.KEY_Z, glfw.MOD_CONTROL)
    hand.release(glfw.KEY_Z)
    hand.frames(2)


def test_undo_takes_a_level_back_that_still_waits_and_nothing_before_it(busy, relighter):
    state = busy.window.state
    state.light_edit = LightEdit(level_ev=2.0)
    busy.frames(2)
    press_as_photo(busy)
    busy.frames(2)
    press_undo(busy)
    relighter.gate.set()
    busy.settle()
    assert state.light_edit.level_ev == 2.0
    press_undo(busy)
    assert (state.light_edit.level_ev, state.history.can_redo) == (0.0, True)


def test_resetting_everything_ends_the_wait_for_a_level(busy, relighter):
    busy.window.state.light_edit = LightEdit(level_ev=2.0)
    busy.frames(2)
    press_as_photo(busy)
    busy.frames(2)
    busy.window.state.reset()
    relighter.gate.set()
    busy.settle()
    assert busy.window.state.light_edit == LightEdit()
