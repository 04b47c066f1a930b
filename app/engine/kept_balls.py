"""Thumbnails of the lights from files, kept from one run to the next: drawing one anew may take the networks."""

from __future__ import annotations

import io
import logging
import os
from hashlib import blake2b
from pathlib import Path

import numpy as np
from PIL import Image

from app.engine.screen import BALL_SIZE
from relight_core.errors import InputError
from relight_core.imaging.files import file_bytes, whole_file

MOST = 32
_DAMAGE = (OSError, ValueError, SyntaxError, InputError, Image.DecompressionBombError)
_log = logging.getLogger(__name__)


class KeptBalls:
    """A folder of small PNG files, one for each light; what can't be read is not there.

    Args:
        folder: made when the first is kept.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._known: dict[Path, np.ndarray | None] = {}

    def ball(self, kind: str, name: str) -> np.ndarray | None:
        """(96, 96, 4) uint8 as it was kept of a light, by its kind and file."""
        path = self._path(kind, name)
        if path not in self._known:
            self._known[path] = _read(path)
        return self._known[path]

    def keep(self, kind: str, name: str, ball: np.ndarray) -> None:
        """Keep the (96, 96, 4) uint8 ball of a light; the oldest make way."""
        path = self._path(kind, name)
        known = self.ball(kind, name)
        if known is not None and np.array_equal(known, ball):
            return
        self._known[path] = ball
        content = io.BytesIO()
        Image.fromarray(ball).save(content, "PNG")
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            with whole_file(path) as part:
                part.write_bytes(content.getvalue())
            for old in sorted(self._folder.glob("*.png"), key=lambda entry: entry.stat().st_mtime)[:-MOST]:
                old.unlink()
        except (OSError, InputError) as error:
            _log.warning("the thumbnail of a light is not kept: %s", error)

    def _path(self, kind: str, name: str) -> Path:
        place = f"{kind}:{os.path.abspath(name)}".encode("utf-8", "surrogateescape")
        return self._folder / f"{blake2b(place, digest_size=12).hexdigest()}.png"


def _read(path: Path) -> np.ndarray | None:
    try:
        with Image.open(io.BytesIO(file_bytes(path))) as image:
            fits = image.size == (BALL_SIZE, BALL_SIZE) and image.mode == "RGBA"
            return np.asarray(image) if fits else None
    except _DAMAGE:
        return None
