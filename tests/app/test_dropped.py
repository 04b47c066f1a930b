"""What a dropped file becomes."""

from pathlib import Path

import numpy as np
import pytest

from app.ui.state import EditorState
from app.window.dropped import is_panorama, take_files
from relight_core.imaging.write import write_image

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
    take_files(state, [Path("friend.jpg")], 100.0, 100.0)
    assert state.photo is None
    assert (state.light.kind, state.light.name) == ("portrait", "friend.jpg")


def test_several_photos_and_folders_become_a_queue_without_what_is_no_photo(state, tmp_path):
    folder = tmp_path / "shoot"
    folder.mkdir()
    for name in ("b.jpg", "a.PNG", "notes.txt", ".hidden.jpg"):
        (folder / name).touch()
    take_files(state, [folder, Path("c.tif"), Path("d.doc")], *ELSEWHERE)
    assert [path.name for path in state.queue.paths] == ["a.PNG", "b.jpg", "c.tif"]
    assert state.photo.path.name == "a.PNG"
    assert "d.doc" in state.asking.notices[0][0]
    state.step_photo(1)
    state.step_photo(1)
    state.step_photo(1)
    assert state.photo.path.name == "c.tif"
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
    assert (state.light.kind, state.light.name) == ("portrait", "friend.jpg")
