"""What the window's tests share: a display (an Xvfb, or the machine's own), a window on it, a photo in it."""

import gc
import os
import shutil
import subprocess
from dataclasses import replace

import moderngl
import numpy as np
import pytest
from fake_relighter import FakeRelighter
from opened_things import photo_files
from window_hand import HEIGHT, WIDTH, Hand

from app.engine.engine import Engine
from app.engine.jobs import Jobs
from app.window.gl_viewport import PicturePainter
from app.window.glfw_window import close_window, open_window
from app.window.window import EditorWindow
from relight_core.imaging.write import write_image
from relight_core.lighting.soft_box import SoftBox


@pytest.fixture(scope="session")
def display():
    """Name of an X display on which windows may be opened."""
    program = shutil.which("Xvfb")
    if program is None:
        if os.environ.get("DISPLAY"):
            yield os.environ["DISPLAY"]
            return
        pytest.skip("no Xvfb and no display to open a window on")
    read_end, write_end = os.pipe()
    command = [program, "-displayfd", str(write_end), "-screen", "0", "1600x1000x24", "-nolisten", "tcp", "-noreset"]
    server = subprocess.Popen(command, pass_fds=[write_end], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os.close(write_end)
    with os.fdopen(read_end) as answer:
        number = answer.readline().strip()
    if not number:
        server.wait()
        pytest.fail("Xvfb did not start")
    changes = {"DISPLAY": f":{number}", "LIBGL_ALWAYS_SOFTWARE": "1", "WAYLAND_DISPLAY": ""}
    before = {name: os.environ.get(name) for name in changes}
    os.environ.update(changes)
    yield f":{number}"
    for name, value in before.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value
    server.terminate()
    server.wait()


@pytest.fixture(scope="module")
def context(display):
    """A hidden window's own, with a painter: one without a window, made in another way, breaks the windows after it."""
    window = open_window("relight", (64, 64), visible=False)
    context = moderngl.create_context(require=330)
    context.painter = PicturePainter(context, (0.1, 0.1, 0.1))
    yield context
    context.painter.close()
    context.release()
    close_window(window)


@pytest.fixture
def photo_path(tmp_path):
    rows, columns = np.mgrid[0:96, 0:128].astype(np.float32)
    linear = np.dstack([0.2 + columns / 400, 0.25 + rows / 500, np.full_like(rows, 0.3)])
    path = tmp_path / "person.png"
    write_image(path, linear)
    return path


@pytest.fixture
def photos(tmp_path):
    """Files of two that nothing reads."""
    return photo_files(tmp_path, "a.jpg", "b.jpg")


@pytest.fixture
def folder(tmp_path):
    """Where settings and unsaved work are kept."""
    return tmp_path / "settings"


@pytest.fixture
def said():
    """Lines that the user is told, and whether each is an error."""
    return []


@pytest.fixture
def jobs(said):
    jobs = Jobs(lambda text, is_error: said.append((text, is_error)))
    yield jobs
    jobs.close(cancel=True)


@pytest.fixture
def relighter():
    return FakeRelighter()


@pytest.fixture
def published():
    """The snapshots there were whenever the engine woke the window."""
    return []


@pytest.fixture
def engine(relighter, published):
    engine = Engine(lambda: relighter, lambda: published.append(engine.snapshot()))
    yield engine
    relighter.gate.set()
    engine.close()


@pytest.fixture(scope="module")
def windows(display):
    """A display whose windows are gone after a module: each keeps 20 MiB until the collector finds its cycles."""
    yield display
    gc.collect()


@pytest.fixture
def hand(windows, relighter, photo_path):
    window = EditorWindow(lambda: relighter, size=(WIDTH, HEIGHT))
    hand = Hand(window, (WIDTH, HEIGHT))
    yield hand
    relighter.gate.set()
    window.close()


@pytest.fixture
def opened(hand, photo_path):
    hand.drop(photo_path)
    hand.see_every_pixel()
    return hand


@pytest.fixture
def pair(opened):
    """Two boxes at the height at which the hand meets the panorama; the first is selected."""
    state = opened.window.state
    opened.double_click(opened.panorama(0.5))
    height = state.light_edit.boxes[0].elevation_deg
    boxes = SoftBox(180.0, height), SoftBox(60.0, height)
    state.light_edit, state.selected_box = replace(state.light_edit, boxes=boxes), 0
    opened.settle()
    return boxes
