"""Whatever stands in the line for the export's name: the panel draws it, and an export lies in a sensible place."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.engine.exporting import free_path
from app.engine.places import from_home
from app.engine.snapshot import OpenLight, OpenPhoto, Picture, Snapshot
from app.engine.sources import PhotoSource
from app.ui.export_name import named_as
from app.ui.state import EditorState
from app.window.finished import Finished
from relight_core.imaging.photo import Photo
from relight_core.lighting.environment import Environment

TYPED = [
    ("~b", "~b", "~b.exr"),
    ("~b.png", "~b.png", "~b.exr"),
    ("/", "~me-relit.png", "~me-relit.exr"),
    (".", "~me-relit.png", "~me-relit.exr"),
    ("..", "~me-relit.png", "~me-relit.exr"),
    ("~", "~me-relit.png", "~me-relit.exr"),
    ("", "~me-relit.png", "~me-relit.exr"),
]


@pytest.mark.parametrize(
    ("typed", "suffix", "name"),
    [
        ("x.jpeg", ".jpg", "x.jpeg"),
        ("x.TIFF", ".tif", "x.TIFF"),
        ("x.png", ".jpg", "x.jpg"),
        ("x.tiff", ".exr", "x.exr"),
        ("x v1.2", ".png", "x v1.2.png"),
        ("x.png", ".mp4", "x.png.mp4"),
        ("x.png", ".relight.json", "x.png.relight.json"),
        ("x.json", ".light.json", "x.json"),
    ],
)
def test_a_name_takes_the_suffix_of_its_kind_unless_it_says_so_already(typed, suffix, name):
    assert named_as(Path(typed), suffix) == Path(name)


@pytest.fixture
def state(tmp_path):
    state = EditorState()
    state.open_photo(tmp_path / "~me.jpg")
    photo = Photo(np.zeros((4, 4, 3), np.float32), path=tmp_path / "~me.jpg")
    state.accept(Snapshot(opened=OpenPhoto(state.photo, photo, photo.linear)))
    return state


def test_a_photo_whose_name_begins_with_a_tilde_is_exported_beside_itself(state, tmp_path):
    assert state.export_place() == tmp_path / "~me-relit.png"


@pytest.mark.parametrize(("typed", "place", "as_exr"), TYPED)
def test_what_names_no_file_means_the_name_beside_the_photo(state, tmp_path, typed, place, as_exr):
    state.export_path = typed
    assert state.export_place() == tmp_path / place
    assert state.export_place(".exr") == tmp_path / as_exr
    state.choose_form(".exr")
    assert state.export_path == (as_exr if typed else "")


def test_only_a_tilde_by_itself_is_the_users_folder(state, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("USERPROFILE", str(tmp_path / "home"))
    state.export_path = "~/best.png"
    assert state.export_place() == tmp_path / "home" / "best.png"
    monkeypatch.chdir(tmp_path)
    named = from_home(state.photo.path.relative_to(tmp_path))
    assert str(named) == "~me.jpg"
    assert free_path(named) == named


def test_a_task_that_fails_with_its_picture_is_told_and_the_next_one_goes_on(state):
    said, given = [], []
    opened = state.snapshot.opened
    even = Environment.from_radiance(np.ones((4, 8, 3)), "even")
    light = OpenLight(state.light, even, np.zeros((4, 8, 3), np.uint8), np.zeros((4, 4, 4), np.uint8), even)
    picture = Picture(opened, light, state.request_at_rest().edit, None, None, opened.photo.linear, {})
    finished = Finished(state, lambda text, is_error: said.append((text, is_error)))

    def fail(_):
        raise ValueError("no such name")

    finished.then(fail)
    finished.then(given.append)
    finished.hand_out(Snapshot(opened=opened, light=light, picture=picture), is_idle=False)
    assert given == [picture]
    assert finished.failures == 1
    ((text, is_error),) = said
    assert "no such name" in text
    assert is_error
    state.photo = PhotoSource(state.photo.path)
    finished.then(given.append)
    finished.hand_out(Snapshot(opened=opened, light=light, picture=replace(picture)), is_idle=True)
    assert (len(given), finished.failures) == (1, 2)
