"""Autosave: not at every twitch, never too late, and offered only where nobody works on it."""

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


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "kept"


@pytest.fixture
def autosave(folder):
    return Autosave(folder, lambda write: write())


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


def test_saved_work_leaves_nothing(autosave, document, folder):
    autosave.update(document, True, 0.0)
    autosave.flush()
    autosave.update(document, False, 1.0)
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
