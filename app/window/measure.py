"""Measures how quick the window is for the one who sits before it, with real networks and synthetic events."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import glfw
import numpy as np

from app.engine.pace import yield_to_the_window
from app.engine.sources import RelighterLike
from app.window.frame_limit import FrameLimit
from app.window.window import EditorWindow
from relight_core.errors import InputError
from relight_core.pipeline.auto_quality import AUTO, QualityChoice
from relight_core.process_memory import memory_in_use_mib

_STEP_DEG = 7.0
_GIVE_UP_S = 300.0
_UNCOUNTED_S = 1.0
"""At the beginning of the rest, in which the window still settles."""

_DISPLAY_HZ = 60.0
"""As the window's own loop holds frames back on a usual display."""


@dataclass(frozen=True)
class Spread:
    """Median and 95th percentile of many measurements, in milliseconds."""

    median_ms: float
    p95_ms: float

    @classmethod
    def of(cls, seconds: list[float]) -> Spread:
        """The spread of durations in seconds, at least one."""
        median, high = np.percentile(np.array(seconds) * 1000.0, [50.0, 95.0])
        return cls(float(median), float(high))


@dataclass(frozen=True)
class WindowSpeed:
    """What was measured; None and the empty tuple stand for what was not, or not yet.

    Attributes:
        frame: one frame, of 60 a second at most, while a drag makes the networks run again and again.
        rotation, shadow, exposure: from the hand's movement to the end of the frame that shows its result.
        frames, updates: how many frames were drawn during the drag, and how many results came.
        idle_cpu: share of one core used while nothing happens.
        memory_mb: MiB of resident memory after each opening of a photo, None where the system does not tell.
        opening_s: how long each opening took, until all of the photo was known and shown.
    """

    frame: Spread | None = None
    rotation: Spread | None = None
    shadow: Spread | None = None
    exposure: Spread | None = None
    frames: int | None = None
    updates: int | None = None
    idle_cpu: float | None = None
    memory_mb: tuple[float | None, ...] = ()
    opening_s: tuple[float, ...] = ()


def measure_window(
    make_relighter: Callable[[], RelighterLike],
    photos: list[Path],
    *,
    size: tuple[int, int] = (1440, 900),
    drag_s: float = 8.0,
    repeats: int = 40,
    idle_s: float = 6.0,
    openings: int = 0,
    quality: str = AUTO,
) -> Iterator[WindowSpeed]:
    """Open the editor on the first photo, drag, wait, and open photos in turn.

    Args:
        photos: at least one.
        drag_s: how long the light is dragged; one frame at least.
        repeats: movements timed for each slider, at least 1.
        idle_s: how long the window is left alone.
        openings: how many photos are opened in turn, over and over, for the memory.
        quality: the tier, or "auto".

    Yields:
        All that was measured so far, after each part and after each opening.

    Raises:
        NoDisplayError: no display, or one without OpenGL 3.3.
        InputError: a photo that can't be opened, or has no face.
        TimeoutError: a result took longer than five minutes.
    """
    window = EditorWindow(make_relighter, photos[0], size=size, on_engine_start=yield_to_the_window)
    window.state.quality = QualityChoice(quality)
    try:
        window.shelf.wait()
        _settle_on_the_photo(window)
        for speed in _with_hand(window, drag_s, repeats):
            yield speed
        speed = replace(speed, idle_cpu=_idle_cpu(window, idle_s))
        yield speed
        yield from _with_openings(speed, window, photos, openings)
    finally:
        window.close()


def _with_hand(window: EditorWindow, drag_s: float, repeats: int) -> Iterator[WindowSpeed]:
    hand = _Hand(window)
    frames, updates = hand.drag(drag_s)
    speed = WindowSpeed(frame=Spread.of(frames), frames=len(frames), updates=updates)
    yield speed
    for name, change in (("rotation", _turn), ("shadow", _deepen), ("exposure", _brighten)):
        speed = replace(speed, **{name: Spread.of(hand.latencies(change, repeats))})
        yield speed
    hand.rest()


def _with_openings(speed: WindowSpeed, window: EditorWindow, photos: list[Path], count: int) -> Iterator[WindowSpeed]:
    for seconds, memory_mb in _open_in_turn(window, photos, count):
        opened = {"memory_mb": (*speed.memory_mb, memory_mb), "opening_s": (*speed.opening_s, seconds)}
        speed = replace(speed, **opened)
        yield speed


class _Hand:
    """Holds the mouse down on the lit ball, so that the window works at the quality of a drag."""

    def __init__(self, window: EditorWindow) -> None:
        self._window = window
        window.state.look.light_ball = True
        window.frame()
        self._at = window.state.look.ball_at
        window.on_mouse_move(None, *self._at)
        window.frame()
        window.on_mouse_button(None, glfw.MOUSE_BUTTON_LEFT, glfw.PRESS, 0)
        window.frame()

    def drag(self, seconds: float) -> tuple[list[float], int]:
        """Seconds of each frame while the mouse moves, and how many pictures came meanwhile.

        The mouse moves on and on: where it has just been the networks' results are kept, and they would rest.
        """
        window, x, y = self._window, *self._at
        durations, updates, shown = [], 0, window.state.snapshot.picture
        end, step, limit = time.perf_counter() + seconds, 0, FrameLimit(_DISPLAY_HZ)
        while not durations or time.perf_counter() < end:
            step += 1
            limit.wait()
            window.on_mouse_move(None, x + step, y)
            began = time.perf_counter()
            window.frame()
            glfw.poll_events()
            durations.append(time.perf_counter() - began)
            updates += window.state.snapshot.picture is not shown
            shown = window.state.snapshot.picture
        window.on_mouse_move(None, x, y)
        _until(window, lambda: _is_answered(window))
        return durations, updates

    def latencies(self, change: Callable[[EditorWindow, int], None], repeats: int) -> list[float]:
        """Seconds from each change to the end of the frame that shows its result."""
        durations = []
        for index in range(repeats):
            began = time.perf_counter()
            change(self._window, index)
            _until(self._window, lambda: _is_answered(self._window))
            self._window.context.finish()
            durations.append(time.perf_counter() - began)
        return durations

    def rest(self) -> None:
        """Let go, and wait for the finished picture."""
        self._window.on_mouse_button(None, glfw.MOUSE_BUTTON_LEFT, glfw.RELEASE, 0)
        self._window.frame()
        _settle(self._window)


def _turn(window: EditorWindow, _index: int) -> None:
    window.state.turn(_STEP_DEG)


def _deepen(window: EditorWindow, index: int) -> None:
    window.state.change(shadow=0.2 + 0.37 * (index % 5))


def _brighten(window: EditorWindow, index: int) -> None:
    window.state.change(exposure_ev=-0.8 + 0.4 * (index % 5))


def _is_answered(window: EditorWindow) -> bool:
    """Whether the frame that was drawn last shows what is wanted."""
    if window.pictures.is_ahead:
        return False
    picture, edit = window.state.snapshot.picture, window.state.edit
    return picture is not None and (picture.edit.yaw_deg, picture.edit.shadow) == (edit.yaw_deg, edit.shadow)


def _until(window: EditorWindow, reached: Callable[[], bool]) -> None:
    """Draw frames as the window's own loop does, until one was drawn with this true."""
    give_up = time.perf_counter() + _GIVE_UP_S
    while True:
        window.frame()
        if reached():
            return
        if time.perf_counter() > give_up:
            raise TimeoutError("no result within five minutes")
        glfw.wait_events_timeout(0.03)


def _settle(window: EditorWindow) -> None:
    if not window.settle(_GIVE_UP_S):
        raise TimeoutError("no result within five minutes")


def _settle_on_the_photo(window: EditorWindow) -> None:
    """Wait for a picture of the photo that was asked for last."""
    wish = window.state.photo
    _settle(window)
    picture, message = window.state.snapshot.picture, window.state.snapshot.message
    if picture is None or picture.opened.source is not wish:
        raise InputError(message.text if message else f"{wish.path}: gives no picture; choose another photo")


def _idle_cpu(window: EditorWindow, seconds: float) -> float:
    """Share of a core while the window's loop runs and nothing happens; its first second does not count."""

    def bell() -> None:
        for rest_s in (_UNCOUNTED_S, seconds):
            if interrupted.wait(rest_s):
                return
            marks.append((time.perf_counter(), time.process_time()))
        glfw.set_window_should_close(window.handle, True)
        glfw.post_empty_event()

    marks: list[tuple[float, float]] = []
    interrupted, ringer = threading.Event(), threading.Thread(target=bell)
    ringer.start()
    try:
        window.run()
    except BaseException:
        # The window is about to go, and there will be nothing to ring at.
        interrupted.set()
        raise
    finally:
        ringer.join()
    (wall_start, cpu_start), (wall_end, cpu_end) = marks
    return (cpu_end - cpu_start) / (wall_end - wall_start)


def _open_in_turn(window: EditorWindow, photos: list[Path], openings: int) -> Iterator[tuple[float, float | None]]:
    """Seconds, and the memory after it, of each opening."""
    for index in range(openings):
        began = time.perf_counter()
        window.state.open_photo(photos[index % len(photos)])
        _settle_on_the_photo(window)
        yield time.perf_counter() - began, memory_in_use_mib()
