"""What waits for a finished picture gets just that one: the photo, the light and the settings it was asked for with."""

from dataclasses import replace
from pathlib import Path

import pytest
from opened_things import open_light, opened_for

from app.engine.snapshot import Message, Picture, Snapshot
from app.engine.sources import LightSource, PhotoSource
from app.ui.state import EditorState
from app.window.finished import Finished
from relight_core.lighting.light_edit import LightEdit


@pytest.fixture
def state():
    state = EditorState()
    state.open_photo(Path("/photos/us.jpg"))
    state.light_edit = LightEdit(warmth=0.5)
    state.change(yaw_deg=30.0, exposure_ev=1.0)
    return state


@pytest.fixture
def finished(state, said):
    return Finished(state, lambda text, is_error: said.append((text, is_error)))


def published(state, **changes):
    """The engine's answer to what is wanted now, but for these changes of the picture."""
    opened, light = opened_for(state.photo), replace(open_light(state.light), edit=state.light_edit)
    picture = Picture(opened, light, state.request_at_rest().edit, None, None, opened.screen, {})
    return Snapshot(opened=opened, light=light, picture=replace(picture, **changes))


def others(state):
    """Changes that make another picture of the one that is wanted."""
    right = published(state).picture
    return (
        {"is_stale": True},
        {"opened": opened_for(PhotoSource(state.photo.path))},
        {"light": replace(right.light, edit=LightEdit())},
        {"light": replace(right.light, is_draft=True)},
        {"light": replace(right.light, source=LightSource("rig", "ring"))},
        {"edit": replace(right.edit, yaw_deg=31.0)},
        {"edit": replace(right.edit, channels=())},
    )


@pytest.mark.parametrize("index", range(7))
def test_no_other_picture_than_the_one_that_was_asked_for_is_handed_out(state, finished, said, index):
    given = []
    finished.then(given.append)
    finished.hand_out(published(state, **others(state)[index]), is_idle=False)
    assert given == []
    right = published(state)
    finished.hand_out(right, is_idle=True)
    assert (given, said) == ([right.picture], [])


def test_the_engine_is_asked_for_what_waits_longest_and_then_for_what_is_wanted_now(state, finished):
    given, first, newest = [], state.request_at_rest(), published(state)
    finished.then(lambda _: given.append("first"))
    state.change(yaw_deg=60.0)
    finished.then(lambda _: given.append("second"), makes_file=False)
    assert finished.wanted(state.request()) == first
    finished.hand_out(newest, is_idle=True)
    assert (given, finished.is_making_files) == (["first"], False)
    assert finished.wanted(state.request()).edit.yaw_deg == 60.0
    finished.hand_out(published(state), is_idle=True)
    assert (given, finished.wanted(first)) == (["first", "second"], first)


@pytest.mark.parametrize(
    ("makes_file", "refused", "told"),
    [
        (True, "photo", "Nothing was saved: us.jpg can't be opened\nno pixels"),
        (False, "light", "Nothing was changed: the light Rembrandt can't be had\nno pixels"),
        (True, None, "Nothing was saved: this picture can't be relit"),
    ],
)
def test_what_will_never_come_is_told_with_the_reason(state, finished, said, makes_file, refused, told):
    given, given_up = [], []
    finished.then(given.append, makes_file, lambda: given_up.append(True))
    assert finished.is_making_files is makes_file
    wishes = frozenset({getattr(state, refused)}) if refused else frozenset()
    finished.hand_out(Snapshot(refused=wishes, message=Message(1, "no pixels", True)), is_idle=True)
    assert (given, given_up, said, finished.failures) == ([], [True], [(told, True)], 1)
    assert not finished.is_making_files


def test_what_is_no_fault_is_no_reason(state, finished, said):
    finished.then(print)
    refused = frozenset({state.photo})
    finished.hand_out(Snapshot(refused=refused, message=Message(1, "Saved it")), is_idle=True)
    assert said == [("Nothing was saved: us.jpg can't be opened", True)]
