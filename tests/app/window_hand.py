"""A user's hand for the window's tests: mouse, keys and drops, and eyes on its pixels."""

from __future__ import annotations

from pathlib import Path

import cv2
import glfw
import numpy as np
from fake_relighter import LONG_S
from imgui_bundle import imgui

from app.engine.sources import LightSource
from app.ui.viewport.view import View

LIGHT_PANEL, EFFECTS_PANEL, STRIPS, TOOLBAR = 255, 240, 141, 32
"""Pixels: the panels' widths, the height of filmstrip and status line, and of the toolbar, at scale 1."""

PANORAMA_X, PANORAMA_WIDTH, PANORAMA_Y = 14, 227, 90
KNOB_GREY = 194
PATIENCE = 400
"""Of frames or events until a thing that a test waits for has come."""
WIDTH, HEIGHT = 1024, 700
"""Of the window, in pixels."""


class Hand:
    def __init__(self, window, size):
        self.window = window
        self.width, self.height = size
        # However slow a frame is, a key that was pressed once counts once.
        imgui.get_io().key_repeat_delay = LONG_S

    def frames(self, count=1):
        for _ in range(count):
            self.window.frame()

    def settle(self):
        assert self.window.settle(LONG_S)

    def answer(self, label):
        """Chooses an answer to the one question that is asked."""
        (question,) = self.window.state.asking.questions
        self.window.state.asking.drop(question.key)
        dict(question.choices)[label]()
        self.settle()

    def centre(self):
        return (LIGHT_PANEL + self.width - EFFECTS_PANEL) / 2, (self.height - STRIPS + TOOLBAR) / 2

    def panorama(self, along):
        return PANORAMA_X + along * PANORAMA_WIDTH, PANORAMA_Y

    def knobs(self):
        """Where the knobs of the right panel's sliders are, from the top down."""
        self.move((self.width / 2, self.height - 3))
        panel = self.window.screenshot()[: self.height - STRIPS, self.width - EFFECTS_PANEL :]
        mask = (np.abs(panel.astype(int) - KNOB_GREY) <= 3).all(axis=2).astype(np.uint8)
        _, _, stats, centres = cv2.connectedComponentsWithStats(mask)
        large = [tuple(centre) for centre, stat in zip(centres[1:], stats[1:], strict=True) if stat[4] > 60]
        return [(x + self.width - EFFECTS_PANEL, y) for x, y in sorted(large, key=lambda centre: centre[1])]

    def resize(self, size):
        """Give the window another size and wait until it has it."""
        glfw.set_window_size(self.window.handle, *size)
        for _ in range(PATIENCE):
            if glfw.get_framebuffer_size(self.window.handle) == size:
                break
            glfw.wait_events_timeout(0.05)
        assert glfw.get_framebuffer_size(self.window.handle) == size
        self.width, self.height = size

    def move(self, at):
        self.window.on_mouse_move(None, *at)
        self.frames(2)

    def button(self, down, ctrl=False):
        mods = glfw.MOD_CONTROL if ctrl else 0
        self.window.on_mouse_button(None, glfw.MOUSE_BUTTON_LEFT, glfw.PRESS if down else glfw.RELEASE, mods)
        self.frames(2)

    def click(self, at, ctrl=False):
        self.move(at)
        self.button(True, ctrl)
        self.button(False, ctrl)
        self.button_mods_released()

    def double_click(self, at):
        """Two clicks; as far apart as a slow machine's frames are, they count as one double click."""
        settings = imgui.get_io()
        usual_s = settings.mouse_single_click_delay, settings.mouse_double_click_time
        settings.mouse_single_click_delay, settings.mouse_double_click_time = 2.0 * LONG_S, float(LONG_S)
        self.move(at)
        for down in (True, False, True, False):
            state = glfw.PRESS if down else glfw.RELEASE
            self.window.on_mouse_button(None, glfw.MOUSE_BUTTON_LEFT, state, 0)
        self.frames(6)
        settings.mouse_single_click_delay, settings.mouse_double_click_time = usual_s
        self.settle()

    def button_mods_released(self):
        self.window.on_key(None, glfw.KEY_LEFT_CONTROL, 0, glfw.RELEASE, 0)
        self.frames(1)

    def drag(self, start, end, steps=6, settle_each_step=False):
        self.move(start)
        self.button(True)
        for step in range(1, steps + 1):
            share = step / steps
            self.move(tuple(a + (b - a) * share for a, b in zip(start, end, strict=True)))
            if settle_each_step:
                self.settle()
        self.button(False)
        self.settle()

    def wheel(self, steps, ctrl=False):
        if ctrl:
            self.hold(glfw.KEY_LEFT_CONTROL, glfw.MOD_CONTROL)
        self.window.on_wheel(None, 0.0, float(steps))
        self.frames(2)
        if ctrl:
            self.release(glfw.KEY_LEFT_CONTROL)
        self.settle()

    def hold(self, key, mods=0):
        self.window.on_key(None, key, 0, glfw.PRESS, mods)
        self.frames(2)

    def release(self, key):
        self.window.on_key(None, key, 0, glfw.RELEASE, 0)
        self.frames(2)

    def key(self, key, shift=False, ctrl=False):
        self.hold(key, (glfw.MOD_SHIFT if shift else 0) | (glfw.MOD_CONTROL if ctrl else 0))
        self.release(key)
        self.settle()

    def type(self, text):
        self.frames(2)
        for letter in text:
            key = {".": glfw.KEY_PERIOD}.get(letter, ord(letter))
            self.window.on_key(None, key, 0, glfw.PRESS, 0)
            self.window.on_character(None, ord(letter))
            self.frames(1)
            self.window.on_key(None, key, 0, glfw.RELEASE, 0)
            self.frames(1)

    def drop(self, path: Path, at=None):
        self.window.on_drop(None, [str(path)], at or self.centre())
        self.settle()

    def light(self, rig):
        self.window.state.choose_light(LightSource("rig", rig))
        self.settle()

    def see_every_pixel(self):
        """One screen pixel for each of the picture's."""
        picture_height, picture_width = self.window.state.snapshot.opened.photo.linear.shape[:2]
        self.window.state.view = View(False, 1.0, picture_width / 2, picture_height / 2)
        self.frames(1)

    def viewport(self):
        return self.window.pictures.viewport_pixels()

    def viewport_width(self):
        self.frames(1)
        return self.viewport().shape[1]

    def picture_pixels(self, height, width):
        """The picture's own pixels while every one of them is seen."""
        shown = self.viewport()
        top, left = (shown.shape[0] - height + 1) // 2, (shown.shape[1] - width + 1) // 2
        return shown[top : top + height, left : left + width]

    def status_has_error_colour(self):
        line = self.window.screenshot()[-28:].astype(int)
        return ((line[..., 0] > 150) & (line[..., 0] - line[..., 2] > 60)).any()


def close_to(shown, expected_srgb):
    return np.abs(shown.astype(np.float32) - expected_srgb * 255).max() <= 1.0


def places_drawn(monkeypatch, module, widget):
    """The middle of each widget of a kind that was drawn last, by its label."""
    places, draw = {}, getattr(module, widget)

    def drawn(label, *rest, **more):
        answer = draw(label, *rest, **more)
        corner, end = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        places[label.partition("##")[0]] = (corner.x + end.x) / 2, (corner.y + end.y) / 2
        return answer

    monkeypatch.setattr(module, widget, drawn)
    return places
