"""The window and its surroundings: no display, and real events from the X server."""

import os
import shutil
import subprocess
import sys
import threading

import glfw
import numpy as np
import pytest
from fake_relighter import FakeRelighter

from app.window.window import EditorWindow
from relight_core.imaging.write import write_image

WITHOUT_DISPLAY = """
from app.window.run import NoDisplayError, run_editor
try:
    run_editor()
except NoDisplayError as error:
    print("told:", error)
"""


def test_without_a_display_it_says_so_in_one_line():
    hidden = {"DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"}
    environment = {name: value for name, value in os.environ.items() if name not in hidden}
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_DISPLAY], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("told: no display to open a window on: ")
    assert "b'" not in done.stdout, "GLFW's words are told as words"
    assert done.stdout.count("\n") == 1


@pytest.mark.skipif(shutil.which("xdotool") is None, reason="xdotool is not installed")
def test_real_mouse_and_keys_reach_the_sleeping_window(display, tmp_path):
    path = tmp_path / "person.png"
    write_image(path, np.full((48, 64, 3), 0.4, np.float32))
    window = EditorWindow(FakeRelighter, path, size=(1024, 700))
    window.shelf.wait()
    assert window.settle()
    left, top = glfw.get_window_pos(window.handle)
    results = {}

    def poke(*words, until):
        # An event may come before the window is mapped, hence the repeats.
        for _ in range(200):
            subprocess.run(["xdotool", *words], check=True)
            if until():
                return True
        return False

    def user():
        try:
            subprocess.run(["xdotool", "mousemove", str(left + 500), str(top + 280)], check=True)
            results["wheel"] = poke("click", "4", until=lambda: window.state.edit.yaw_deg != 0.0)
            turned = window.state.edit.yaw_deg
            results["key"] = poke("key", "Right", until=lambda: window.state.edit.yaw_deg != turned)
        finally:
            glfw.set_window_should_close(window.handle, True)
            glfw.post_empty_event()

    thread = threading.Thread(target=user)
    thread.start()
    window.run()
    thread.join()
    window.close()
    assert results == {"wheel": True, "key": True}
