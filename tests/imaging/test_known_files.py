"""Whether a place is one of the files that are known, whatever it is called."""

import os

import pytest

from relight_core.imaging.files import KnownFiles


@pytest.fixture
def known(tmp_path):
    (tmp_path / "a.jpg").write_bytes(b"a")
    return KnownFiles([tmp_path / "a.jpg", tmp_path / "missing.jpg"])


def test_a_file_is_known_by_its_name_and_by_whatever_leads_to_it(known, tmp_path):
    (tmp_path / "folder").mkdir()
    os.symlink(tmp_path / "a.jpg", tmp_path / "link.jpg")
    os.link(tmp_path / "a.jpg", tmp_path / "hard.jpg")
    for name in ("a.jpg", "folder/../a.jpg", "link.jpg", "hard.jpg"):
        assert known.named(tmp_path / name) == tmp_path / "a.jpg"


def test_a_file_that_is_not_there_is_known_by_its_place(known, tmp_path):
    os.symlink(tmp_path / "missing.jpg", tmp_path / "dangling.jpg")
    assert known.named(tmp_path / "missing.jpg") == tmp_path / "missing.jpg"
    assert known.named(tmp_path / "dangling.jpg") == tmp_path / "missing.jpg"
    assert known.named(tmp_path / "other.jpg") is None


def test_another_file_of_the_same_content_is_another(known, tmp_path):
    (tmp_path / "b.jpg").write_bytes(b"a")
    assert known.named(tmp_path / "b.jpg") is None
    assert KnownFiles([]).named(tmp_path / "a.jpg") is None
