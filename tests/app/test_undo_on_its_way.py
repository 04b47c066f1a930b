"""An undo whose photo has come, and what the user does before the next light has."""

from dataclasses import replace
from pathlib import Path

import pytest
from live_editor import Editor
from opened_things import open_wish, opened_for

from app.engine.sources import LightSource, PhotoSource
from app.ui.open_work import Undoing

A, B = PhotoSource(Path("/photos/a.png")), PhotoSource(Path("/photos/b.png"))
SPLIT, RING = LightSource("rig", "split"), LightSource("rig", "ring")


@pytest.mark.parametrize(
    ("photo", "light", "at_work", "in_force", "is_coming"),
    [
        (A, SPLIT, False, False, True),
        (A, SPLIT, True, False, True),
        (A, SPLIT, True, True, False),
        (A, RING, True, False, False),
        (A, RING, False, False, True),
        (B, SPLIT, False, False, False),
    ],
)
def test_an_undo_is_coming_until_its_photo_and_its_light_are_there(photo, light, at_work, in_force, is_coming):
    assert Undoing(0, A, SPLIT).is_coming(photo, light, at_work, in_force) == is_coming


@pytest.mark.parametrize(
    ("photo", "light", "is_refused"), [(A, RING, True), (B, SPLIT, True), (B, RING, False), (None, RING, False)]
)
def test_an_undo_is_refused_with_a_wish_of_its_own_that_is_still_wanted(photo, light, is_refused):
    assert Undoing(0, A, SPLIT).is_refused(photo, light, {A, B, SPLIT, RING}) == is_refused


def test_a_light_chosen_since_an_undo_is_no_part_of_it_and_goes_along_to_the_next_photo():
    editor = Editor(None)
    state = editor.state
    for name in ("a", "b"):
        state.open_photo(Path(f"/photos/{name}.png"))
        editor.live()
    state.choose_light(LightSource("rig", "neon"))
    editor.live()
    state.restore(state.history.go(0))
    state.choose_light(LightSource("rig", "golden-hour"))
    open_wish(state)
    state.remember(editor.now_s)
    state.change(shadow=0.3)
    state.open_photo(Path("/photos/c.png"))
    assert (state.light.name, state.edit.shadow) == ("golden-hour", 0.3)
    left = state.works[Path("/photos/a.png")].left
    assert (left.light.name, left.edit.shadow) == ("golden-hour", 0.3)


def test_a_photo_that_was_still_being_read_when_it_was_undone_leaves_the_work_on_the_one_before_alone(tmp_path):
    editor = Editor(None)
    state = editor.state
    state.open_photo(Path("/photos/a.png"))
    editor.live()
    state.turn(40.0)
    editor.live()
    state.session_path = tmp_path / "a.relight.json"
    state.open_photo(Path("/photos/b.png"))
    wish = state.photo
    state.remember(editor.now_s)
    state.restore(state.history.undo())
    state.change(shadow=0.5)
    editor.now_s += 1.0
    state.remember(editor.now_s)
    state.accept(replace(state.snapshot, opened=opened_for(wish)))
    state.remember(editor.now_s)
    state.change(specular=0.5)
    editor.live()
    assert (state.photo.path, state.edit.shadow, state.edit.specular) == (Path("/photos/a.png"), 0.5, 0.5)
    assert (state.asking.questions, state.waiting) == ([], None)
    assert (state.session_path, state.is_unsaved()) == (tmp_path / "a.relight.json", True)
