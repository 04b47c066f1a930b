"""Autosave: what is offered after a crash is the newest work, on whichever photo, however saving and undo fall."""

import os
import shutil
from dataclasses import replace

import pytest

from app.document.autosave import Autosave, leftovers
from app.document.document import Document, PhotoRef
from relight_core.pipeline.edit import Edit


@pytest.fixture
def document(tmp_path):
    return of_photo(tmp_path / "me.jpg")


@pytest.fixture
def other(tmp_path):
    return of_photo(tmp_path / "you.jpg")


def of_photo(path):
    path.write_bytes(b"pixels")
    return Document(PhotoRef(path), edit=Edit(yaw_deg=1.0, quality="final"))


def turned(document, yaw_deg):
    return replace(document, edit=replace(document.edit, yaw_deg=yaw_deg))


def kept(autosave, *documents):
    """As many states of the work, each of them in its file."""
    for document in documents:
        autosave.update(document, True, 0.0)
        autosave.flush()


def offered(autosave, folder):
    """The work that the next start offers."""
    autosave.close()
    return [found.document for found in leftovers(folder)]


def test_a_change_that_was_taken_back_is_not_what_is_offered(autosave, document, folder):
    kept(autosave, document)
    autosave.update(turned(document, 5.0), True, 1.0)
    autosave.update(document, True, 1.1)
    assert not autosave.due
    assert offered(autosave, folder) == [document]


def test_work_that_goes_on_after_its_session_was_saved_is_offered(autosave, document, folder):
    kept(autosave, document, turned(document, 5.0))
    autosave.note_saved(document)
    assert offered(autosave, folder) == [turned(document, 5.0)]


def test_work_that_goes_on_after_all_was_saved_is_offered_to_no_other_window(autosave, document, folder):
    kept(autosave, document)
    autosave.note_saved(document)
    kept(autosave, turned(document, 5.0))
    assert leftovers(folder) == []
    assert offered(autosave, folder) == [turned(document, 5.0)]


def test_work_that_undo_makes_unsaved_again_is_kept_again(autosave, document, folder):
    kept(autosave, document)
    autosave.update(document, False, 1.0)
    autosave.update(document, True, 2.0)
    assert offered(autosave, folder) == [document]


def test_saving_one_photo_s_session_leaves_what_waits_of_another_alone(autosave, document, other, folder):
    kept(autosave, document)
    autosave.update(other, True, 1.0)
    autosave.note_saved(document)
    assert autosave.due
    assert offered(autosave, folder) == [other]


def test_a_file_is_not_the_newest_work_s_until_that_is_written(document, folder):
    writes = []
    autosave = Autosave(folder, writes.append)
    for work in (document, turned(document, 5.0)):
        autosave.update(work, True, 0.0)
        assert autosave.due
        assert not autosave.keeps
        autosave.flush()
        assert not autosave.keeps
        writes.pop()()
        assert autosave.keeps
        assert autosave.holds(document.photo.path)


def test_a_full_disk_is_tried_again_now_and_then(document, folder):
    folder.touch()
    tries = []
    autosave = Autosave(folder, lambda write: tries.append(write) or write())
    for tenth in range(350):
        autosave.update(document, True, tenth / 10)
    assert len(tries) == 4, "once it was quiet for 1.5 s, and every 10 s from the change on"


def test_it_fails_as_long_as_one_photo_s_work_is_on_no_disk(autosave, document, other, folder):
    folder.touch()
    kept(autosave, document)
    folder.unlink()
    kept(autosave, other)
    assert autosave.problem is None
    assert autosave.fails
    autosave.try_again()
    assert not autosave.fails


@pytest.mark.skipif(os.name == "nt", reason="modes are others there")
def test_nobody_else_may_look_at_what_is_kept(autosave, document, folder):
    kept(autosave, document)
    assert folder.stat().st_mode & 0o077 == 0


def test_work_whose_folder_was_moved_finds_its_photo(autosave, document, folder, tmp_path):
    kept(autosave, document)
    autosave.close()
    moved = tmp_path / "elsewhere" / "deep"
    shutil.move(folder, moved)
    assert [found.document for found in leftovers(moved)] == [document]


def test_the_newest_of_what_is_left_comes_first(autosave, document, other, folder):
    kept(autosave, document, other)
    autosave.close()
    for path, saved_s in zip(sorted(folder.glob("*.json")), (2e9, 1e9), strict=True):
        os.utime(path, (saved_s, saved_s))
    assert [found.document for found in leftovers(folder)] == [document, other]


def test_work_on_a_photo_that_is_away_waits_until_it_is_back(autosave, document, folder, tmp_path):
    kept(autosave, document)
    autosave.close()
    photo = document.photo.path
    away = photo.rename(tmp_path / "away")
    told = []
    assert leftovers(folder, told.append) == []
    assert "me.jpg" in told[0]
    away.rename(photo)
    assert [found.document for found in leftovers(folder)] == [document]


def test_a_photo_is_the_same_from_wherever_it_is_named(autosave, document, folder, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    near = replace(document, photo=PhotoRef(document.photo.path.relative_to(tmp_path)))
    kept(autosave, near)
    for photo in (near.photo.path, document.photo.path):
        assert autosave.is_given(photo)
        assert autosave.holds(photo)
    kept(autosave, document, near)
    assert len(list(folder.glob("*.json"))) == 1
    autosave.note_saved(near)
    assert not autosave.is_given(document.photo.path)
