"""The action table: complete, without clashes, and what the palette finds in it."""

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from app.engine.snapshot import OpenPhoto, Snapshot
from app.engine.sources import LightSource, PhotoSource
from app.ui.actions.action import Action, Chord, matching, parse_chord
from app.ui.actions.action_table import ACTIONS, GESTURES
from app.ui.actions.help_overlay import groups
from app.ui.actions.light_actions import light_actions
from app.ui.asking import Question
from app.ui.light_edits import AimTool
from app.ui.light_list import Shelf
from app.ui.photo_queue import PhotoQueue
from app.ui.state import EditorState
from app.window.offers import saved_session_offer
from app.window.replacing import write_or_ask
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.lighting.light_edit import LightEdit
from relight_core.lighting.soft_box import SoftBox

NAMED_KEYS = {
    "Left",
    "Right",
    "Up",
    "Down",
    "Space",
    "Escape",
    "Enter",
    "PageDown",
    "PageUp",
    "Tab",
    "F1",
    "F6",
    "F7",
    "F8",
    "F9",
    "Home",
    "Delete",
}


def on(keys):
    """The action of a key."""
    (action,) = (action for action in ACTIONS if keys in action.keys)
    return action


def named(name):
    return next(action for action in ACTIONS if action.name == name)


def test_panels_that_were_hidden_one_by_one_stay_so_when_all_the_others_come_back():
    state = EditorState()
    on("F7").run(state)
    on("Tab").run(state)
    assert (state.panels.filmstrip, state.panels.light, state.panels.effects) == (False, False, False)
    on("Tab").run(state)
    assert (state.panels.filmstrip, state.panels.light, state.panels.effects) == (True, False, True)


def test_panels_that_were_all_hidden_one_by_one_all_come_back():
    state = EditorState()
    for keys in ("Tab", "F6", "Tab", "Tab", "F6", "F7", "F8", "F7", "F8", "Tab"):
        on(keys).run(state)
    assert (state.panels.filmstrip, state.panels.light, state.panels.effects) == (True, True, True)


def test_no_two_actions_share_a_key_or_a_name():
    chords = [chord for action in ACTIONS for chord in action.chords]
    assert len(chords) == len(set(chords))
    names = [action.name for action in ACTIONS]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("action", ACTIONS, ids=lambda action: action.name)
def test_every_action_has_a_key_that_exists_and_words(action):
    assert action.keys
    for chord in action.chords:
        assert chord.key in NAMED_KEYS or len(chord.key) == 1
        assert chord.key == chord.key.upper() or chord.key in NAMED_KEYS
    assert len(action.help) > 8
    assert not action.help.endswith(".")


def test_chords_parse_and_read_well():
    assert parse_chord("Ctrl+Shift+Z") == Chord("Z", ctrl=True, shift=True)
    assert parse_chord("Ctrl+Shift+Z").label == "Ctrl + Shift + Z"
    assert parse_chord("=").label == "+"
    for bad in ("", "Ctrl+", "Hyper+A"):
        with pytest.raises(ValueError):
            parse_chord(bad)


def test_the_palette_prefers_names_that_start_with_what_was_typed():
    def act(name, help_text, let_go=None):
        return Action(name, "Group", ("A",), help_text, lambda state: None, let_go=let_go)

    words, start = act("Make it larger", "about zoom"), act("Zoom in", "larger")
    middle, held = act("Smooth zoom", "slower"), act("Zoom while held", "x", let_go=lambda state: None)
    assert matching([words, middle, start, held], "ZOOM") == [start, middle, words]
    assert matching([words, middle, start], "larger zoom") == [words, start]
    assert matching([words, start], "  ") == [words, start]
    assert matching([words, start], "nothing of the kind") == []


def test_what_tells_of_certain_pictures_brings_one_into_sight():
    state = EditorState()
    named("False colour").run(state)
    assert state.shown == "specular"
    state.shown = "shadow"
    for _ in range(2):
        named("False colour").run(state)
    assert state.shown == "shadow"
    named("Difference to the photo").run(state)
    assert state.shown == "result"
    named("False colour").run(state)
    assert state.shown == "result"


def test_letters_inside_a_word_of_the_help_find_nothing():
    inside = Action("Alpha", "G", ("A",), "The whole picture", print)
    assert matching([inside], "ture") == []
    assert matching([inside], "pict") == [inside]


def test_what_begins_a_word_comes_before_what_stands_inside_one():
    inside = Action("Fit the picture", "G", ("A",), "As large as it goes", print)
    told = Action("Play", "G", ("B",), "The light turns by itself", print)
    begins = Action("Let it turn", "G", ("C",), "Once round", print)
    assert matching([inside, told, begins], "tur") == [begins, inside, told]


def test_the_palette_finds_common_wishes():
    found = {typed: matching(ACTIONS, typed)[0].name for typed in ("albedo", "fit", "reset", "png", "exp")}
    assert found.pop("exp").startswith("Export")
    assert found.pop("png") == "Export the picture"
    assert found == {"albedo": "Show albedo", "fit": "Fit the picture", "reset": "Reset all"}


def test_the_palette_finds_bundled_lights_and_those_used_last_by_name():
    state = EditorState(extra_lights=[LightSource("panorama", "/lights/old-hall.hdr")])
    shelf = Shelf(("neon", "ring"), lambda name: (name, "Two gelled tubes." if name == "neon" else ""))
    lights = light_actions(state, shelf)
    neon, used = (matching((*ACTIONS, *lights), typed)[0] for typed in ("neon", "old-h"))
    assert (neon.name, neon.help, neon.label, used.name) == ("Light: Neon", "Two gelled tubes", "", "Light: old-hall")
    assert not neon.is_on(state)
    neon.run(state)
    assert (state.light.kind, state.light.name) == ("rig", "neon")
    assert neon.is_on(state)
    used.run(state)
    assert state.light is state.extra_lights[0]


def test_the_overview_shows_every_action_and_gesture():
    rows = [row for group in groups().values() for row in group]
    assert {action.name for action in ACTIONS} <= {words for _, words in rows}
    assert len(rows) == len(ACTIONS) + len(GESTURES)


def test_no_line_of_the_overview_can_be_broken_within_a_word():
    # Dear ImGui also breaks a line behind a full stop with a letter right after it, as in ".exr".
    words = [words for group in groups().values() for _, words in group]
    assert [line for line in words if re.search(r"[.,;!?]\w", line)] == []


def test_actions_work_on_the_state_alone():
    state = EditorState()
    named("Turn the panorama right").run(state)
    assert state.edit.yaw_deg == 5.0
    named("See the photo").run(state)
    assert state.before
    named("See the photo").let_go(state)
    assert not state.before
    assert not named("Export the picture").available(state)
    assert not named("Wipe").available(state)
    assert not named("Side by side").available(state)


@pytest.mark.parametrize(
    ("keys", "turned_deg"), [("Left", -5.0), ("Right", 5.0), ("Shift+Left", -1.0), ("Shift+Right", 1.0)]
)
def test_the_arrow_keys_turn_the_light(keys, turned_deg):
    state = EditorState()
    on(keys).run(state)
    assert state.edit.yaw_deg == turned_deg


def test_the_arrow_keys_raise_the_soft_box_that_is_selected():
    state = EditorState(light_edit=LightEdit(boxes=(SoftBox(0.0, 10.0), SoftBox(0.0, 20.0))), selected_box=1)
    for keys, elevation_deg in (("Up", 25.0), ("Down", 20.0), ("Shift+Up", 21.0), ("Shift+Down", 20.0)):
        on(keys).run(state)
        assert [box.elevation_deg for box in state.light_edit.boxes] == [10.0, elevation_deg]


def test_escape_ends_what_follows_the_mouse_or_turns_by_itself_before_it_answers():
    state, given = EditorState(aim=AimTool("bright"), playing=True), []
    state.asking.ask(Question("asked", "A question.", (("No", lambda: given.append("No")),), calling_off="No"))
    on("Escape").run(state)
    assert (state.aim.target, state.playing, given) == ("", False, [])
    on("Escape").run(state)
    assert given == ["No"]


def test_enter_and_escape_answer_what_was_asked_last_and_the_same_is_asked_once():
    state, given = EditorState(), []
    for key in ("first", "second", "second"):
        choices = tuple((label, lambda said=(key, label): given.append(said)) for label in ("Yes", "No"))
        state.asking.ask(Question(key, "A question.", choices, calling_off="No"))
    on("Escape").run(state)
    assert given == [("second", "No")]
    state.asking.ask(Question("third", "Another.", (("Go on", lambda: given.append("Go on")),)))
    on("Enter").run(state)
    assert given[1:] == ["Go on"]
    assert [question.key for question in state.asking.questions] == ["first"]


@pytest.mark.parametrize(("keys", "field", "value"), [("W", "compare", "wipe"), ("V", "scope", "waveform")])
def test_what_is_chosen_again_is_switched_off(keys, field, value):
    state = EditorState()
    for expected in (value, "off"):
        on(keys).run(state)
        assert getattr(state.look, field) == expected


def test_delete_takes_the_face_s_box_while_those_are_in_sight():
    state = EditorState(light_edit=LightEdit(boxes=(SoftBox(),)), selected_box=0)
    state.open_photo(Path("/photos/us.jpg"))
    faces = (FaceBox(0, 0, 20, 20), FaceBox(20, 0, 40, 20))
    photo = Photo(np.zeros((40, 80, 3), np.float32))
    state.accept(Snapshot(opened=OpenPhoto(state.photo, photo, None), faces=faces))
    on("Shift+F").run(state)
    assert not on("Delete").available(state)
    state.faces.selected = 1
    on("Delete").run(state)
    assert (state.photo.boxes, len(state.light_edit.boxes)) == (faces[:1], 1)
    on("Enter").run(state)
    on("Delete").run(state)
    assert (state.photo.boxes, state.light_edit.boxes) == (faces[:1], ())


def test_a_rotation_that_plays_can_be_stopped_where_there_is_no_picture():
    state = EditorState()
    assert not named("Play the rotation").available(state)
    state.playing = True
    assert named("Play the rotation").available(state)


def test_a_panorama_alone_is_metered_and_no_shadow_is_shown_where_none_was_taken_off():
    rig, panorama = EditorState(), EditorState(light=LightSource("panorama", "/lights/sky.hdr"))
    assert [named("Meter the light").available(state) for state in (rig, panorama)] == [False, True]
    opened = OpenPhoto(PhotoSource(Path("me.jpg")), Photo(np.zeros((4, 8, 3), np.float32)), None)
    for channels, is_there in (({"albedo": None}, False), ({"foreign_shadow": None}, True)):
        state = EditorState(snapshot=Snapshot(opened=opened, picture=SimpleNamespace(opened=opened, channels=channels)))
        assert named("Show shadow taken off").available(state) is is_there


def test_only_a_photo_that_is_there_can_be_stepped_to():
    state = EditorState(queue=PhotoQueue((Path("a.jpg"), Path("b.jpg"))))
    ahead, back = named("Next photo"), named("Previous photo")
    assert (ahead.available(state), back.available(state)) == (True, False)
    ahead.run(state)
    assert (ahead.available(state), back.available(state)) == (False, True)


def test_faces_are_found_again_only_once_the_photo_is_there():
    state = EditorState()
    state.open_photo(Path("/photos/us.jpg"))
    state.photo = replace(state.photo, boxes=(FaceBox(0, 0, 20, 20),))
    assert not named("Find the faces again").available(state)
    state.accept(Snapshot(opened=OpenPhoto(state.photo, Photo(np.zeros((40, 80, 3), np.float32)), None)))
    assert named("Find the faces again").available(state)


def test_escape_calls_off_what_can_be_and_answers_nothing_else(tmp_path):
    """A file that is there already is asked about; of work that was kept, no answer changes nothing."""
    state, path = EditorState(), tmp_path / "me.png"
    path.write_bytes(b"older")
    write_or_ask(state.asking, path, lambda place, _: place.write_bytes(b"newer"))
    offer = saved_session_offer(tmp_path / "me.jpg", tmp_path / "me.relight.json", lambda: None, lambda: None)
    state.asking.ask(offer)
    for _ in range(2):
        named("Close or put away").run(state)
        assert state.asking.questions == [offer]
    assert [file.name for file in tmp_path.iterdir()] == ["me.png"]
    assert path.read_bytes() == b"older"
