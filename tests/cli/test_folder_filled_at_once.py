"""A folder whose files appear together: what is said when they can't."""

import pytest

from app.cli import outputs
from app.cli.outputs import folder_filled_at_once
from relight_core.errors import InputError


def test_what_fails_is_told_of_the_folder_and_not_of_a_scratch_folder_that_is_gone(tmp_path):
    with pytest.raises(InputError) as refused, folder_filled_at_once(tmp_path / "out") as scratch:
        raise InputError(f"{scratch / 'channels.exr'}: can't be written (no space left on device)")
    assert str(refused.value) == f"{tmp_path / 'out' / 'channels.exr'}: can't be written (no space left on device)"
    assert not any((tmp_path / "out").iterdir())


def fill(folder, *names):
    for name in names:
        (folder / name).write_bytes(b"after")


def test_a_folder_in_the_place_of_one_file_leaves_all_files_as_they_were(tmp_path):
    (tmp_path / "albedo.png").write_bytes(b"before")
    (tmp_path / "normal.png").mkdir()
    with pytest.raises(InputError, match=r"normal\.png: is a folder"), folder_filled_at_once(tmp_path) as scratch:
        fill(scratch, "albedo.png", "normal.png")
    assert (tmp_path / "albedo.png").read_bytes() == b"before"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["albedo.png", "normal.png"]


def test_a_folder_can_be_made_however_deep_unless_a_file_is_in_its_way(tmp_path):
    outputs.check_folder(tmp_path / "a" / "b" / "c", is_made=True)
    (tmp_path / "a").touch()
    with pytest.raises(InputError, match="a: is not a folder"):
        outputs.check_folder(tmp_path / "a" / "b" / "c", is_made=True)
    with pytest.raises(InputError, match="no such folder"):
        outputs.check_folder(tmp_path / "b")
