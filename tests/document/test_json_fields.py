"""What is read of a group of settings, setting by setting: kept, moved into its range, noted or refused."""

import json
import os

import pytest

from app.document.json_fields import (
    Fields,
    NotThereError,
    holds_json,
    is_place_for,
    is_too_large,
    kind_of,
    path_from_file,
    read_json,
    write_json,
)
from relight_core.errors import InputError


@pytest.fixture
def notes():
    return []


@pytest.fixture
def fields(notes):
    """Makes a group of settings."""
    return lambda **values: Fields(values, "here", notes)


@pytest.mark.parametrize("value", [2.5, -3, 7])
def test_a_number_in_its_range_is_kept_as_a_float(fields, notes, value):
    kept = fields(size=value).number("size", -3.0, 7.0, 0.0)
    assert (kept, type(kept), notes) == (value, float, [])
    assert fields().number("size", -3.0, 7.0, 1.5) == 1.5


def test_only_what_is_whole_turns_wide_comes_round(fields, notes):
    assert fields(roll=730.0).number("roll", -360.0, 360.0, 0.0) == 10.0
    assert fields(roll=-450.0).number("roll", -360.0, 360.0, 0.0) == -90.0
    assert fields(roll=350.0).number("roll", -360.0, 360.0, 0.0) == 350.0
    assert fields(yaw=-190.0).number("yaw", -180.0, 180.0, 0.0) == 170.0
    assert fields(lift=190.0).number("lift", -90.0, 90.0, 0.0) == 90.0
    assert [note.split(" is out of range and became ") for note in notes] == [
        ["roll 730", "10"],
        ["roll -450", "-90"],
        ["yaw -190", "170"],
        ["lift 190", "90"],
    ]


@pytest.mark.parametrize("value", [True, "1", None, [1], 10**400])
def test_what_is_no_number_is_refused(fields, value):
    with pytest.raises(InputError, match="here: size is not a number"):
        fields(size=value).number("size", 0.0, 1.0, 0.0)


@pytest.mark.parametrize(("value", "kept"), [(0, 0), (999, 999), (None, None)])
def test_a_count_is_a_whole_number_or_none(fields, value, kept):
    assert fields(face=value).index("face") == kept


@pytest.mark.parametrize("value", [True, -1, 1000, 1.0, "1"])
def test_what_is_no_count_is_refused(fields, value):
    with pytest.raises(InputError, match="face is not a count"):
        fields(face=value).index("face")


@pytest.mark.parametrize("value", ["a" * 4097, "a\0b", 3])
def test_a_text_is_of_reasonable_length(fields, value):
    assert fields(name="a" * 4096).text("name") == "a" * 4096
    with pytest.raises(InputError, match="name is missing or not text"):
        fields(name=value).text("name")


def test_a_word_that_is_not_known_becomes_the_usual_one_and_is_noted(fields, notes):
    assert fields(form="disc").word("form", ("disc", "square"), "square") == "disc"
    assert fields().word("form", ("disc", "square"), "square") == "square"
    assert notes == []
    assert fields(form="star").word("form", ("disc", "square"), "square") == "square"
    assert notes == ["unknown form star became square"]


def test_words_that_are_not_known_are_left_out_and_noted(fields, notes):
    assert fields(forced=["b", "z", "a"]).words("forced", ("a", "b", "c")) == {"a", "b"}
    assert notes == ["unknown forced z was left out"]


@pytest.mark.parametrize("values", [{}, {"boxes": None}])
def test_nothing_is_missing_or_null_and_is_then_read(fields, notes, values):
    group = fields(**values)
    assert group.is_nothing("boxes")
    group.finish()
    assert notes == []
    assert not fields(boxes=[]).is_nothing("boxes")


def test_of_a_list_that_is_too_long_the_first_are_read(fields, notes):
    assert len(fields(boxes=[{}, {}]).groups("boxes", 2)) == 2
    assert notes == []
    first, second = fields(boxes=[{"x": 1}, {"x": 2}, {"x": 3}]).groups("boxes", 2)
    assert [group.number("x", 0, 9, 0) for group in (first, second)] == [1, 2]
    assert notes == ["only the first 2 of 3 boxes were read"]
    with pytest.raises(InputError, match="here, boxes 2: is not a group"):
        fields(boxes=[{}, 7]).groups("boxes", 2)


def test_a_triple_is_three_numbers_and_may_be_brighter_than_white(fields, notes):
    assert fields(colour=[0, 40.5, 2e4]).triple("colour") == (0.0, 40.5, 1e4)
    assert fields(colour=None).triple("colour") is None
    assert notes == ["colour 2 20000 is out of range and became 10000"]
    for wrong in ([1, 2], [1, 2, 3, 4], "123", [1, 2, True]):
        with pytest.raises(InputError):
            fields(colour=wrong).triple("colour")


def test_what_nobody_asked_for_is_noted(fields, notes):
    group = fields(size=1, sparkle=2, glow={})
    group.number("size", 0, 1, 0)
    group.finish()
    assert notes == ["unknown setting glow was left out", "unknown setting sparkle was left out"]


@pytest.fixture
def path(tmp_path):
    return tmp_path / "x.json"


def test_what_is_written_is_of_its_kind_and_can_be_read(path, notes):
    write_json(path, "session", 4, {"name": "Zoë \udcff"})
    assert kind_of(path) == "session"
    assert read_json(path, "session", 4, notes).text("name") == "Zoë \udcff"
    assert path.read_bytes().isascii()
    with pytest.raises(InputError, match="not a relight light file"):
        read_json(path, "light", 4, notes)
    with pytest.raises(InputError, match="update relight"):
        read_json(path, "session", 3, notes)


def test_what_an_editor_of_text_has_put_before_it_does_no_harm(path, notes):
    path.write_bytes(b"\xef\xbb\xbf" + json.dumps({"relight": "light", "version": 1, "name": "a"}).encode())
    assert kind_of(path) == "light"
    assert read_json(path, "light", 1, notes).text("name") == "a"


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity"])
def test_numbers_that_are_none_are_neither_read_nor_written(path, notes, number):
    path.write_text(f'{{"relight": "light", "version": 1, "surprise": {number}}}')
    assert kind_of(path) is None
    with pytest.raises(InputError, match=f"{number} is no number"):
        read_json(path, "light", 1, notes)
    before = path.read_bytes()
    with pytest.raises(ValueError):
        write_json(path, "light", 1, {"yaw_deg": float(number)})
    assert path.read_bytes() == before


def test_a_file_that_is_as_large_as_any_of_ours_is_looked_into(path):
    content = b'{"relight": "light"}'
    for spare in (0, 1):
        path.write_bytes(content + b" " * (4_000_000 - len(content) + spare))
        assert is_too_large(path) == bool(spare)
        assert kind_of(path) == (None if spare else "light")


@pytest.mark.skipif(os.name == "nt", reason="no such files there")
def test_what_is_no_ordinary_file_is_none_of_ours(path, tmp_path, notes):
    os.mkfifo(path)
    assert kind_of(path) is None
    assert not is_too_large(path)
    with pytest.raises(InputError, match="not a light file"):
        read_json(path, "light", 1, notes)
    link = tmp_path / "link.json"
    link.symlink_to(tmp_path / "nowhere")
    assert not is_place_for(link, "light"), "something is there"


@pytest.mark.parametrize("text", ["./gone.jpg", "a\0b.jpg", "a\ud800.jpg", "x" * 5000])
def test_a_name_of_no_file_is_told_as_not_there(tmp_path, text):
    with pytest.raises(NotThereError, match=r"^here: .* is not there; move it back, or mend the file's paths$"):
        path_from_file(text, tmp_path, (".jpg",), "here")


def test_a_picture_is_known_by_its_name_in_large_letters_and_named_in_full(tmp_path):
    (tmp_path / "ME.JPG").write_bytes(b"pixels")
    found = path_from_file("deep/../ME.JPG", tmp_path, (".jpg",), "here")
    assert str(found) == str(tmp_path / "ME.JPG")


@pytest.mark.skipif(os.name == "nt", reason="no such names there")
def test_a_name_that_leads_elsewhere_is_refused_even_where_a_file_is_called_so(tmp_path):
    (tmp_path / "~").mkdir()
    for path in (tmp_path / "~" / "me.jpg", tmp_path / "\\\\host\\me.jpg", tmp_path / "me.jpg"):
        path.write_bytes(b"pixels")
    for text in ("~/me.jpg", "\\\\host\\me.jpg", f"/{tmp_path / 'me.jpg'}"):
        with pytest.raises(InputError, match="is not a file beside it"):
            path_from_file(text, tmp_path, (".jpg",), "here")


NOT_OURS = [b"[" * 100_000, b'{"relight": "light", "name": "\xff"}', b"[7]", b'{"relight": 7}']


@pytest.mark.parametrize("content", NOT_OURS)
def test_what_is_no_file_of_ours_is_of_no_kind_and_holds_nothing(path, content):
    path.write_bytes(content)
    assert kind_of(path) is None
    assert not holds_json(path, "light", 1, {})
