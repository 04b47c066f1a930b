"""The light in the editor's state: its level, another one in its place, soft boxes and its own lamps."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from opened_things import SKY, open_light, open_wish, opened_photo, refuse_photo

from app.document.document import LightRef
from app.engine.snapshot import Snapshot
from app.engine.sources import LightSource, PhotoSource
from app.ui import light_edits
from app.ui.actions.action_table import ACTIONS
from app.ui.light_list import Shelf, lights_to_choose
from app.ui.panels.light_panel import tooltip
from app.ui.state import EditorState
from relight_core.lighting.light_edit import LightEdit
from relight_core.lighting.soft_box import SoftBox
from relight_core.lighting.sphere import turned


def test_panoramas_are_metered_and_other_lights_are_not():
    state = EditorState()
    for light, metered in ((SKY, True), (LightSource("portrait", "/p/you.jpg"), False), (LightSource("own"), False)):
        state.choose_light(light)
        assert state.light_edit == LightEdit(metered=metered)
    state.use_light(LightRef("panorama", SKY.name), LightEdit(warmth=0.5), 0.0)
    assert state.light_edit == LightEdit(warmth=0.5), "what was saved says whether it is metered"


def test_reset_puts_a_panorama_back_as_it_was_opened():
    state = EditorState()
    state.choose_light(SKY)
    light_edits.meter_light(state)
    state.light_edit = replace(state.light_edit, level_ev=1.0, boxes=(SoftBox(),))
    assert not state.light_edit.metered
    state.reset()
    assert state.light_edit == LightEdit(metered=True)


@pytest.fixture
def matched():
    """A state, and what is in sight: a picture whose face wants -0.734 stops under a light that is a stop up."""
    state, opened = EditorState(), opened_photo(Path("/p/me.png"))
    light = replace(open_light(state.light), edit=LightEdit(level_ev=1.0))
    state.photo, state.light_edit = opened.source, LightEdit(level_ev=3.0)
    return state, SimpleNamespace(opened=opened, light=light, relit=relit_that_wants(-0.734))


def relit_that_wants(stops):
    return SimpleNamespace(level_as_in_photo_ev=lambda most=4.0: min(max(stops, -most), most))


def test_the_level_follows_the_face(matched):
    light_edits.match_face(*matched)
    assert matched[0].light_edit.level_ev == 0.27


@pytest.mark.parametrize(("wanted", "level_ev"), [(-8.5, -7.5), (-19.0, -10.0), (30.0, 10.0)])
def test_the_level_follows_the_face_as_far_as_its_slider_goes(matched, wanted, level_ev):
    state, picture = matched
    picture.relit = relit_that_wants(wanted)
    light_edits.match_face(state, picture)
    assert state.light_edit.level_ev == level_ev


@pytest.mark.parametrize("other", [{"photo": PhotoSource(Path("/p/you.png"))}, {"light": LightSource("rig", "ring")}])
def test_no_level_is_set_by_a_picture_of_another_photo_or_light(matched, other):
    state, picture = matched
    for name, wish in other.items():
        setattr(state, name, wish)
    light_edits.match_face(state, picture)
    assert state.light_edit.level_ev == 3.0


def test_another_light_keeps_the_soft_boxes_and_undo_takes_it_back_in_one_step():
    state = EditorState()
    state.accept(Snapshot(opened=opened_photo(Path("/p/me.png")), light=open_light(state.light)))
    state.photo = state.snapshot.opened.source
    state.remember(0.0)
    state.light_edit = LightEdit(level_ev=1.0, base=0.3, boxes=(SoftBox(azimuth_deg=70.0),))
    state.remember(2.0)
    state.choose_light(LightSource("rig", "ring"))
    assert state.light_edit == LightEdit(base=0.3, boxes=(SoftBox(azimuth_deg=70.0),))
    state.accept(replace(state.snapshot, light=open_light(state.light)))
    state.remember(4.0)
    assert state.history.steps[-1].name == "Light: Ring"
    state.restore(state.history.undo())
    assert (state.light.name, state.light_edit.level_ev, len(state.light_edit.boxes)) == ("rembrandt", 1.0, 1)


def test_without_soft_boxes_another_light_comes_as_it_is():
    state = EditorState()
    state.light_edit = LightEdit(base=0.3, warmth=0.5)
    state.choose_light(LightSource("rig", "ring"))
    assert state.light_edit == LightEdit()


def test_all_soft_boxes_go_at_once_and_the_room_is_whole_again():
    state = EditorState()
    state.accept(Snapshot(opened=opened_photo(Path("/p/me.png")), light=open_light(state.light)))
    state.photo = state.snapshot.opened.source
    state.remember(0.0)
    state.light_edit = LightEdit(base=0.0, tint=0.5, boxes=(SoftBox(), SoftBox(azimuth_deg=70.0)))
    state.remember(1.0)
    light_edits.delete_boxes(state)
    assert state.light_edit == LightEdit(tint=0.5)
    state.remember(3.0)
    assert state.history.steps[-1].name == "Remove all soft boxes"


def test_the_lights_own_lamps_become_soft_boxes_and_go_with_it():
    state, added = EditorState(), SoftBox(azimuth_deg=70.0, intensity=3.0)
    assert not light_edits.has_lamps(state), "as long as nobody has read the light"
    state.accept(Snapshot(light=open_light(state.light, (SoftBox(name="fill", intensity=0.1), SoftBox(name="key")))))
    assert light_edits.has_lamps(state)
    state.light_edit = LightEdit(boxes=(added,))
    light_edits.switch_lamps(state)
    assert [box.name for box in state.light_edit.boxes] == ["fill", "key", ""]
    assert (state.light_edit.apart, state.selected_box) == (True, 1)
    before = state.light_edit
    light_edits.switch_lamps(state)
    assert (state.light_edit, state.selected_box) == (LightEdit(boxes=(added,)), -1)
    state.light_edit = before
    state.choose_light(LightSource("rig", "overcast"))
    assert state.light_edit == LightEdit(boxes=(added,))
    assert not light_edits.has_lamps(state)


def test_what_is_no_lamp_of_the_light_that_is_there_came_as_a_new_soft_box_does():
    state, key = EditorState(), SoftBox(name="key", kelvin=5000.0)
    state.snapshot = Snapshot(light=open_light(state.light, (SoftBox(name="fill", kelvin=4000.0), key)))
    assert light_edits.as_it_came(state, replace(key, kelvin=7000.0)) == key
    assert light_edits.as_it_came(state, SoftBox(kelvin=7000.0)) == SoftBox()
    state.choose_light(LightSource("rig", "split"))
    assert light_edits.as_it_came(state, key) == SoftBox(), "it is another light's"


def test_adjustments_are_reset_and_lamps_stay_as_they_are():
    state, lamps = EditorState(), (SoftBox(name="key", intensity=2.0), SoftBox(azimuth_deg=70.0))
    state.choose_light(SKY)
    state.light_edit = LightEdit(level_ev=1.0, warmth=0.5, base=0.5, boxes=lamps, apart=True)
    assert light_edits.is_adjusted(state)
    light_edits.reset_adjustments(state)
    assert state.light_edit == LightEdit(boxes=lamps, apart=True, metered=True)
    assert not light_edits.is_adjusted(state)


def added_boxes(state, yaw_deg, count):
    """Where the newest of a light's soft boxes are seen after some more were added: right, up and toward the camera."""
    add = next(action for action in ACTIONS if action.name == "Add a soft box")
    for _ in range(count):
        add.run(state)
    return [turned(box.direction, yaw_deg) for box in state.light_edit.boxes[-count:]]


@pytest.mark.parametrize("yaw_deg", [0.0, 120.0])
def test_a_soft_box_is_added_in_front_on_the_left_above_however_the_light_is_turned(yaw_deg):
    state = EditorState()
    state.turn(yaw_deg)
    ((right, up, toward),) = added_boxes(state, yaw_deg, 1)
    assert right < -0.3
    assert up > 0.3
    assert toward > 0.3
    assert state.selected_box == 0
    assert state.light_edit.boxes[0].intensity < 1.0, "skin would blow out at once"
    added_boxes(state, yaw_deg, 20)
    assert len(state.light_edit.boxes) == 16


def test_soft_boxes_that_are_added_one_after_the_other_stand_apart():
    state = EditorState()
    state.turn(70.0)
    places = added_boxes(state, 70.0, 4)
    assert np.sign(places).tolist() == [[-1, 1, 1], [1, 1, 1], [-1, 1, -1], [1, 1, -1]]
    state.selected_box = 1
    light_edits.delete_box(state)
    np.testing.assert_allclose(added_boxes(state, 70.0, 2), [places[1], places[0]], atol=1e-6)


def test_a_soft_box_that_is_deleted_leaves_none_selected():
    boxes = tuple(SoftBox(azimuth_deg=azimuth_deg) for azimuth_deg in (0.0, 40.0, 80.0))
    state = EditorState(light_edit=LightEdit(boxes=boxes), selected_box=1)
    for _ in range(2):
        light_edits.delete_box(state)
    assert (state.light_edit.boxes, state.selected_box) == ((boxes[0], boxes[2]), -1)


def test_a_soft_box_is_switched_off_and_on_again_and_none_that_is_gone():
    state = EditorState(light_edit=LightEdit(boxes=(SoftBox(), SoftBox(30.0))), selected_box=1)
    for off in (True, False):
        light_edits.switch_box(state)
        assert [box.off for box in state.light_edit.boxes] == [False, off]
    state.selected_box = 2
    assert not light_edits.has_box(state)


def test_undo_takes_back_a_level_that_its_picture_has_yet_to_tell_and_nothing_else():
    state = EditorState()
    assert not light_edits.can_undo(state)
    state.change(shadow=0.5)
    state.asking.level = object()
    assert light_edits.can_undo(state)
    light_edits.undo(state)
    assert (state.asking.level, state.edit.shadow) == (None, 0.5)
    assert not light_edits.can_undo(state)


def test_a_soft_box_is_raised_to_straight_above_and_no_further():
    state = EditorState()
    light_edits.raise_box(state, 5.0)
    state.light_edit = LightEdit(boxes=(SoftBox(), SoftBox(30.0, 80.0)))
    light_edits.raise_box(state, 5.0)
    assert state.light_edit == LightEdit(boxes=(SoftBox(), SoftBox(30.0, 80.0))), "none is selected"
    state.selected_box = 1
    for elevation_deg in (85.0, 90.0, 90.0):
        light_edits.raise_box(state, 5.0)
        assert state.light_edit.boxes == (SoftBox(), SoftBox(30.0, elevation_deg))
    light_edits.raise_box(state, -200.0)
    assert state.light_edit.boxes[1].elevation_deg == -90.0


def test_lamps_that_would_be_too_many_stay_where_they_are():
    state = EditorState()
    state.accept(Snapshot(light=open_light(state.light, (SoftBox(name="key"), SoftBox(name="fill")))))
    state.light_edit = full = LightEdit(boxes=(SoftBox(),) * 15)
    light_edits.switch_lamps(state)
    assert state.light_edit == full
    assert "16 soft boxes" in state.asking.notices[0][0]
    state.light_edit = LightEdit(boxes=(SoftBox(),) * 14)
    light_edits.switch_lamps(state)
    assert len(state.light_edit.boxes) == 16
    light_edits.delete_boxes(state)
    assert state.light_edit == LightEdit()


def test_a_light_from_a_file_can_be_taken_off_the_list_unless_it_is_in_use():
    state = EditorState()
    used, other = LightSource("panorama", "used.exr"), LightSource("portrait", "friend.jpg")
    state.extra_lights, state.light = [used, other], used
    assert tooltip(state, other, "Words.") == "friend\nWords. Right-click takes it off this list."
    assert tooltip(state, used, "Words.") == "used\nWords."
    state.forget_light(used)
    state.forget_light(LightSource("portrait", "friend.jpg"))
    assert state.extra_lights == [used]


@pytest.fixture
def listed():
    """The kinds of the lights in the list of a state."""
    shelf = Shelf(("rembrandt", "rim"), lambda name: (name, ""))
    return lambda state: [light.kind for light, _ in lights_to_choose(state, shelf)]


def test_the_photo_s_own_light_is_listed_from_the_moment_its_photo_is_asked_for(listed, tmp_path):
    state = EditorState()
    assert listed(state) == ["rig", "rig"]
    state.open_photo(tmp_path / "me.jpg")
    assert listed(state) == ["own", "rig", "rig"]
    open_wish(state)
    assert listed(state) == ["own", "rig", "rig"]


@pytest.mark.parametrize(("chosen", "kinds"), [("rig", ["rig", "rig"]), ("own", ["own", "rig", "rig"])])
def test_the_own_light_of_a_photo_that_is_refused_is_listed_only_while_it_is_chosen(listed, tmp_path, chosen, kinds):
    state = EditorState()
    state.open_photo(tmp_path / "me.jpg")
    state.choose_light(LightSource(chosen, "rim" if chosen == "rig" else ""))
    refuse_photo(state)
    assert listed(state) == kinds
