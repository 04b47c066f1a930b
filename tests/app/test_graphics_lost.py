"""Graphics that fail before, while or after the window opens: it opens again or ends, and the work is kept."""

import ctypes
import os
import subprocess
import sys

import moderngl
import pytest
from fake_relighter import FakeRelighter
from window_hand import HEIGHT, WIDTH, Hand, close_to

from app.document.autosave import leftovers
from app.window.gl_interface import InterfacePainter
from app.window.gl_pictures import GlPictures
from app.window.graphics import DriverError, GraphicsLostError, Restarts
from app.window.window import EditorWindow
from relight_core.imaging.view_transform import apply_view

SOFTWARE = ("LIBGL_ALWAYS_SOFTWARE", "__GLX_VENDOR_LIBRARY_NAME")
OPEN_AND_TELL = """
from app.window.window import EditorWindow
from app.window.run import NoDisplayError
try:
    EditorWindow(lambda: None)
except NoDisplayError as error:
    print("told:", error)
"""


@pytest.fixture(autouse=True)
def environment(display, monkeypatch):
    """What a restart in software changes is changed back."""
    monkeypatch.setenv(SOFTWARE[0], "1")
    monkeypatch.setenv(SOFTWARE[1], os.environ.get(SOFTWARE[1], "mesa"))


@pytest.fixture
def edited(display, photo_path, tmp_path):
    """A window that keeps unsaved work, with some in it."""
    window = EditorWindow(FakeRelighter, photo_path, size=(WIDTH, HEIGHT), settings_path=tmp_path / "config" / "s.json")
    hand = Hand(window, (WIDTH, HEIGHT))
    hand.settle()
    hand.see_every_pixel()
    hand.move(hand.centre())
    hand.wheel(2)
    assert window.state.edit.yaw_deg > 0
    yield hand
    window.close()


def once(function, error):
    """The function, that raises instead the first time."""
    waiting = [error]

    def wrapped(*arguments, **named):
        if waiting:
            raise waiting.pop()
        return function(*arguments, **named)

    return wrapped


@pytest.mark.parametrize(
    ("owner", "name", "error"),
    [
        (GlPictures, "update", moderngl.Error("cannot create texture")),
        (GlPictures, "viewport", moderngl.Error("out of memory")),
        (InterfacePainter, "repaint", DriverError("GL_UNKNOWN_ERROR")),
    ],
    ids=["uploading", "drawing", "context lost"],
)
def test_a_driver_that_fails_once_is_started_again_with_the_same_picture(edited, monkeypatch, owner, name, error):
    window, before = edited.window, edited.window.state.document()
    handle = window.handle
    monkeypatch.setattr(owner, name, once(getattr(owner, name), error))
    window.engine.say("something to show")
    window.frame()
    assert window.handle is not handle
    edited.settle()
    assert window.state.document() == before
    assert close_to(edited.picture_pixels(96, 128), apply_view(window.state.snapshot.picture.relit.image))
    assert "Nothing is lost" in window.state.snapshot.message.text


@pytest.mark.skipif(sys.platform != "linux", reason="names the library")
def test_an_error_that_the_driver_only_notes_is_seen(edited):
    handle = edited.window.handle
    ctypes.CDLL("libGL.so.1").glEnable(0xDEAD)
    edited.window.frame()
    assert edited.window.handle is not handle


def test_a_driver_that_fails_for_good_ends_the_editor_and_the_work_is_kept(edited, tmp_path, monkeypatch):
    document = edited.window.state.document()
    monkeypatch.setattr(GlPictures, "viewport", lambda *_: (_ for _ in ()).throw(moderngl.Error("no\ncontext")))
    monkeypatch.delenv(SOFTWARE[0])
    edited.window.frame()
    edited.window.frame()
    assert os.environ[SOFTWARE[0]] == "1"
    with pytest.raises(GraphicsLostError, match="unsaved work is kept") as told:
        edited.window.frame()
    assert "no context" in str(told.value)
    assert "\n" not in str(told.value)
    edited.window.close()
    (left,) = leftovers(tmp_path / "config" / "unsaved")
    assert left.document == document


def test_work_that_has_no_place_is_not_said_to_be_kept(edited, tmp_path, monkeypatch):
    folder = tmp_path / "config" / "unsaved"
    edited.window.close()
    for path in folder.iterdir():
        path.unlink()
    folder.rmdir()
    folder.write_text("in the way")
    window = EditorWindow(FakeRelighter, edited.window.state.document().photo.path, size=(WIDTH, HEIGHT))
    assert not window._deeds.keep_now()
    window.close()


def test_any_other_fault_leaves_the_work_as_well(edited, tmp_path, monkeypatch):
    document = edited.window.state.document()
    monkeypatch.setattr("app.ui.editor.draw", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        edited.window.frame()
    edited.window.close()
    (left,) = leftovers(tmp_path / "config" / "unsaved")
    assert left.document == document


@pytest.mark.parametrize("change", [{"MESA_GL_VERSION_OVERRIDE": "2.1"}, {"MESA_GLSL_VERSION_OVERRIDE": "110"}])
def test_an_opengl_that_is_too_old_is_told_in_one_line(display, change):
    done = subprocess.run(
        [sys.executable, "-c", OPEN_AND_TELL], env=os.environ | change, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("told: ")
    assert done.stdout.count("\n") == 1


def test_shaders_that_do_not_compile_are_told_and_the_window_is_gone(display, monkeypatch):
    nonsense = 2 * ["#version 330\nnonsense"]
    monkeypatch.setattr("app.window.gl_interface.shader_program", lambda context, _: context.program(*nonsense))
    with pytest.raises(RuntimeError, match="OpenGL can't run the editor"):
        EditorWindow(FakeRelighter)


def test_restarts_are_forgiven_after_a_while(monkeypatch):
    restarts = Restarts()
    assert [restarts.allow(now_s) for now_s in (100.0, 101.0, 102.0)] == [True, True, False]
    assert restarts.allow(170.0)
