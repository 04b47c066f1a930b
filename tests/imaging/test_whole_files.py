"""Whole files or none: what can't be read is told, and what is left of a file that was not finished goes."""

import hashlib
import os
from pathlib import Path

import pytest

from relight_core.errors import InputError
from relight_core.imaging import files
from relight_core.imaging.files import file_bytes, file_digest, file_head, is_same_file, remove_unfinished, whole_file


def test_a_file_that_is_larger_than_any_photo_is_refused(tmp_path):
    path = tmp_path / "a.jpg"
    path.touch()
    os.truncate(path, 8 << 30)
    assert file_head(path) == bytes(32)
    os.truncate(path, 9 << 30)
    with pytest.raises(InputError, match="9 GiB is too large"):
        file_head(path)


def test_a_file_that_does_not_fit_into_memory_is_told_as_that(tmp_path, monkeypatch):
    class Large:
        def __enter__(self):
            return self

        def __exit__(self, *_):
            return None

        def read(self, _):
            raise MemoryError

    (tmp_path / "a.jpg").write_bytes(b"a")
    monkeypatch.setattr(files, "open", lambda *_: Large(), raising=False)
    with pytest.raises(InputError, match=r"a\.jpg: not enough memory"):
        file_bytes(tmp_path / "a.jpg")


def test_a_files_digest_is_of_all_of_it(tmp_path):
    (tmp_path / "a.jpg").write_bytes(bytes(1000) + b"end")
    assert file_digest(tmp_path / "a.jpg") == hashlib.sha256(bytes(1000) + b"end").hexdigest()


def test_a_path_that_no_file_can_have_is_told_in_short():
    with pytest.raises(InputError, match="name too long") as refused:
        file_head(Path("x" * 5000))
    assert len(str(refused.value)) < 300


def test_a_name_that_is_too_long_is_told_without_that_of_the_unfinished_file(tmp_path):
    told = r"x\.png: can't be written \(file name too long\)"
    with pytest.raises(InputError, match=told) as refused, whole_file(tmp_path / f"{'x' * 300}.png"):
        pass
    assert ".part" not in str(refused.value)
    assert os.listdir(tmp_path) == []


def test_two_paths_are_one_file_by_whatever_leads_to_it(tmp_path):
    (tmp_path / "folder").mkdir()
    for name in ("a.jpg", "copy.jpg"):
        (tmp_path / name).write_bytes(b"a")
    os.symlink(tmp_path / "a.jpg", tmp_path / "link.jpg")
    os.link(tmp_path / "a.jpg", tmp_path / "hard.jpg")
    os.symlink(tmp_path / "missing.jpg", tmp_path / "dangling.jpg")
    for name in ("a.jpg", "folder/../a.jpg", "link.jpg", "hard.jpg"):
        assert is_same_file(tmp_path / "a.jpg", tmp_path / name)
    assert is_same_file(tmp_path / "missing.jpg", tmp_path / "dangling.jpg")
    assert not is_same_file(tmp_path / "a.jpg", tmp_path / "copy.jpg")
    assert not is_same_file(tmp_path / "a.jpg", tmp_path / "missing.jpg")


def test_only_what_was_left_of_a_files_own_unfinished_copies_is_removed(tmp_path):
    (tmp_path / "folder").mkdir()
    os.symlink(tmp_path / "folder" / "a.jpg", tmp_path / "link.jpg")
    kept = {"a.jpg", ".a.jpg-backup.part", ".a.jpg-0123456789ab.part.jpg", ".b.jpg-0123456789ab.part", ".a-jpg.part"}
    for name in (*kept, ".a.jpg-0123456789ab.part", ".a.jpg-ba9876543210.part"):
        (tmp_path / "folder" / name).touch()
    remove_unfinished(tmp_path / "link.jpg")
    assert set(os.listdir(tmp_path / "folder")) == kept
