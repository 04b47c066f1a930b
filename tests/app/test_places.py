"""Where files go of photos that lie in odd places."""

import os
from pathlib import Path

import pytest

from app.engine.places import current_folder, exported_stem, folder_for_outputs, from_home, full_path


@pytest.fixture
def gone(tmp_path, monkeypatch):
    """The current folder, which has been deleted."""
    folder = tmp_path / "gone"
    folder.mkdir()
    monkeypatch.chdir(folder)
    folder.rmdir()
    yield folder
    os.chdir(tmp_path)


def test_the_user_s_own_folder_stands_in_for_a_current_one_that_is_gone(gone, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    assert current_folder() == tmp_path
    assert folder_for_outputs(gone / "me.jpg") == tmp_path


def test_files_go_beside_their_photo_where_that_is_allowed(tmp_path):
    assert folder_for_outputs(tmp_path / "me.jpg") == tmp_path
    assert folder_for_outputs(tmp_path / "missing" / "me.jpg") == Path.cwd()


def test_files_go_beside_a_photo_that_is_named_from_the_current_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert folder_for_outputs(Path("me.jpg")) == tmp_path


def test_nothing_is_put_beside_a_sample_that_came_with_the_program(tmp_path, monkeypatch):
    monkeypatch.setattr("sys.prefix", str(tmp_path / "venv"))
    (tmp_path / "venv" / "samples").mkdir(parents=True)
    assert folder_for_outputs(tmp_path / "venv" / "samples" / "astronaut.png") == Path.cwd()


def test_a_file_has_one_full_path_whatever_folders_it_is_named_by_way_of(tmp_path, monkeypatch):
    (tmp_path / "shoot").mkdir()
    monkeypatch.chdir(tmp_path / "shoot")
    (tmp_path / "me.jpg").touch()
    for path in ("../me.jpg", ".././shoot/../me.jpg", f"{tmp_path}/shoot/../me.jpg", f"{tmp_path}/me.jpg"):
        assert full_path(Path(path)) == tmp_path / "me.jpg"
    assert full_path(Path("../gone.jpg")) == tmp_path / "gone.jpg"


def test_a_file_above_a_linked_folder_s_own_place_is_found_there(tmp_path):
    (tmp_path / "disk" / "shoot").mkdir(parents=True)
    (tmp_path / "link").symlink_to(tmp_path / "disk" / "shoot")
    for folder in ("disk", "."):
        (tmp_path / folder / "me.jpg").write_text(folder)
    above = tmp_path / "link" / ".." / "me.jpg"
    assert full_path(above).read_text() == "disk"
    assert full_path(tmp_path / "link" / "x.jpg") == tmp_path / "link" / "x.jpg"


@pytest.mark.parametrize("allowed", [os.R_OK | os.X_OK, os.R_OK | os.W_OK], ids=["not written", "not entered"])
def test_files_go_elsewhere_where_that_is_not_allowed(tmp_path, monkeypatch, allowed):
    monkeypatch.setattr(os, "access", lambda folder, asked: asked & ~allowed == 0)
    assert folder_for_outputs(tmp_path / "me.jpg") == Path.cwd()


def test_a_tilde_with_a_name_is_a_name_and_no_other_user_s_folder(monkeypatch):
    monkeypatch.setenv("HOME", "/home/me")
    assert from_home(Path("~/a.png")) == Path("/home/me/a.png")
    assert from_home(Path("~root/a.png")) == Path("~root/a.png")


@pytest.mark.parametrize(
    ("name", "photo"),
    [("a-relit.png", "a"), ("a-relit-12.exr", "a"), ("a-relit-relit.png", "a-relit"), ("a.b-relit.jpg", "a.b")]
    + [(name, None) for name in ("-relit.png", "a.png", "a-relit-x.png", "a-relit2.png", "relit.png")],
)
def test_an_export_is_known_by_its_name(name, photo):
    assert exported_stem(Path("/shoot") / name) == photo
