"""How long the window rests between two frames: for ever, once nothing moves."""

from __future__ import annotations

import time

import glfw

_LIVELY_S, _LIVELY_STEP_S = 0.7, 0.03
_PLAYING_STEP_S = 1 / 60
_CURSOR_BLINK_S = 0.25
_DEEDS_STEP_S = 0.1


class Rest:
    """Waits for events. For a moment after anything has happened it ticks on, for what needs several frames."""

    def __init__(self) -> None:
        self._lively_until_s = 0.0
        self.stir()

    def stir(self) -> None:
        """Something has happened, such as a frame that heard keys or showed something new."""
        self._lively_until_s = time.monotonic() + _LIVELY_S

    def is_deep(self, playing: bool, typing: bool, waiting: bool) -> bool:
        """Whether the next rest lasts until an event comes; as of `until_due`."""
        return self._step_s(playing, typing, waiting) is None

    def until_due(self, playing: bool, typing: bool, waiting: bool) -> None:
        """Wait until the next frame should be drawn, and take in the events that came.

        Args:
            playing: something moves by itself.
            typing: a cursor blinks.
            waiting: something has to be looked at now and then although nothing happens.
        """
        began_s, step_s = time.monotonic(), self._step_s(playing, typing, waiting)
        if step_s is None:
            glfw.wait_events()
        else:
            glfw.wait_events_timeout(step_s)
        if step_s is None or time.monotonic() - began_s < 0.9 * step_s:
            self.stir()

    def _step_s(self, playing: bool, typing: bool, waiting: bool) -> float | None:
        if playing:
            return _PLAYING_STEP_S
        if time.monotonic() < self._lively_until_s:
            return _LIVELY_STEP_S
        if typing:
            return _CURSOR_BLINK_S
        return _DEEDS_STEP_S if waiting else None
