"""The exposure follows the light until the hand has set it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.document.document import LightRef
from app.engine.snapshot import OpenLight, OpenPhoto, Picture, Snapshot
from app.engine.sources import LightSource, PhotoSource
from app.ui.metering import expose, exposure_in_sight, exposure_when_finished, follow_light, metering_note
from app.ui.state import EditorState
from relight_core.imaging.photo import Photo
from relight_core.lighting.environment import Environment
from relight_core.lighting.light_edit import LightEdit
from relight_core.lighting.soft_box import SoftBox

RING = LightSource("rig", "ring")
SUNNY = LightSource("panorama", "/lights/sunny.hdr")
NIGHT = LightSource("panorama", "/lights/night.exr")
METERED_EV = {"sunny": -1.62, "night": 2.2}


def open_light(source):
    even = Environment.from_radiance(np.ones((4, 8, 3)))
    metered_ev = METERED_EV.get(source.title, 0.0)
    return OpenLight(
        source, even, np.zeros((4, 8, 3), np.uint8), np.zeros((4, 4, 4), np.uint8), even, metered_ev=metered_ev
    )


@pytest.fixture
def state():
    """A photo and the first light are open, and the history has seen them."""
    state = EditorState()
    photo = Photo(np.full((4, 4, 3), 0.5, np.float32), path=Path("/p/me.png"))
    state.photo = PhotoSource(photo)
    opened = OpenPhoto(state.photo, photo, photo.linear.astype(np.float16))
    state.accept(Snapshot(opened=opened, light=open_light(state.light)))
    state.remember(0.0)
    return state


def choose(state, light, now_s=10.0):
    """Ask for a light, and get it some frames later."""
    state.choose_light(light)
    state.remember(now_s)
    state.accept(replace(state.snapshot, light=open_light(light)))
    state.remember(now_s + 0.1)


def names(state):
    return [step.name for step in state.history.steps[1:]]


def test_a_panorama_is_metered_and_a_rig_after_it_is_right_at_0(state):
    choose(state, SUNNY)
    assert state.edit.exposure_ev == -1.62
    choose(state, NIGHT)
    assert state.edit.exposure_ev == 2.2
    choose(state, RING)
    assert state.edit.exposure_ev == 0.0


def test_the_light_and_its_exposure_are_one_step(state):
    choose(state, SUNNY)
    assert names(state) == ["Light: sunny"]
    state.restore(state.history.undo())
    assert (state.light.name, state.edit.exposure_ev) == ("rembrandt", 0.0)
    state.restore(state.history.redo())
    assert (state.light.title, state.edit.exposure_ev) == ("sunny", -1.62)
    assert names(state) == ["Light: sunny"]


def test_what_the_hand_has_set_stays_under_other_lights(state):
    choose(state, SUNNY)
    expose(state, -0.5)
    for light in (NIGHT, RING, SUNNY):
        choose(state, light)
        assert state.edit.exposure_ev == -0.5


def test_undoing_the_hands_exposure_lets_it_follow_again(state):
    expose(state, 1.0)
    state.remember(5.0)
    state.restore(state.history.undo())
    choose(state, SUNNY)
    assert state.edit.exposure_ev == -1.62


def test_putting_the_slider_back_to_rest_lets_it_follow_again(state):
    choose(state, SUNNY)
    expose(state, 1.0)
    # A number that was typed in has gone through single precision.
    expose(state, float(np.float32(-1.62)))
    assert state.edit.exposure_ev == -1.62
    choose(state, RING)
    assert state.edit.exposure_ev == 0.0


def test_switched_off_it_stays_and_switched_on_it_meters(state):
    choose(state, SUNNY)
    follow_light(state, False)
    state.remember(20.0)
    choose(state, NIGHT, 30.0)
    assert state.edit.exposure_ev == -1.62
    follow_light(state, True)
    state.remember(40.0)
    assert state.edit.exposure_ev == 2.2
    assert names(state) == ["Light: sunny", "Exposure by hand", "Light: night", "Exposure +2.20 EV"]


def test_changing_the_light_does_not_meter_it_again(state):
    choose(state, SUNNY)
    for change in (LightEdit(level_ev=2.0), LightEdit(boxes=(SoftBox(intensity=4.0),))):
        state.light_edit = change
        bright = Environment.from_radiance(np.full((4, 8, 3), 9.0))
        state.accept(replace(state.snapshot, light=replace(state.snapshot.light, environment=bright, edit=change)))
        assert state.edit.exposure_ev == -1.62


def test_a_light_that_is_refused_leaves_the_exposure_of_the_one_before(state):
    choose(state, SUNNY)
    broken = LightSource("panorama", "/lights/broken.exr")
    state.choose_light(broken)
    state.accept(replace(state.snapshot, refused=frozenset({broken})))
    assert (state.light.title, state.edit.exposure_ev) == ("sunny", -1.62)


def test_reset_all_puts_the_exposure_where_the_light_wants_it(state):
    choose(state, SUNNY)
    state.change(shadow=0.3)
    expose(state, 3.0)
    state.remember(20.0)
    state.reset()
    state.remember(30.0)
    assert state.edit.exposure_ev == -1.62
    assert names(state)[-1] == "Reset all"
    choose(state, RING)
    assert state.edit.exposure_ev == 0.0


def test_a_session_comes_back_with_the_exposure_it_was_saved_with(state):
    saved = replace(
        state.document(), light=LightRef("panorama", SUNNY.name), edit=replace(state.edit, exposure_ev=-1.0)
    )
    state.open_session(saved, Path("/p/me.relight.json"))
    state.accept(replace(state.snapshot, light=open_light(SUNNY)))
    assert state.edit.exposure_ev == -1.0
    choose(state, NIGHT)
    assert state.edit.exposure_ev == 2.2


def test_the_light_the_window_is_opened_with_is_metered_and_is_no_unsaved_work(state):
    fresh = EditorState()
    fresh.choose_light(SUNNY)
    fresh.photo = state.photo
    fresh.accept(Snapshot(opened=state.snapshot.opened))
    fresh.accept(replace(state.snapshot, light=open_light(SUNNY)))
    assert fresh.edit.exposure_ev == -1.62
    assert not fresh.is_unsaved()


def picture_under(state, light):
    return Picture(state.snapshot.opened, open_light(light), state.edit, None, None, None, {})


def test_a_picture_keeps_its_exposure_until_the_one_under_the_new_light_is_there(state):
    choose(state, SUNNY)
    state.accept(replace(state.snapshot, picture=picture_under(state, SUNNY)))
    assert exposure_in_sight(state) == -1.62
    choose(state, RING)
    assert (state.edit.exposure_ev, exposure_in_sight(state)) == (0.0, -1.62)
    state.accept(replace(state.snapshot, picture=picture_under(state, RING)))
    assert exposure_in_sight(state) == 0.0


def test_a_file_asked_for_before_the_light_is_there_gets_the_metered_exposure(state):
    state.choose_light(SUNNY)
    exposure = exposure_when_finished(state)
    choose(state, NIGHT)
    assert exposure(picture_under(state, SUNNY)) == -1.62
    expose(state, 0.7)
    assert exposure_when_finished(state)(picture_under(state, NIGHT)) == 0.7


def test_the_status_line_says_what_was_metered_and_nothing_of_what_was_not(state):
    assert metering_note(state) == ""
    choose(state, SUNNY)
    assert metering_note(state) == "Exposure \N{MINUS SIGN}1.6 EV, metered for sunny"
    expose(state, 1.0)
    assert metering_note(state) == ""
