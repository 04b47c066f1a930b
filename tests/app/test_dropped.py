"""What a dropped file becomes."""

import os
from pathlib import Path

import numpy as np
import pytest
from opened_things import open_wish, photo_files, refuse_photo

from app.document.document import Document, LightRef, PhotoRef
from app.document.light_file import SavedLight, write_light
from app.document.session_file import write_session
from app.ui.state import EditorState
from app.window.dropped import is_panorama, take_files
from relight_core.imaging.write import write_image
from relight_core.lighting.light_edit import LightEdit
from relight_core.pipeline.edit import Edit

ELSEWHERE = (500.0, 300.0)


@pytest.fixture
def state():
    return EditorState(light_panel=(0.0, 0.0, 255.0, 560.0))


def exr(path, height, width):
    write_image(path, np.ones((height, width, 3), np.float32))
    return path


def test_only_an_exr_twice_as_wide_as_high_is_a_panorama(tmp_path):
    assert is_panorama(exr(tmp_path / "a.exr", 8, 16))
    assert not is_panorama(exr(tmp_path / "b.exr", 8, 15))
    assert not is_panorama(exr(tmp_path / "d.exr", 8, 24))
    (tmp_path / "c.exr").write_bytes(b"junk")
    assert not is_panorama(tmp_path / "c.exr")
    assert is_panorama(Path("studio.HDR"))
    assert not is_panorama(Path("me.jpg"))


def test_a_photo_and_a_light_together_open_both(state, tmp_path):
    lamp = exr(tmp_path / "lamp.exr", 4, 8)
    take_files(state, [Path("me.jpg"), lamp], *ELSEWHERE)
    assert state.photo.path == Path("me.jpg")
    assert (state.light.kind, state.light.name) == ("panorama", str(lamp))


def test_what_falls_on_the_light_panel_is_a_light(state):
    for beside in ((254.0, 561.0), (256.0, 100.0)):
        take_files(state, [Path("me.jpg")], *beside)
        assert (state.photo.path, state.light.kind) == (Path("me.jpg"), "rig")
    take_files(state, [Path("friend.jpg")], 100.0, 100.0)
    assert state.photo.path == Path("me.jpg")
    assert (state.light.kind, state.light.name) == ("portrait", os.path.abspath("friend.jpg"))


def test_several_photos_and_folders_become_a_queue_without_what_is_no_photo(state, tmp_path):
    folder = tmp_path / "shoot"
    folder.mkdir()
    for name in ("b.jpg", "a.PNG", "notes.txt", ".hidden.jpg"):
        (folder / name).touch()
    take_files(state, [folder, Path("c.NEF"), Path("d.doc")], *ELSEWHERE)
    assert [path.name for path in state.queue.paths] == ["a.PNG", "b.jpg", "c.NEF"]
    assert state.photo.path.name == "a.PNG"
    assert "d.doc" in state.asking.notices[0][0]
    state.step_photo(1)
    state.step_photo(1)
    state.step_photo(1)
    assert state.photo.path.name == "c.NEF"
    assert state.queue.label == "3 of 3"
    state.step_photo(-1)
    assert state.photo.path.name == "b.jpg"


def test_an_empty_folder_and_a_bad_session_are_told_and_change_nothing(state, tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "x.relight.json").write_text("{")
    before = state.document()
    for path in (tmp_path / "empty", tmp_path / "x.relight.json"):
        take_files(state, [path], *ELSEWHERE)
        take_files(state, [path], 100.0, 100.0)
    assert len(state.asking.notices) == 4
    assert all(is_error and "\n" not in text for text, is_error in state.asking.notices)
    assert state.document() == before


def test_with_shift_a_portrait_lends_its_light_anywhere(state):
    take_files(state, [Path("friend.jpg")], *ELSEWHERE, as_light=True)
    assert state.photo is None
    assert (state.light.kind, state.light.name) == ("portrait", os.path.abspath("friend.jpg"))


def test_an_empty_folder_does_not_keep_what_was_dropped_with_it_from_opening(state, tmp_path):
    (tmp_path / "empty").mkdir()
    take_files(state, [tmp_path / "empty", Path("me.jpg")], *ELSEWHERE)
    assert state.photo.path == Path("me.jpg")
    ((text, is_error),) = state.asking.notices
    assert is_error
    assert "no photos in this folder" in text


def test_notes_that_a_library_keeps_beside_photos_do_not_keep_these_from_opening(state, tmp_path):
    notes = tmp_path / "b.jpg.json"
    notes.write_text('{"title": "b.jpg", "photoTakenTime": {"timestamp": "1"}}')
    lamp = exr(tmp_path / "lamp.exr", 4, 8)
    for beside in ([], [lamp]):
        take_files(state, [notes, Path("b.jpg"), *beside], *ELSEWHERE)
        assert state.photo.path == Path("b.jpg")
        assert "b.jpg.json" in state.asking.notices.pop()[0]
    assert state.light.name == str(lamp)


def test_what_is_no_photo_does_not_keep_the_one_that_was_dropped_with_it_from_opening(state):
    take_files(state, [Path("notes.doc"), Path("me.jpg")], *ELSEWHERE)
    assert state.queue.paths == (Path("me.jpg"),)
    assert "notes.doc left out" in state.asking.notices[0][0]


def test_panoramas_and_sessions_beyond_the_first_are_named(state, tmp_path):
    skies = [exr(tmp_path / f"{name}.exr", 4, 8) for name in ("dawn", "noon", "dusk")]
    sessions = [tmp_path / f"{name}.light.json" for name in ("one", "two")]
    for path in sessions:
        write_light(path, SavedLight(LightRef("rig", "ring"), LightEdit(), 0.0))
    take_files(state, [*skies, *sessions], *ELSEWHERE)
    assert state.light.name == str(skies[0])
    ((text, is_error),) = state.asking.notices
    assert is_error
    assert "two.light.json left out" in text
    assert "noon.exr and 1 more left out" in text


def test_the_original_light_of_a_session_is_that_of_its_photo_and_not_of_the_open_one(state, tmp_path):
    me = tmp_path / "me.jpg"
    me.write_bytes(b"pixels")
    path = tmp_path / "me.relight.json"
    write_session(path, Document(PhotoRef(me), LightRef("own"), LightEdit(warmth=0.5), Edit(yaw_deg=400.0)))
    state.open_photo(Path("other.jpg"))
    take_files(state, [path], 100.0, 100.0)
    assert state.photo.path == Path("other.jpg")
    assert (state.light.kind, state.light.name) == ("portrait", str(me))
    assert (state.light_edit, state.edit.yaw_deg) == (LightEdit(warmth=0.5), 40.0)
    ((text, is_error),) = state.asking.notices
    assert is_error
    assert "yaw_deg 400" in text


def test_a_photo_that_can_not_be_opened_leaves_the_queue_as_it_was(state):
    take_files(state, [Path("a.jpg"), Path("b.jpg")], *ELSEWHERE)
    open_wish(state)
    take_files(state, [Path("bad.jpg")], *ELSEWHERE)
    refuse_photo(state)
    assert state.photo.path == Path("a.jpg")
    assert state.queue.label == "1 of 2"
    state.step_photo(1)
    assert state.photo.path == Path("b.jpg")


def test_a_queue_goes_on_past_photos_that_can_not_be_opened(state):
    take_files(state, [Path("bad.jpg"), Path("worse.jpg"), Path("c.jpg")], *ELSEWHERE)
    refuse_photo(state)
    assert (state.photo, state.queue.label) == (None, "1 of 3")
    state.step_photo(1)
    refuse_photo(state)
    assert (state.photo, state.queue.label) == (None, "2 of 3")
    state.step_photo(1)
    open_wish(state)
    assert state.queue.label == "3 of 3"


def test_the_queue_claims_no_photo_that_can_not_be_opened(state):
    take_files(state, [Path("a.jpg"), Path("bad.jpg"), Path("c.jpg")], *ELSEWHERE)
    open_wish(state)
    state.step_photo(1)
    refuse_photo(state)
    assert (state.photo.path, state.queue.label) == (Path("a.jpg"), "1 of 3")
    state.step_photo(1)
    assert state.photo.path == Path("c.jpg")
    open_wish(state)
    state.step_photo(-1)
    assert state.photo.path == Path("bad.jpg"), "it may be there by now"
    refuse_photo(state)
    assert (state.photo.path, state.queue.label) == (Path("c.jpg"), "3 of 3")
    state.step_photo(-1)
    assert state.photo.path == Path("a.jpg")


def test_a_photo_dropped_together_with_its_folder_is_queued_once(state, tmp_path, monkeypatch):
    for name in ("a.jpg", "b.jpg"):
        (tmp_path / name).touch()
    monkeypatch.chdir(tmp_path)
    take_files(state, [Path("b.jpg"), tmp_path, tmp_path / "a.jpg"], *ELSEWHERE)
    assert [path.name for path in state.queue.paths] == ["b.jpg", "a.jpg"]


def test_lights_beyond_the_first_on_the_light_panel_are_named(state):
    take_files(state, [Path("friend.jpg"), Path("other.jpg")], 100.0, 100.0)
    assert state.light.name == os.path.abspath("friend.jpg")
    ((text, _),) = state.asking.notices
    assert "other.jpg left out" in text


@pytest.fixture
def shoot(tmp_path):
    """Three photos, and a session of the second."""
    photos = photo_files(tmp_path, "a.jpg", "b.jpg", "c.jpg")
    session = tmp_path / "b.relight.json"
    write_session(session, Document(PhotoRef(photos[1]), edit=Edit(quality="final", shadow=0.2)))
    return photos, session


def test_a_session_whose_photo_is_damaged_leaves_the_open_photo_its_place_in_the_queue(state, shoot):
    photos, session = shoot
    take_files(state, [photos[0], photos[2]], *ELSEWHERE)
    open_wish(state)
    take_files(state, [session], *ELSEWHERE)
    refuse_photo(state)
    assert (state.photo.path, state.queue.label) == (photos[0], "1 of 2")


def test_a_session_dropped_with_its_photo_opens_as_it_was_saved(state, shoot):
    photos, session = shoot
    (session.parent / "sub").mkdir()
    for photo in (photos[1], session.parent / "sub" / ".." / "b.jpg"):
        take_files(state, [photo, session], *ELSEWHERE)
        open_wish(state)
        assert (state.photo.path, state.edit.shadow, state.session_path) == (photos[1], 0.2, session)
        assert (state.queue.paths, state.asking.notices) == ((photos[1],), [])


def test_photos_dropped_with_a_session_are_the_queue_around_its_photo(state, shoot):
    photos, session = shoot
    take_files(state, [session, *photos], *ELSEWHERE)
    open_wish(state)
    assert (state.photo.path, state.session_path, state.queue.label) == (photos[1], session, "2 of 3")
    state.step_photo(1)
    assert state.photo.path == photos[2]


def test_a_session_of_another_photo_than_those_dropped_with_it_comes_before_them(state, shoot):
    (first, own, last), session = shoot
    take_files(state, [first, last, session], *ELSEWHERE)
    open_wish(state)
    assert state.queue.paths == (own, first, last)
    assert (state.photo.path, state.queue.label, state.edit.shadow) == (own, "1 of 3", 0.2)


def test_a_session_whose_photo_is_refused_leaves_the_photos_dropped_with_it_in_reach(state, shoot):
    (first, _, last), session = shoot
    take_files(state, [session, first, last], *ELSEWHERE)
    refuse_photo(state)
    assert state.edit.shadow == 1.0
    state.step_photo(1)
    assert state.photo.path == first


def test_no_light_is_missed_of_a_session_that_is_dropped_with_another(state, tmp_path):
    (photo,) = photo_files(tmp_path, "a.jpg")
    session = tmp_path / "a.relight.json"
    write_session(session, Document(PhotoRef(photo), LightRef("panorama", str(tmp_path / "gone.hdr"))))
    lamp = exr(tmp_path / "lamp.exr", 4, 8)
    take_files(state, [session, lamp], *ELSEWHERE)
    assert (state.photo.path, state.light.name, state.asking.notices) == (photo, str(lamp), [])
    take_files(state, [session], *ELSEWHERE)
    ((text, _),) = state.asking.notices
    assert "gone.hdr" in text
