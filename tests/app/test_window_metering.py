"""The real window: a panorama dropped, metered, and set by hand."""

import glfw
import numpy as np
import pytest
from window_hand import close_to

from app.document.session_file import read_session
from relight_core.imaging.view_transform import apply_view
from relight_core.imaging.write import write_image


@pytest.fixture
def sunny(tmp_path):
    """A panorama four times as bright as the rigs."""
    write_image(tmp_path / "sunny.exr", np.full((16, 32, 3), 6.0, np.float32))
    return tmp_path / "sunny.exr"


def exposure_knob(hand):
    return hand.knobs()[4]


def test_a_dropped_panorama_is_shown_metered_and_undone_in_one_step(opened, sunny):
    state = opened.window.state
    opened.drop(sunny)
    assert state.edit.exposure_ev == -2.0
    assert close_to(opened.picture_pixels(96, 128), apply_view(state.snapshot.picture.relit.image, -2.0))
    opened.key(glfw.KEY_Z, ctrl=True)
    assert (state.light.name, state.edit.exposure_ev) == ("rembrandt", 0.0)
    assert close_to(opened.picture_pixels(96, 128), apply_view(state.snapshot.picture.relit.image))


def test_the_hand_takes_the_exposure_over_and_a_double_click_gives_it_back(opened, sunny):
    state = opened.window.state
    x, y = exposure_knob(opened)
    opened.drag((x, y), (x + 40, y))
    by_hand_ev = state.edit.exposure_ev
    assert by_hand_ev > 0.5
    opened.drop(sunny)
    assert state.edit.exposure_ev == by_hand_ev
    opened.double_click(exposure_knob(opened))
    assert state.edit.exposure_ev == -2.0
    opened.light("ring")
    assert state.edit.exposure_ev == 0.0


def test_the_switch_and_its_key_turn_metering_off_and_on(opened, sunny):
    state = opened.window.state
    x, y = opened.knobs()[4]
    auto = opened.width - 165, y - 17
    opened.click(auto)
    opened.drop(sunny)
    assert state.edit.exposure_ev == 0.0
    opened.click(auto)
    assert state.edit.exposure_ev == -2.0
    opened.key(glfw.KEY_A)
    opened.light("ring")
    assert state.edit.exposure_ev == -2.0


def test_a_soft_box_is_not_metered_away(opened, sunny):
    opened.drop(sunny)
    opened.double_click(opened.panorama(0.5))
    opened.drag(opened.panorama(0.5), opened.panorama(0.75))
    assert len(opened.window.state.light_edit.boxes) == 1
    assert opened.window.state.edit.exposure_ev == -2.0


def test_a_saved_session_knows_who_set_the_exposure(opened, sunny, photo_path):
    opened.drop(sunny)
    opened.key(glfw.KEY_S, ctrl=True)
    path = photo_path.with_name("person.relight.json")
    saved = read_session(path).document
    assert (saved.edit.exposure_ev, saved.exposure_follows) == (-2.0, True)
    opened.light("ring")
    opened.drop(path)
    state = opened.window.state
    assert state.edit.exposure_ev == -2.0
    assert not state.is_unsaved()
