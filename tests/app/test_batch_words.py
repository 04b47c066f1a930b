"""What a batch says, which files it takes for photos, and how its files are named and dated."""

import os
from pathlib import Path

import pytest

from app.engine.batch import Outcome, batch_tasks, is_done, photos_in, reasons, relight_each, summary


def outcomes(*states):
    return [Outcome(Path(f"{index}.jpg"), Path("x.png"), state, state * 2) for index, state in enumerate(states)]


@pytest.mark.parametrize(
    ("states", "words"),
    [
        ([], "0 photos relit"),
        (["written"], "1 photo relit"),
        (["written", "written", "kept"], "2 photos relit; 1 was done already"),
        (["kept", "kept"], "0 photos relit; 2 were done already"),
        (["failed", "written", "failed"], "1 photo relit; 2 could not be relit: 0.jpg, 2.jpg"),
    ],
)
def test_it_is_told_in_a_line_how_many_were_relit(states, words):
    assert summary(outcomes(*states)) == words
    assert len(reasons(outcomes(*states))) == states.count("failed")


def test_hidden_files_and_large_letters(tmp_path):
    for name in (".a.jpg", "._b.jpg", "b.JPG", "c.Tiff", "d.hdr", "e.txt"):
        (tmp_path / name).write_bytes(b"pixels")
    assert [path.name for path in photos_in(tmp_path)] == ["b.JPG", "c.Tiff"]


@pytest.mark.parametrize(("photo_s", "output_s", "dated_s"), [(1e9, 1.5e9, 1.5e9), (2e9, 1.5e9, 2e9)])
def test_a_file_keeps_its_date_unless_its_photo_s_is_later(tmp_path, photo_s, output_s, dated_s):
    photo, output = tmp_path / "a.jpg", tmp_path / "a.png"
    photo.write_bytes(b"pixels")
    os.utime(photo, (1e9, photo_s))

    def one(photo, output):
        output.write_bytes(b"relit")
        os.utime(output, (output_s, output_s))

    (outcome,) = relight_each([(photo, output)], one)
    assert (outcome.state, output.stat().st_mtime) == ("written", dated_s)
    (again,) = relight_each([(photo, output)], one, kept_if=is_done)
    assert again.state == "kept"


@pytest.mark.parametrize(
    "error", [MemoryError(), RuntimeError("CUDA out of memory."), ValueError("(-4:Insufficient memory) Failed")]
)
def test_where_memory_has_run_out_no_other_photo_is_tried(tmp_path, error):
    tried = []

    def one(photo, output):
        tried.append(photo)
        raise error

    with pytest.raises(type(error)):
        list(relight_each([(Path("a.jpg"), Path("a.png")), (Path("b.jpg"), Path("b.png"))], one))
    assert len(tried) == 1


@pytest.mark.parametrize("order", [1, -1])
def test_no_two_photos_share_a_picture_be_it_for_their_letters_alone_and_each_keeps_its_own_in_any_order(order):
    named = {"x/a.jpg": "a-jpg", "x/b.png": "b", "x/a-jpg.png": "a-jpg-2", "y/A.JPG": "A-JPG-3"}
    tasks = batch_tasks([Path(photo) for photo in named][::order], Path("relit"), ".png")
    assert dict(tasks) == {Path(photo): Path("relit") / f"{name}.png" for photo, name in named.items()}
