"""Autosave: not at every twitch, never too late, and offered only where nobody works on it."""

import builtins
import errno
import os
import subprocess
import sys
from dataclasses import replace

import pytest

from app.document.autosave import Autosave, leftovers
from app.document.document import Document, PhotoRef
from relight_core.pipeline.edit import Edit


@pytest.fixture
def document(tmp_path):
    (tmp_path / "me.jpg").write_bytes(b"pixels")
    return Document(PhotoRef(tmp_path / "me.jpg"), edit=Edit(yaw_deg=1.0, quality="final"))


def turned(document, yaw_deg):
    return replace(document, edit=replace(document.edit, yaw_deg=yaw_deg))


def files(folder):
    return sorted(path.suffix for path in folder.iterdir()) if folder.exists() else []


def test_a_change_is_written_once_it_is_quiet(autosave, document, folder):
    autosave.update(document, True, 0.0)
    autosave.update(document, True, 1.0)
    assert files(folder) == []
    assert autosave.due
    autosave.update(document, True, 2.0)
    assert files(folder) == [".json", ".lock"]
    assert not autosave.due


def test_constant_change_is_written_now_and_then(autosave, document, folder):
    for tenth in range(99):
        autosave.update(turned(document, tenth), True, tenth / 10)
    assert files(folder) == []
    autosave.update(turned(document, 99.0), True, 10.1)
    assert files(folder) == [".json", ".lock"]


def test_what_runs_is_not_offered_and_what_ended_is(autosave, document, folder):
    autosave.update(document, True, 0.0)
    autosave.flush()
    assert leftovers(folder) == []
    autosave.close()
    (found,) = leftovers(folder)
    assert found.document == document
    found.forget()
    assert leftovers(folder) == []
    assert files(folder) == []


def test_work_on_many_photos_keeps_few_files_open(autosave, document, folder, tmp_path):
    photos = [replace(document, photo=PhotoRef(tmp_path / f"{index}.jpg")) for index in range(20)]
    for work in photos:
        work.photo.path.write_bytes(b"pixels")
        autosave.update(work, True, 0.0)
    autosave.flush()
    assert files(folder) == [".json"] * 20 + [".lock"]
    assert leftovers(folder) == []
    for work in photos[:-1]:
        autosave.note_saved(work)
    assert files(folder) == [".json", ".lock"]
    autosave.close()
    assert [found.document for found in leftovers(folder)] == photos[-1:]


def test_what_is_left_of_one_run_is_offered_and_forgotten_one_by_one(autosave, document, folder, tmp_path):
    (tmp_path / "other.jpg").write_bytes(b"pixels")
    other = replace(document, photo=PhotoRef(tmp_path / "other.jpg"))
    for work in (document, other):
        autosave.update(work, True, 0.0)
    autosave.close()
    one, two = leftovers(folder)
    one.forget()
    assert [found.path for found in leftovers(folder)] == [two.path]
    two.forget()
    assert files(folder) == []


def test_saved_work_leaves_nothing(autosave, document, folder):
    autosave.update(document, True, 0.0)
    autosave.flush()
    autosave.update(document, False, 1.0)
    autosave.close()
    assert files(folder) == []


def test_work_that_is_saved_before_it_was_quiet_leaves_nothing_either(autosave, document, folder):
    autosave.update(document, True, 0.0)
    autosave.update(document, False, 0.5)
    assert not autosave.due
    autosave.close()
    assert files(folder) == []


def test_a_killed_editor_leaves_its_work(document, folder, tmp_path):
    program = f"""
import os
from pathlib import Path
from app.document.autosave import Autosave
from app.document.document import Document, PhotoRef
autosave = Autosave(Path({str(folder)!r}), lambda write: write())
autosave.update(Document(PhotoRef(Path({str(document.photo.path)!r}))), True, 0.0)
autosave.flush()
os.kill(os.getpid(), 9)
"""
    assert subprocess.run([sys.executable, "-c", program]).returncode != 0
    (found,) = leftovers(folder)
    assert found.document.photo == document.photo


def test_leftovers_that_are_too_large_to_look_into_stay(folder):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "large.json").write_bytes(b" " * 4_000_001)
    told = []
    assert leftovers(folder, told.append) == []
    assert (folder / "large.json").exists()
    assert "too large" in told[0]


def test_leftovers_that_a_failing_disk_does_not_read_stay(autosave, document, folder, monkeypatch):
    autosave.update(document, True, 0.0)
    autosave.close()
    (path,) = folder.glob("*.json")
    monkeypatch.setattr("builtins.open", failing_for(path, builtins.open))
    monkeypatch.setattr("io.open", builtins.open)
    told = []
    assert leftovers(folder, told.append) == []
    assert len(told) == 1
    assert "input/output error" in told[0]
    monkeypatch.undo()
    assert leftovers(folder)[0].document == document


def failing_for(path, really_open):
    def open_unless(name, *arguments, **named):
        if str(name) == str(path):
            raise OSError(errno.EIO, os.strerror(errno.EIO), str(path))
        return really_open(name, *arguments, **named)

    return open_unless


def test_what_of_a_leftover_can_not_be_had_is_told_and_the_rest_offered(autosave, document, folder):
    autosave.update(document, True, 0.0)
    autosave.close()
    (path,) = folder.glob("*.json")
    path.write_text(path.read_text().replace('"yaw_deg": 1.0', '"yaw_deg": 1.0, "sparkle": 2'))
    told = []
    (found,) = leftovers(folder, told.append)
    assert found.document == document
    assert found.notes == ("unknown setting sparkle was left out",)
    assert told == ["Unsaved work on me.jpg: unknown setting sparkle was left out"]


def test_damaged_leftovers_are_cleared_away(folder):
    folder.mkdir()
    (folder / "x.json").write_text("{")
    assert leftovers(folder) == []
    assert files(folder) == []


def test_a_place_that_cannot_be_written_stops_nothing(document, tmp_path):
    (tmp_path / "file").touch()
    autosave = Autosave(tmp_path / "file" / "kept", lambda write: write())
    autosave.update(document, True, 0.0)
    autosave.flush()
    autosave.close()


def test_what_could_not_be_written_is_tried_again_though_nothing_changes(autosave, document, folder):
    folder.touch()
    autosave.update(document, True, 0.0)
    autosave.update(document, True, 2.0)
    assert autosave.problem is not None
    folder.unlink()
    autosave.update(document, True, 3.0)
    assert not folder.exists()
    autosave.update(document, True, 13.0)
    assert autosave.problem is None
    assert autosave.keeps


def test_what_could_not_be_written_is_tried_again_at_the_end(autosave, document, folder, tmp_path):
    (tmp_path / "other.jpg").write_bytes(b"pixels")
    other = replace(document, photo=PhotoRef(tmp_path / "other.jpg"))
    folder.touch()
    autosave.update(document, True, 0.0)
    autosave.update(other, True, 1.0)
    autosave.update(other, True, 3.0)
    folder.unlink()
    autosave.close()
    assert {found.document for found in leftovers(folder)} == {document, other}


@pytest.mark.skipif(sys.platform == "darwin" or os.name == "nt", reason="names are text in Unicode there")
def test_work_on_a_file_whose_name_is_no_text_is_kept_and_comes_back(autosave, document, folder, tmp_path):
    odd = tmp_path / os.fsdecode(b"m\xffe.jpg")
    odd.write_bytes(b"pixels")
    autosave.update(replace(document, photo=PhotoRef(odd)), True, 0.0)
    autosave.close()
    assert autosave.problem is None
    (found,) = leftovers(folder)
    assert found.document.photo.path == odd


@pytest.mark.parametrize(
    ("error", "told"),
    [
        (ValueError("no such thing"), "no such thing"),
        (MemoryError(), "MemoryError"),
        (PermissionError(13, "Permission denied", "/home/me"), "/home/me: permission denied"),
    ],
)
def test_whatever_stops_the_writing_is_a_problem_that_is_told(autosave, document, monkeypatch, error, told):
    def fail(*_, **__):
        raise error

    monkeypatch.setattr("app.document.autosave.write_session", fail)
    autosave.update(document, True, 0.0)
    autosave.flush()
    assert autosave.problem == told
    assert not autosave.keeps


def test_what_could_not_be_written_is_no_problem_once_it_is_saved_elsewhere(autosave, document, folder):
    folder.touch()
    autosave.update(document, True, 0.0)
    autosave.flush()
    first = autosave.problem
    assert first is not None
    autosave.note_saved(document)
    assert autosave.problem is None
    autosave.update(turned(document, 9.0), True, 20.0)
    autosave.flush()
    assert autosave.problem == first


def test_a_lock_that_can_not_be_opened_is_told_and_its_work_left_alone(autosave, document, folder):
    autosave.update(document, True, 0.0)
    autosave.close()
    (kept,) = folder.glob("*.json")
    lock = kept.with_name(f"{kept.stem.partition('-')[0]}.lock")
    lock.mkdir()
    told = []
    assert leftovers(folder, told.append) == []
    assert len(told) == 1
    assert ".lock" in told[0]
    lock.rmdir()
    assert len(leftovers(folder)) == 1


@pytest.mark.skipif(os.name == "nt", reason="locks are others there")
def test_work_on_a_disk_without_locks_is_kept_and_told(autosave, document, folder, monkeypatch):
    def none(descriptor, wish):
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr("fcntl.flock", none)
    autosave.update(document, True, 0.0)
    autosave.close()
    (kept,) = folder.glob("*.json")
    told = []
    assert leftovers(folder, told.append) == []
    assert len(told) == 1
    assert str(kept) in told[0]
    assert kept.exists()
