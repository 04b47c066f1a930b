"""Thumbnails of the bundled lights, drawn in the background one by one."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np

from app.engine.kept_balls import KeptBalls
from app.engine.screen import rig_for_screen
from app.engine.snapshot import OpenLight
from app.engine.sources import LightSource
from relight_core.lighting.rigs import read_bundled_rig, rig_names

_log = logging.getLogger(__name__)


class LightShelf:
    """The bundled lights in the order of their list, with what is known of each so far.

    Args:
        wake: called, on the shelf's thread, when another thumbnail is ready.
        folder: where the thumbnails of lights from files are kept; None keeps none.
    """

    def __init__(self, wake: Callable[[], None] = lambda: None, folder: Path | None = None) -> None:
        self._kept = KeptBalls(folder) if folder else None
        self.names: tuple[str, ...] = tuple(rig_names())
        self._wake = wake
        self._balls: dict[str, np.ndarray] = {}
        self._words: dict[str, tuple[str, str]] = {}
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._draw, name="relight-lights", daemon=True)
        self._thread.start()

    def ball(self, light: LightSource) -> np.ndarray | None:
        """(96, 96, 4) uint8: sRGB of a ball in that light and its coverage; None until it is drawn.

        For a light from a file as it was kept, by this run or one before.
        """
        if light.kind == "rig":
            return self._balls.get(light.name)
        return self._kept.ball(light.kind, light.name) if self._kept and light.name else None

    def keep(self, light: OpenLight | None) -> None:
        """Remember what a light from a file looks like."""
        if self._kept and light is not None and light.source.is_from_file:
            self._kept.keep(light.source.kind, light.source.name, light.ball)

    def words(self, name: str) -> tuple[str, str]:
        """Title and description."""
        return self._words.get(name, (name, ""))

    def wait(self) -> None:
        """Block until every thumbnail is drawn."""
        self._thread.join()

    def close(self) -> None:
        """End the thread after the thumbnail it draws."""
        self._closing.set()
        self._thread.join()

    def _draw(self) -> None:
        for name in self.names:
            if self._closing.is_set():
                return
            try:
                rig = read_bundled_rig(name)
                self._words[name] = (rig.title, rig.description)
                self._balls[name] = rig_for_screen(name)[2]
            except Exception as error:
                _log.error("no thumbnail of %s", name, exc_info=error)
            self._wake()
