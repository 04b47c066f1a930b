"""relight render into the very folder that the photos are in, and past a photo that fails unexpectedly."""

import json
import os

import numpy as np
import pytest
from PIL import Image

from app.cli.outputs import results_among
from app.engine.batch import relight_each
from relight_core.imaging.write import write_image


@pytest.fixture
def shoot(tmp_path):
    folder = tmp_path / "shoot"
    folder.mkdir()
    return folder


def add_photo(folder, name, age_s=1000):
    pixels = np.random.default_rng(len(name)).integers(40, 200, (16, 24, 3), dtype=np.uint8)
    Image.fromarray(pixels).save(folder / name)
    now_s = (folder / name).stat().st_mtime
    os.utime(folder / name, (now_s - age_s, now_s - age_s))
    return folder / name


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize(
    ("out", "result"), [("", "a.png"), ("{name}-relit.png", "a-relit.png"), ("one.png", "one.png")]
)
def test_a_rerun_does_nothing_more(relight, relighter, shoot, out, result):
    add_photo(shoot, "a.jpg")
    words = ("render", f"{shoot}/", "--light", "ring", "--resume", "-o", f"{shoot}/{out}")
    for _ in range(3):
        assert relight(*words).code == 0
        assert names_in(shoot) == sorted(["a.jpg", result])
    assert len(relighter.edits) == 1


def test_an_interrupted_run_is_taken_up(relight, relighter, shoot):
    for name in ("a.jpg", "b.jpg"):
        add_photo(shoot, name)
    words = ("render", shoot, "--light", "ring", "-o", f"{shoot}/{{name}}-relit.png")
    assert relight(*words).code == 0
    (shoot / "b-relit.png").unlink()
    done = relight(*words, "--resume", "--json")
    assert done.code == 0
    record = json.loads(done.out)
    assert [os.path.basename(one["output"]) for one in record["results"]] == ["b-relit.png"]
    assert [os.path.basename(path) for path in record["kept"]] == ["a-relit.png"]
    assert names_in(shoot) == ["a-relit.png", "a.jpg", "b-relit.png", "b.jpg"]


def test_a_rerun_over_two_photos_of_one_name_does_nothing_more(relight, relighter, shoot):
    for name in ("a.jpg", "a.png"):
        add_photo(shoot, name)
    words = ("render", shoot, "--light", "ring", "-o", f"{shoot}/")
    assert relight(*words).code == 0
    assert relight(*words, "--resume").code == 0
    assert names_in(shoot) == ["a-jpg.png", "a-png.png", "a.jpg", "a.png"]
    assert len(relighter.edits) == 2


def test_a_run_that_told_three_photos_of_one_name_apart_is_taken_up_with_all_of_them(relight, relighter, shoot):
    for name in ("a.bmp", "a.jpg", "a.png"):
        add_photo(shoot, name)
    words = ("render", f"{shoot}/", "--light", "ring", "-o", f"{shoot}/")
    assert relight(*words).code == 0
    for lost in ("a-jpg.png", "a-png.png"):
        (shoot / lost).unlink()
    assert relight(*words, "--resume").code == 0
    assert names_in(shoot) == ["a-bmp.png", "a-jpg.png", "a-png.png", "a.bmp", "a.jpg", "a.png"]


def test_a_rerun_over_photos_of_one_name_in_two_folders_does_nothing_more(relight, relighter, shoot):
    for card in ("one", "two"):
        (shoot / card).mkdir()
        add_photo(shoot / card, "a.jpg")
    words = ("render", shoot / "one", shoot / "two", "--light", "ring", "--resume", "-o", f"{shoot}/one/")
    for _ in range(3):
        assert relight(*words).code == 0
        assert names_in(shoot / "one") == ["a-jpg-2.png", "a-jpg.png", "a.jpg"]
    assert len(relighter.edits) == 2


def test_a_result_that_no_photo_has_in_this_run_is_told_and_not_relit(relight, shoot):
    add_photo(shoot, "a.jpg")
    words = ("render", f"{shoot}/", "--light", "ring", "-o", f"{shoot}/{{name}}-dark.png", "--resume", "--json")
    assert json.loads(relight(*words).out)["left_out"] == []
    add_photo(shoot, "a.png")
    record = json.loads(relight(*words).out)
    assert [os.path.basename(path) for path in record["left_out"]] == ["a-dark.png"]
    assert [os.path.basename(one["output"]) for one in record["results"]] == ["a-jpg-dark.png", "a-png-dark.png"]


def test_a_photo_whose_result_would_be_itself_is_refused_and_not_taken_for_a_result(relight, relighter, shoot):
    before = add_photo(shoot, "a.png").read_bytes()
    add_photo(shoot, "b.jpg")
    done = relight("render", f"{shoot}/", "--light", "ring", "--resume", "-o", f"{shoot}/")
    assert (done.code, relighter.edits) == (2, [])
    assert "that is the input" in done.err
    assert (shoot / "a.png").read_bytes() == before


def test_what_was_exported_beside_a_photo_is_not_relit_with_its_folder(relight, shoot, tmp_path):
    for name in ("a.jpg", "a-relit.png"):
        add_photo(shoot, name)
    assert relight("render", shoot, "--light", "ring", "-o", f"{tmp_path}/out/").code == 0
    assert names_in(tmp_path / "out") == ["a.png"]
    assert relight("render", shoot / "a-relit.png", "--light", "ring", "-o", f"{tmp_path}/alone/").code == 0
    assert names_in(tmp_path / "alone") == ["a-relit.png"]


def test_a_photo_from_a_camera_whose_clock_is_ahead_is_done_once(relight, relighter, shoot):
    add_photo(shoot, "a.jpg", age_s=-20000)
    for _ in range(2):
        assert relight("render", shoot, "--light", "ring", "--resume", "-o", f"{shoot}/").code == 0
    assert len(relighter.edits) == 1
    assert names_in(shoot) == ["a.jpg", "a.png"]


def test_the_panorama_that_is_the_light_is_no_photo_of_its_folder(relight, shoot, tmp_path):
    add_photo(shoot, "a.jpg")
    write_image(shoot / "studio.exr", np.ones((8, 16, 3), np.float32))
    done = relight("render", shoot, "--light", shoot / "studio.exr", "-o", f"{tmp_path}/out/")
    assert (done.code, names_in(tmp_path / "out")) == (0, ["a.png"])
    (shoot / "a.jpg").unlink()
    done = relight("render", shoot, "--light", shoot / "studio.exr", "-o", f"{tmp_path}/out/")
    assert (done.code, "no photos" in done.err) == (2, True)


@pytest.mark.parametrize("name", ["a.jfif", "a.JPE"])
def test_jpegs_are_found_by_their_other_suffixes(relight, shoot, tmp_path, name):
    add_photo(shoot, "a.jpg").rename(shoot / name)
    assert relight("render", shoot, "--light", "ring", "-o", f"{tmp_path}/out/").code == 0
    assert names_in(tmp_path / "out") == ["a.png"]


def test_the_home_folder_has_its_short_name_in_every_argument(relight, shoot, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(shoot))
    monkeypatch.chdir(tmp_path)
    add_photo(shoot, "a.jpg")
    write_image(shoot / "studio.exr", np.ones((8, 16, 3), np.float32))
    assert relight("render", "~/a.jpg", "--light", "~/studio.exr", "-o", "~/{name}-relit.png").code == 0
    assert relight("turntable", "~/a.jpg", "--light", "~/studio.exr", "-o", "~/sheet.png").code == 0
    assert names_in(shoot) == ["a-relit.png", "a.jpg", "sheet.png", "studio.exr"]


def test_what_may_be_an_older_photo_of_its_own_is_not_written_over(relight, relighter, shoot):
    before = add_photo(shoot, "a.png", age_s=2000).read_bytes()
    add_photo(shoot, "a.jpg", age_s=1000)
    done = relight("render", shoot, "--light", "ring", "--resume", "-o", f"{shoot}/")
    assert done.code == 2
    assert done.err.count("\n") == 1
    assert "a.png" in done.err
    assert "older" in done.err
    assert (shoot / "a.png").read_bytes() == before
    assert relighter.edits == []


def test_without_resume_names_keep_photos_apart(relight, shoot):
    add_photo(shoot, "a.jpg")
    for _ in range(2):
        assert relight("render", shoot, "--light", "ring", "-o", f"{shoot}/").code == 0
    assert names_in(shoot) == ["a-jpg.png", "a-png.png", "a.jpg", "a.png"]


@pytest.mark.parametrize(
    ("names", "results"),
    [
        (("a-relit.png", "a.jpg"), ["a-relit.png"]),
        (("a-relit-relit.png", "a-relit.png", "a.jpg"), ["a-relit-relit.png", "a-relit.png"]),
        (("a-jpg-relit.png", "a-png-relit.png", "a.jpg", "a.png"), ["a-jpg-relit.png", "a-png-relit.png"]),
        (("b-relit.png", "a.jpg"), []),
        (("a-bmp-relit.png", "a.bmp", "a.jpg", "a-relit.png"), ["a-bmp-relit.png", "a-relit.png"]),
        (("a-JPG-relit-2.png", "a-jpg-relit.png", "a.JPG", "a.jpg"), ["a-jpg-relit.png"]),
        (("a-JPG-2-relit.png", "a-jpg-relit.png", "a.JPG", "a.jpg"), ["a-JPG-2-relit.png", "a-jpg-relit.png"]),
        (("a-jpg-2-relit.png", "a.jpg"), []),
    ],
)
def test_results_are_known_by_their_names(shoot, names, results):
    found = results_among([shoot / name for name in names], f"{shoot.parent}/other/../shoot/{{name}}-relit.png")
    assert [path.name for path in found] == results
    assert results_among([shoot / name for name in names], f"{shoot.parent}/out/{{name}}-relit.png") == []


def _failing_for(relighter, name, error):
    """Let the fake fail on one photo."""
    relight = relighter.relight

    def fail(*given, **settings):
        if relighter.photo.path.name == name:
            raise error
        return relight(*given, **settings)

    relighter.relight = fail


def test_a_fault_of_ours_fails_its_own_photo_only(relight, relighter, shoot, tmp_path):
    for name in ("a.jpg", "b.jpg", "c.jpg"):
        add_photo(shoot, name)
    _failing_for(relighter, "b.jpg", RuntimeError("shapes\ndisagree"))
    done = relight("render", shoot, "--light", "ring", "--json", "-o", f"{tmp_path}/out/")
    assert done.code == 1
    assert names_in(tmp_path / "out") == ["a.png", "c.png"]
    record = json.loads(done.out)
    assert [os.path.basename(one["input"]) for one in record["results"]] == ["a.jpg", "c.jpg"]
    (error,) = record["errors"]
    assert os.path.basename(error["input"]) == "b.jpg"
    told = done.err.splitlines()
    assert "b.jpg: a fault of ours, not of your input (RuntimeError: shapes disagree); RELIGHT_DEBUG=1" in told[0]
    assert "2 photos relit; 1 could not be relit: b.jpg" in told[1]


def test_debug_shows_where_a_photo_of_a_batch_failed(relight, relighter, shoot, tmp_path, monkeypatch):
    monkeypatch.setenv("RELIGHT_DEBUG", "1")
    add_photo(shoot, "a.jpg")
    _failing_for(relighter, "a.jpg", RuntimeError("shapes disagree"))
    done = relight("render", shoot, "--light", "ring", "-o", f"{tmp_path}/out/")
    assert done.code == 1
    assert "Traceback" in done.err


@pytest.mark.parametrize(
    "error",
    [
        KeyboardInterrupt(),
        MemoryError("no room"),
        RuntimeError("DefaultCPUAllocator: can't allocate memory"),
        BrokenPipeError(),
    ],
)
def test_what_no_other_photo_would_survive_ends_the_batch(tmp_path, error):
    worked = []

    def one(photo, _output):
        worked.append(photo)
        raise error

    tasks = [(tmp_path / name, tmp_path / f"{name}.png") for name in "ab"]
    with pytest.raises(type(error)):
        list(relight_each(tasks, one))
    assert len(worked) == 1
