"""Histogram and waveform as textures, computed when they are looked at and their picture is another one."""

from __future__ import annotations

import moderngl
import numpy as np

from app.window.gl_textures import TextureSlot
from relight_core.imaging.scopes import Extremes, extremes, histogram_picture, thinned, waveform_picture
from relight_core.imaging.view_transform import apply_view

_DRAW = {"histogram": histogram_picture, "waveform": waveform_picture}


class Scopes:
    """One texture for each kind of scope, and the extremes of the picture looked at last."""

    def __init__(self, context: moderngl.Context) -> None:
        self._slots = {kind: TextureSlot(context) for kind in _DRAW}
        self._drawn: dict[str, tuple] = {}
        self._extremes: tuple[tuple, Extremes] | None = None

    def scope(self, kind: str, pixels: np.ndarray, exposure_ev: float) -> moderngl.Texture:
        """The scope of a picture.

        Args:
            kind: "histogram" or "waveform".
            pixels: (h, w, 3) uint8 sRGB, or (h, w, 3 or 4) float16 linear.
            exposure_ev: for linear pixels.
        """
        slot = self._slots[kind]
        if not is_same_reading(self._drawn.get(kind), pixels, exposure_ev):
            self._drawn[kind] = (pixels, exposure_ev)
            few = thinned(pixels)
            slot.show(_DRAW[kind](_codes(few, exposure_ev), _seen(few)))
        return slot.texture

    @property
    def found(self) -> Extremes | None:
        """The extremes that were counted last."""
        return self._extremes[1] if self._extremes else None

    def extremes(self, pixels: np.ndarray, exposure_ev: float) -> Extremes:
        """What share of (h, w, 3 or 4) linear pixels the screen can't show."""
        if self._extremes is None or not is_same_reading(self._extremes[0], pixels, exposure_ev):
            few = thinned(pixels)
            self._extremes = ((pixels, exposure_ev), extremes(few[..., :3], exposure_ev, _seen(few)))
        return self._extremes[1]

    def close(self) -> None:
        """Free everything."""
        for slot in self._slots.values():
            slot.close()


def _codes(pixels: np.ndarray, exposure_ev: float) -> np.ndarray:
    if pixels.dtype == np.uint8:
        return pixels
    return np.rint(apply_view(pixels[..., :3], exposure_ev) * 255).astype(np.uint8)


def _seen(pixels: np.ndarray) -> np.ndarray | None:
    """Where (h, w, 4) pixels are not transparent; None where there is no alpha."""
    return pixels[..., 3] > 0 if pixels.shape[2] == 4 else None


def is_same_reading(known: tuple | None, pixels: np.ndarray, exposure_ev: float) -> bool:
    """Whether the pixels and the exposure that something was made of are these."""
    return known is not None and known[0] is pixels and known[1] == exposure_ev
