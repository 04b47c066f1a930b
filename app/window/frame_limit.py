"""No more frames than a display shows: without a GPU nothing else holds them back."""

from __future__ import annotations

import time

import glfw

_USUAL_HZ = 60


class FrameLimit:
    """Waits between frames, so that a mouse which reports a thousand times a second leaves the networks their time.

    Args:
        hz: frames a second at the most.
    """

    def __init__(self, hz: float) -> None:
        self._step_s = 1.0 / hz
        self._due_s = 0.0

    def wait(self) -> bool:
        """Sleep until the next frame is due; whether that took any time, in which events may have come."""
        now = time.monotonic()
        waits = now < self._due_s
        if waits:
            time.sleep(self._due_s - now)
        self._due_s = max(now, self._due_s) + self._step_s
        return waits


def display_hz() -> int:
    """How many pictures a second the quickest display shows; 60 where no display tells."""
    modes = [glfw.get_video_mode(monitor) for monitor in glfw.get_monitors() or ()]
    return max((mode.refresh_rate for mode in modes if mode and mode.refresh_rate > 0), default=_USUAL_HZ)
