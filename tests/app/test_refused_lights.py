"""A light that can't be had leaves the one before as it was set, with what was added to it meanwhile."""

from dataclasses import replace

import pytest
from opened_things import SKY, open_light, refuse_light

from app.document.document import Document, LightRef
from app.engine.snapshot import Snapshot
from app.engine.sources import LightSource
from app.ui.state import EditorState
from relight_core.lighting.light_edit import LightEdit
from relight_core.lighting.soft_box import SoftBox

MINE, THEIRS, LATER = SoftBox(azimuth_deg=10.0), SoftBox(azimuth_deg=-120.0), SoftBox(azimuth_deg=80.0)
SET = LightEdit(level_ev=2.0, warmth=0.5, base=0.5, boxes=(MINE,))
OTHER_SKY = LightSource("panorama", "/lights/other.hdr")


@pytest.fixture
def state():
    """Rembrandt as it was drawn last, set otherwise and turned since."""
    state = EditorState()
    state.accept(Snapshot(light=open_light(state.light)))
    state.light_edit = SET
    state.change(yaw_deg=20.0)
    return state


def use_saved_light(state):
    state.use_light(LightRef("panorama", SKY.name), LightEdit(level_ev=1.0, base=0.1, boxes=(THEIRS,)), -70.0)


def is_as_set(state):
    return state.light.name == "rembrandt" and (state.light_edit, state.edit.yaw_deg) == (SET, 20.0)


@pytest.mark.parametrize("ask", [use_saved_light, lambda state: state.open_light(SKY)])
def test_everything_is_as_it_was_set(state, ask):
    ask(state)
    refuse_light(state)
    assert is_as_set(state)


def test_soft_boxes_and_turn_of_meanwhile_stay_and_those_of_the_refused_light_leave(state):
    use_saved_light(state)
    state.light_edit = replace(state.light_edit, boxes=(THEIRS, LATER))
    state.turn(5.0)
    refuse_light(state)
    assert state.light_edit == replace(SET, boxes=(MINE, LATER))
    assert state.edit.yaw_deg == -65.0


def test_soft_boxes_that_went_along_are_as_they_were_moved_meanwhile(state):
    state.open_light(SKY)
    state.light_edit = replace(state.light_edit, boxes=(LATER,), base=0.7)
    refuse_light(state)
    assert state.light_edit == replace(SET, boxes=(LATER,), base=0.7)


def test_where_there_is_nothing_to_go_back_to_soft_boxes_stay_on_the_light_in_force(state):
    """As of a session, whose light replaces all that was set."""
    state.put_back(Document(light=LightRef("panorama", SKY.name), light_edit=LightEdit(base=0.1, boxes=(THEIRS,))))
    refuse_light(state)
    assert state.light.name == "rembrandt"
    assert (state.light_edit.boxes, state.light_edit.base) == ((THEIRS,), 0.1)


def test_lights_are_never_given_more_soft_boxes_than_fit(state):
    use_saved_light(state)
    boxes = tuple(SoftBox(azimuth_deg=float(turn)) for turn in range(16))
    state.light_edit = replace(state.light_edit, boxes=boxes)
    refuse_light(state)
    assert state.light_edit.boxes == (MINE, *boxes[:-1])


def test_of_two_refused_one_after_the_other_none_leaves_a_trace(state):
    use_saved_light(state)
    state.open_light(OTHER_SKY)
    refuse_light(state)
    assert is_as_set(state)


def test_a_file_that_can_not_be_read_again_leaves_what_is_set_meanwhile(state):
    state.open_light(state.light)
    state.light_edit = replace(SET, level_ev=3.0)
    refuse_light(state)
    assert state.light_edit.level_ev == 3.0


def test_a_light_that_came_is_the_one_that_later_ones_fall_back_to(state):
    state.open_light(SKY)
    state.accept(replace(state.snapshot, light=open_light(state.light)))
    state.light_edit = LightEdit(tint=0.3)
    state.open_light(OTHER_SKY)
    refuse_light(state)
    assert (state.light.name, state.light_edit) == (SKY.name, LightEdit(tint=0.3))
