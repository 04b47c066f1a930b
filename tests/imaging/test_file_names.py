"""Names of files that are long, or no text: what is written under them, and how they are shown."""

import os

import pytest

from relight_core.errors import InputError
from relight_core.imaging.files import is_legible, legible, whole_file
from relight_core.imaging.read import read_photo


@pytest.mark.parametrize("name", ["人" * 84 + "a", "é" * 127, "x" * 255, "a" + "😀" * 63])
def test_every_name_that_a_file_can_have_can_be_written(name, tmp_path):
    """A name's bytes are limited, not its letters, and beside it there has to be room for another."""
    with whole_file(tmp_path / name) as beside:
        beside.write_bytes(b"whole")
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_bytes() == b"whole"


def test_a_name_that_is_no_text_is_shown_as_far_as_it_is(tmp_path):
    name = os.fsdecode(b"caf\xe9.jpg")
    assert not is_legible(name)
    assert legible(name) == "caf\N{REPLACEMENT CHARACTER}.jpg"
    assert is_legible(legible(name))
    with whole_file(tmp_path / name) as beside:
        assert is_legible(beside.name)
        beside.write_bytes(b"whole")
    assert os.listdir(os.fsencode(tmp_path)) == [b"caf\xe9.jpg"]


def test_a_name_that_is_text_stays_as_it_is():
    for name in ("portrait.jpg", "ü ñ 人 😀.png", ""):
        assert legible(name) == name
        assert is_legible(name)


def test_a_name_with_line_breaks_is_shown_and_refused_in_one_line(tmp_path):
    odd = "\N{REPLACEMENT CHARACTER}"
    assert legible("a\nb\t\x1b[31mc\x85\u2028.jpg") == f"a{odd}b{odd}{odd}[31mc{odd}{odd}.jpg"
    path = tmp_path / "a\nb.jpg"
    path.write_bytes(b"no picture")
    with pytest.raises(InputError) as refused:
        read_photo(path)
    assert str(refused.value).startswith(f"{tmp_path}/a{odd}b.jpg: ")
    assert len(str(refused.value).splitlines()) == 1


def test_what_is_told_of_many_files_keeps_its_lines():
    assert str(InputError("2 failed", "a\nb: bad", "c: bad")) == "2 failed\na\N{REPLACEMENT CHARACTER}b: bad\nc: bad"
