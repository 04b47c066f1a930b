"""Files that another program drops on the window, as the desktop hands them over."""

import ctypes.util
import shutil
import subprocess
import sys

import glfw
import numpy as np
import pytest
from x11_drag import VERSION, FileManager

from relight_core.imaging.write import write_image

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux") or ctypes.util.find_library("X11") is None, reason="drag and drop of X11"
)


@pytest.fixture
def file_manager(hand, display):
    manager = FileManager(display)
    yield manager
    manager.close()


def dropped(hand, manager, paths, at):
    hand.frames(2)
    left, top = glfw.get_window_pos(hand.window.handle)
    target = glfw.get_x11_window(hand.window.handle)
    manager.drop(paths, target, (round(left + at[0]), round(top + at[1])))
    hand.settle()


def test_a_photo_from_the_file_manager_is_opened_and_relit(hand, file_manager, photo_path):
    dropped(hand, file_manager, [photo_path], hand.centre())
    snapshot = hand.window.state.snapshot
    assert snapshot.opened.source.place == photo_path.resolve()
    assert snapshot.picture is not None


def test_a_name_with_a_space_and_an_umlaut_arrives_whole(hand, file_manager, tmp_path):
    path = tmp_path / "Änne's portrait 100%.png"
    write_image(path, np.full((64, 64, 3), 0.3, np.float32))
    dropped(hand, file_manager, [path], hand.centre())
    assert hand.window.state.snapshot.opened.source.place == path.resolve()


def test_several_photos_become_a_queue(hand, file_manager, tmp_path):
    paths = [tmp_path / f"{number}.png" for number in range(3)]
    for path in paths:
        write_image(path, np.full((64, 64, 3), 0.3, np.float32))
    dropped(hand, file_manager, paths, hand.centre())
    assert hand.window.state.snapshot.opened.source.place == paths[0]
    hand.key(glfw.KEY_PAGE_DOWN)
    assert hand.window.state.snapshot.opened.source.place == paths[1]


def test_a_portrait_on_the_light_panel_lends_its_light(hand, file_manager, photo_path):
    dropped(hand, file_manager, [photo_path], hand.centre())
    lender = photo_path.with_name("lender.png")
    write_image(lender, np.full((64, 64, 3), 0.5, np.float32))
    dropped(hand, file_manager, [lender], hand.panorama(0.5))
    snapshot = hand.window.state.snapshot
    assert snapshot.opened.source.place == photo_path.resolve()
    assert snapshot.light.source.name == str(lender)


@pytest.mark.skipif(shutil.which("xdotool") is None, reason="xdotool is not installed")
def test_with_shift_a_portrait_lends_its_light_although_the_file_manager_has_the_keyboard(
    hand, file_manager, photo_path
):
    dropped(hand, file_manager, [photo_path], hand.centre())
    lender = photo_path.with_name("lender.png")
    write_image(lender, np.full((64, 64, 3), 0.5, np.float32))
    nobody = ctypes.c_ulong(0)
    file_manager.x.XSetInputFocus(file_manager.display, nobody, 0, nobody)
    file_manager.x.XSync(file_manager.display, 0)
    subprocess.run(["xdotool", "keydown", "shift"], check=True)
    try:
        dropped(hand, file_manager, [lender], hand.centre())
    finally:
        subprocess.run(["xdotool", "keyup", "shift"], check=True)
    state = hand.window.state
    assert (state.light.kind, state.snapshot.opened.source.place) == ("portrait", photo_path.resolve())
    dropped(hand, file_manager, [lender], hand.centre())
    assert state.snapshot.opened.source.place == lender.resolve()


_LEFT_ALONE = """
import glfw
from app.window.glfw_window import open_window
window = open_window("alone", (300, 200))
print(glfw.get_x11_window(window), *glfw.get_window_pos(window), flush=True)
for _ in range(int(input())):
    glfw.wait_events_timeout(0.05)
print("still here")
"""


def test_a_file_manager_that_goes_in_the_middle_of_a_drag_does_not_take_the_window_along(display):
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", _LEFT_ALONE], text=True, **pipes) as program:
        target, left, top = (int(word) for word in program.stdout.readline().split())
        manager = FileManager(display)
        manager.send(target, "XdndEnter", VERSION << 24, manager.atom("text/uri-list"))
        manager.send(target, "XdndPosition", 0, (left + 50) << 16 | (top + 50), 0, manager.atom("XdndActionCopy"))
        manager.close()
        said, _ = program.communicate("20\n")
    assert (said, program.returncode) == ("still here\n", 0)
