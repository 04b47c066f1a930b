"""relight bench: what it refuses before anything slow starts."""

import pytest


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--photos", "nowhere"], "no such folder"),
        (["--heads", "heads"], "--lights"),
        (["--rounds", "0"], "whole number"),
    ],
)
def test_bad_input_is_one_line(relight, tmp_path, monkeypatch, words, told):
    monkeypatch.chdir(tmp_path)
    done = relight("bench", *words)
    assert done.code == 2
    assert told in done.err
    assert done.err.count("\n") == 1


def test_a_folder_without_photos(relight, tmp_path):
    done = relight("bench", "--photos", tmp_path, "-o", tmp_path / "out")
    assert done.code == 2
    assert "no photos" in done.err
