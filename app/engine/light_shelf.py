"""Thumbnails of the bundled lights, drawn in the background one by one."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

import numpy as np

from app.engine.screen import rig_for_screen
from relight_core.lighting.rigs import read_bundled_rig, rig_names

_log = logging.getLogger(__name__)


class LightShelf:
    """The bundled lights in the order of their list, with what is known of each so far.

    Args:
        wake: called, on the shelf's thread, when another thumbnail is ready.
    """

    def __init__(self, wake: Callable[[], None] = lambda: None) -> None:
        self.names: tuple[str, ...] = tuple(rig_names())
        self._wake = wake
        self._balls: dict[str, np.ndarray] = {}
        self._words: dict[str, tuple[str, str]] = {}
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._draw, name="relight-lights", daemon=True)
        self._thread.start()

    def ball(self, name: str) -> np.ndarray | None:
        """(96, 96, 4) uint8: sRGB of a ball in that light and its coverage; None until it is drawn."""
        return self._balls.get(name)

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
