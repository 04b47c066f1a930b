"""What is really on the screen, which is drawn in parts: always what a frame drawn whole would show."""

import glfw
import numpy as np
import pytest
from PIL import Image, ImageGrab, features

pytestmark = pytest.mark.skipif(not features.check("xcb"), reason="no way to see the screen")


@pytest.fixture
def on_screen(hand, display):
    """The screen after a frame, and after all of the same frame was drawn: a pair of (h, w, 3) codes.

    The frame is one after which no other viewport waits to be shown.
    """

    def grab():
        hand.window.context.finish()
        left, top = glfw.get_window_pos(hand.window.handle)
        width, height = glfw.get_window_size(hand.window.handle)
        seen = ImageGrab.grab(bbox=(left, top, left + width, top + height), xdisplay=display)
        return np.asarray(seen.convert("RGB")).astype(int)

    def look():
        hand.frames(1)
        while hand.window.pictures.is_ahead:
            hand.frames(1)
        seen = grab()
        hand.window.on_refresh(None)
        hand.window._graphics.show()
        return seen, grab()

    return look


def assert_same(pair):
    seen, whole = pair
    differs = np.abs(seen - whole).max(axis=2) > 1
    assert not differs.any(), f"{differs.sum()} pixels differ, from {np.argwhere(differs).min(axis=0)} on"


def test_after_every_kind_of_change(opened, on_screen):
    assert_same(on_screen())
    x, y = opened.centre()
    for change in (
        lambda: opened.move((x, y)),
        lambda: opened.drag(opened.panorama(0.3), opened.panorama(0.5)),
        lambda: opened.move(opened.knobs()[0]),
        lambda: opened.window.state.change(shadow=1.7, exposure_ev=0.5),
        lambda: opened.light("neon"),
        lambda: opened.key(glfw.KEY_W),
        lambda: opened.key(glfw.KEY_3),
        lambda: opened.key(glfw.KEY_H),
        lambda: opened.wheel(3, ctrl=True),
        lambda: opened.key(glfw.KEY_F6),
        lambda: opened.window.on_character(None, ord("?")),
        lambda: opened.key(glfw.KEY_ESCAPE),
    ):
        change()
        opened.settle()
        assert_same(on_screen())


def test_in_the_midst_of_a_drag(opened, on_screen):
    x, y = opened.panorama(0.5)
    opened.move((x, y))
    opened.button(True)
    for step in range(1, 5):
        opened.window.on_mouse_move(None, x + 7 * step, y)
        assert_same(on_screen())
    opened.button(False)


@pytest.mark.parametrize("size", [(1300, 860), (820, 600)])
def test_after_the_window_was_resized(opened, on_screen, size):
    opened.resize(size)
    opened.window.shelf.wait()
    opened.frames(3)
    seen, whole = on_screen()
    assert_same((seen, whole))
    differs = np.abs(seen - opened.window.screenshot().astype(int)).max(axis=2) > 1
    assert differs.mean() < 1e-4


def test_what_was_lost_is_drawn_again_when_the_system_asks(opened, on_screen):
    window = opened.window
    on_screen()
    window.context.screen.clear(1.0, 0.0, 0.0)
    glfw.swap_buffers(window.handle)
    left, top = glfw.get_window_pos(window.handle)
    assert Image.Image.getpixel(ImageGrab.grab(bbox=(left, top, left + 1, top + 1)), (0, 0))[:3] == (255, 0, 0)
    window.on_refresh(None)
    assert_same(on_screen())


def test_nothing_is_drawn_where_nothing_changes(opened, monkeypatch):
    opened.window.shelf.wait()
    opened.frames(3)
    swaps = []
    monkeypatch.setattr(glfw, "swap_buffers", lambda handle: swaps.append(handle))
    opened.frames(3)
    assert swaps == []
    opened.window.state.change(exposure_ev=0.7)
    opened.frames(1)
    assert len(swaps) == 1
