"""Streams that can't be written: stderr stops nothing, stdout is told in a line, and neither is a fault of ours."""

import errno
import os
import subprocess
import sys

import pytest
from conftest import save_photo
from rich.console import Console

from app.cli.maker_inputs import progress
from app.cli.report import counting

FULL = "/dev/full"
pytestmark = pytest.mark.skipif(not os.path.exists(FULL), reason="wants a device that is always full")


@pytest.fixture
def full(monkeypatch):
    """Puts a stream onto a full disk, as a shell's > would."""

    def fill(name):
        stream = open(FULL, "w")  # noqa: SIM115
        monkeypatch.setattr(sys, name, stream)
        return stream

    yield fill
    for stream in (sys.stdout, sys.stderr):
        if stream.name == FULL:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def shell(words):
    return subprocess.run(["bash", "-c", f"{sys.executable} -m app {words}"], capture_output=True, text=True)


def test_a_batch_whose_complaints_have_nowhere_to_go_goes_on(relight, tmp_path, full):
    shoot = tmp_path / "shoot"
    shoot.mkdir()
    (shoot / "a.jpg").write_bytes(b"no pixels")
    for seed, name in enumerate(("b.png", "c.png")):
        save_photo(shoot / name, seed)
    full("stderr")
    done = relight("render", shoot, "--light", "ring", "-o", f"{tmp_path / 'out'}/")
    assert done.code == 2
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["b.png", "c.png"]
    assert done.out.count("wrote ") == 2


def test_an_exr_is_written_after_a_complaint_that_had_nowhere_to_go(relight, tmp_path, full):
    shoot = tmp_path / "shoot"
    shoot.mkdir()
    (shoot / "a.jpg").write_bytes(b"no pixels")
    save_photo(shoot / "b.png")
    full("stderr")
    assert relight("render", shoot, "--light", "ring", "-o", tmp_path / "{name}.exr").code == 2
    assert (tmp_path / "b.exr").exists()


@pytest.mark.parametrize("words", ["rendr", "render --light", "info --bogus"])
def test_exit_codes_are_as_if_the_complaint_had_been_read(words):
    for nowhere in (f"2>{FULL}", "2> >(true)"):
        assert shell(f"{words} {nowhere}").returncode == 2


def test_progress_that_nobody_reads_stops_nothing(full, monkeypatch):
    monkeypatch.setattr(Console, "is_terminal", True)
    stream = full("stderr")
    monkeypatch.setattr(stream, "isatty", lambda: True, raising=False)
    with progress("training", 1.0, line_every_s=0.0) as show:
        show(0.5, "half")
    with counting("relighting") as step:
        step(1, 2)


def test_lines_of_a_log_that_is_full_stop_nothing(full):
    full("stderr")
    with progress("training", 1.0, line_every_s=0.0) as show:
        show(0.5, "half")


@pytest.mark.parametrize(
    ("words", "unbuffered"), [("rigs", ""), ("rigs", "1"), ("rigs --json", ""), ("rigs --json", "1"), ("--help", "")]
)
def test_output_that_can_t_be_written_is_told_in_a_line(words, unbuffered, monkeypatch):
    monkeypatch.setenv("PYTHONUNBUFFERED", unbuffered)
    done = shell(f"{words} >{FULL}")
    assert done.returncode == 2
    program = "relight" if words == "--help" else "relight rigs"
    assert done.stderr == f"{program}: the output can't be written ({os.strerror(errno.ENOSPC).lower()})\n"


def test_a_reader_of_help_that_leaves_is_no_fault():
    done = shell("--help | true; exit ${PIPESTATUS[0]}")
    assert done.returncode in (0, 141)
    assert done.stderr == ""


@pytest.mark.parametrize("several", [False, True])
def test_a_photo_that_is_written_is_not_called_failed_because_nobody_can_be_told(relight, tmp_path, full, several):
    shoot = tmp_path / "shoot"
    shoot.mkdir()
    photo = save_photo(shoot / "a.png")
    full("stdout")
    done = relight("render", shoot if several else photo, "--light", "ring", "-o", f"{tmp_path / 'out'}/")
    assert done.code == 2
    assert (tmp_path / "out" / "a.png").exists()
    assert done.err.count("\n") == 1
    assert "the output can't be written" in done.err
    assert "a.png" not in done.err
