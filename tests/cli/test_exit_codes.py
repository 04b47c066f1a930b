"""Exit codes, whose fault it was, and what reaches which stream."""

import signal
import subprocess
import sys

import numpy as np
import pytest

from relight_core.imaging import files, write
from relight_core.imaging.write import write_image


def _failing(error):
    def fail(*_arguments, **_settings):
        raise error

    return fail


def test_our_fault_is_one_line_and_1(relight, relighter, photo, tmp_path, monkeypatch):
    monkeypatch.setattr(relighter, "relight", _failing(RuntimeError("shapes disagree")))
    done = relight("render", photo, "--light", "ring", "--json", "-o", tmp_path / "out.png")
    assert done.code == 1
    assert done.out == ""
    last = done.err.splitlines()[-1]
    assert "fault of ours" in last
    assert "shapes disagree" in last
    assert "Traceback" not in done.err


def test_debug_shows_the_traceback(relight, relighter, photo, tmp_path, monkeypatch):
    monkeypatch.setenv("RELIGHT_DEBUG", "1")
    monkeypatch.setattr(relighter, "relight", _failing(RuntimeError("shapes disagree")))
    done = relight("render", photo, "--light", "ring", "-o", tmp_path / "out.png")
    assert done.code == 1
    assert "Traceback" in done.err


def test_an_interrupt_is_quiet_and_130(relight, relighter, photo, tmp_path, monkeypatch):
    monkeypatch.setattr(relighter, "relight", _failing(KeyboardInterrupt()))
    done = relight("turntable", photo, "--light", "ring", "-o", tmp_path / "out.png")
    assert done.code == 130
    assert done.err == ""
    assert not (tmp_path / "out.png").exists()


def test_an_interrupt_before_the_words_are_read_is_quiet_and_130():
    script = """if True:
        import sys
        from app.__main__ import main

        class Interrupt:
            def find_spec(name, *_):
                if name == "app.cli.arguments":
                    raise KeyboardInterrupt

        sys.meta_path.insert(0, Interrupt)
        sys.exit(main())
    """
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (130, "")


@pytest.mark.skipif(sys.platform == "win32", reason="sends itself signals")
@pytest.mark.parametrize(("again", "code"), [("SIGINT", 130), ("SIGTERM", -signal.SIGTERM)])
def test_a_second_interrupt_while_things_are_let_go_of_is_quiet_too(again, code):
    script = f"""if True:
        import os, signal, sys
        from app.__main__ import main
        from app.cli import rigs

        class Held:
            def __del__(self):
                os.kill(os.getpid(), signal.{again})

        def run(_arguments):
            held = Held()
            signal.raise_signal(signal.SIGINT)

        rigs.run = run
        sys.argv = ["relight", "rigs"]
        sys.exit(main())
    """
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (code, "", "")


@pytest.mark.parametrize("command", ["render", "turntable"])
@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_a_write_that_fails_midway_keeps_the_old_file(relight, photo, tmp_path, monkeypatch, command, error):
    out = tmp_path / "out" / "relit.png"
    out.parent.mkdir()
    out.write_bytes(b"what was here before")

    def flush(path):
        assert path.stat().st_size > 0
        raise error

    monkeypatch.setattr(files, "_flush", flush)
    done = relight(command, photo, "--light", "ring", "-o", out)
    assert done.code == (2 if isinstance(error, OSError) else 130)
    assert out.read_bytes() == b"what was here before"
    assert [path.name for path in out.parent.iterdir()] == ["relit.png"]


def test_channels_are_all_written_or_none(relight, photo, tmp_path, monkeypatch):
    folder = tmp_path / "channels"
    monkeypatch.setattr(write, "write_exr_layers", _failing(RuntimeError("no encoder")))
    assert relight("channels", photo, "--light", "ring", "-o", folder).code == 1
    assert list(folder.iterdir()) == []


def test_help_and_version_are_0(relight):
    for words in (["--help"], ["--version"], ["render", "--help"], ["info", "--help"]):
        done = relight(*words)
        assert done.code == 0
        assert "relight" in done.out
        assert done.err == ""


def test_help_lists_the_commands(relight):
    done = relight("--help")
    for command in ("render", "channels", "turntable", "rigs", "info"):
        assert f"\n  {command} " in done.out


@pytest.mark.parametrize("words", ["--help", "render --help", "channels --help", "rigs", "rendr"])
def test_light_work_loads_no_network_library(words):
    script = (
        "import sys; from app.cli.main import main; main(sys.argv[1:]);"
        "heavy = {'torch', 'cv2', 'moderngl', 'imgui_bundle', 'skimage'};"
        "print(sorted(heavy & set(sys.modules)), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", script, *words.split()], capture_output=True, text=True)
    loaded = done.stderr.splitlines()[-1]
    assert loaded == "[]"


def test_a_reader_that_leaves_early_is_no_fault():
    script = "import sys; from app.cli.main import main; sys.exit(main(['rigs']))"
    command = f"'{sys.executable}' -c \"{script}\""
    done = subprocess.run(["bash", "-c", f"{command} | true; exit ${{PIPESTATUS[0]}}"], capture_output=True, text=True)
    assert done.returncode in (0, 141)
    assert done.stderr == ""


def test_python_m_app_is_the_same_command():
    done = subprocess.run([sys.executable, "-m", "app", "render"], capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr.startswith("relight render: ")


@pytest.mark.parametrize("closed", [">&-", "2>&-", "<&- >&- 2>&-"])
def test_closed_streams_are_no_fault_of_ours(closed):
    command = f"{sys.executable} -m app rigs"
    assert subprocess.run(["bash", "-c", f"{command} {closed}"]).returncode == 0


def test_a_panorama_is_read_where_errors_have_nowhere_to_go(tmp_path):
    write_image(tmp_path / "light.exr", np.ones((8, 16, 3), np.float32))
    script = (
        "import sys; from app.cli.main import _stand_in_for_closed_streams; _stand_in_for_closed_streams();"
        "from relight_core.imaging.read import read_photo; print(read_photo(sys.argv[1]).linear.shape)"
    )
    command = f"{sys.executable} -c '{script}' {tmp_path / 'light.exr'} 2>&-"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True)
    assert done.stdout == "(8, 16, 3)\n"
