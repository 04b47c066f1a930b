"""relight measure: what it is given is checked before a window opens."""

import pytest


@pytest.fixture
def relight_and_look(relight, photo, monkeypatch):
    """Runs `relight measure` on a photo; a window that would open is an error of its own."""
    monkeypatch.setattr("app.window.measure.measure_window", lambda *_, **__: pytest.fail("a window was opened"))
    return lambda *words: relight("measure", photo, *words)


@pytest.mark.parametrize(
    "words",
    [
        ("--repeats", "0"),
        ("--repeats", "2.5"),
        ("--seconds", "0"),
        ("--seconds", "nan"),
        ("--openings", "-1"),
    ],
)
def test_counts_and_times_out_of_range_are_told_in_a_line(relight_and_look, words):
    done = relight_and_look(*words)
    assert done.code == 2
    assert done.err.count("\n") == 1
    assert words[0] in done.err


@pytest.mark.parametrize("name", ["nowhere/speed.json", "speed.txt"])
def test_an_output_that_can_not_be_written_is_told_at_the_start(relight_and_look, tmp_path, name):
    done = relight_and_look("-o", tmp_path / name)
    assert done.code == 2
    assert done.err.count("\n") == 1
    assert name.partition("/")[0] in done.err


def test_a_photo_is_not_written_over_by_what_is_measured_of_it(relight_and_look, photo):
    named_oddly = photo.rename(photo.with_name("photo.json"))
    before = named_oddly.read_bytes()
    done = relight_and_look(named_oddly, "-o", named_oddly)
    assert done.code == 2
    assert f"{named_oddly}: that is the input" in done.err
    assert named_oddly.read_bytes() == before
