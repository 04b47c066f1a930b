"""A photo in the working space: linear light, Rec.709 primaries."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from relight_core.imaging.black_level import LOOKED_AT, Black, light_over
from relight_core.imaging.colour import luminance, srgb_decode, srgb_decode_integers, srgb_encode
from relight_core.imaging.half_floats import LARGEST_HALF, are_finite
from relight_core.imaging.photo_frame import PLAINLY, inside_frame
from relight_core.imaging.resampling import resize_area, shrunk_size
from relight_core.imaging.tone import Tone, tone_of
from relight_core.imaging.toning import is_monochrome

_LOOKED_AT = 512

_WHITE_PERCENT = 98.0

_GREY = np.float32(0.18)
"""Of black, 0.18, 0.4, noise and the person's colours continued, what relit cut-outs most like the whole photos."""

_SOFT_PX = 1

_DIM, _BRIGHT_PERCENT = 0.15, 95.0
"""A picture that has no brighter parts is dark, or in units of its own."""


@dataclass(frozen=True, eq=False)
class Photo:
    """A decoded photo. Two photos are equal only if they are the same object.

    Attributes:
        linear: (H, W, 3) float32 C-contiguous, linear Rec.709, >= 0 and finite; not premultiplied. Colours that
            Rec.709 doesn't hold are clipped to it.
        alpha: (H, W) float32 in [0, 1], or None where the file has none.
        path: where it came from, or None.
        bits: bits per channel of its source: 8, 16 or 32 (floating point).
        icc: the profile its file was in, if that is an RGB matrix profile other than sRGB; for writing it back.
        exif: its file's EXIF, upright and without thumbnail, or None.
        beyond: (H, W, 3) float16, finite, what clipping took from `linear`: their sum is the file's own colour.
            None where it took nothing.
        black: what lies over all of the photo and was taken from it (see `above_black`), or None.

    Raises:
        ValueError: an array of another shape or type, or with other values.
    """

    linear: np.ndarray
    alpha: np.ndarray | None = None
    path: Path | None = None
    bits: int = 8
    icc: bytes | None = None
    exif: bytes | None = None
    beyond: np.ndarray | None = None
    black: Black | None = None

    def __post_init__(self) -> None:
        linear, alpha = self.linear, self.alpha
        if linear.ndim != 3 or linear.shape[2] != 3 or 0 in linear.shape:
            raise ValueError(f"a photo is (H, W, 3), not {linear.shape}")
        if linear.dtype != np.float32 or not linear.flags.c_contiguous:
            raise ValueError("a photo is float32 and C-contiguous")
        if not (linear.min() >= 0 and linear.max() < np.inf):
            raise ValueError("a photo's values are finite and not negative")
        if alpha is not None and (alpha.shape != linear.shape[:2] or alpha.dtype != np.float32):
            raise ValueError(f"alpha is float32 of shape {linear.shape[:2]}, not {alpha.dtype} {alpha.shape}")
        if alpha is not None and not (alpha.min() >= 0 and alpha.max() <= 1):
            raise ValueError("alpha is from 0 to 1")
        if self.beyond is not None and (self.beyond.shape != linear.shape or self.beyond.dtype != np.float16):
            raise ValueError(f"what lies beyond is float16 of shape {linear.shape}")
        if self.beyond is not None and not are_finite(self.beyond):
            raise ValueError("what lies beyond is finite")
        if self.bits not in (8, 16, 32):
            raise ValueError(f"bits is 8, 16 or 32, not {self.bits}")

    @cached_property
    def is_cut_out(self) -> bool:
        """Whether it has an alpha that is not opaque throughout, which then says what is person."""
        return self.alpha is not None and float(self.alpha.min()) < 1.0

    @cached_property
    def monochrome(self) -> bool:
        """Whether it is black and white, or toned: of one colour for each brightness, but for what compression adds.

        What is transparent has no say.
        """
        seen = self.linear[self._few]
        if self.beyond is not None:
            seen = seen + self.beyond[self._few]
        counted = None if self.alpha is None else self.alpha[self._few] > 0
        if self.bits == 32 and (white := _white(seen if counted is None else seen[counted])) > 0:
            # In whatever units: next to black all colours are one, and so they are clipped to white.
            seen = seen / np.maximum(np.abs(seen).max(-1, keepdims=True), np.float32(white))
        codes = np.copysign(srgb_encode(np.minimum(np.abs(seen), 1)), seen)
        return is_monochrome(codes, counted)

    @property
    def above_black(self) -> Photo:
        """The photo without the light that lies over all of it, which `black` tells; itself where there is none."""
        return self._above_black if self._black.level.any() else self

    @cached_property
    def _black(self) -> Black:
        if self.is_cut_out:
            image, counted = self.linear[self._few], self.alpha[self._few] > 0.5
        else:
            x0, y0, x1, y1 = self.picture
            image = resize_area(self.linear[y0:y1, x0:x1], shrunk_size((y1 - y0, x1 - x0), LOOKED_AT))
            counted = np.ones(image.shape[:2], bool)
        white = _white(image[counted]) if self.bits == 32 else 1.0
        # What is no brighter than 1 may be a dim picture, and is told from that.
        return Black(light_over(image, counted, white) if white > 0 else np.zeros(3, np.float32), max(white, 1.0))

    @cached_property
    def _above_black(self) -> Photo:
        black, beyond = self._black, self.beyond
        if beyond is not None:
            beyond = np.clip(beyond / black.left, -LARGEST_HALF, LARGEST_HALF).astype(np.float16)
        linear = np.maximum(without_black(self.linear, black), 0)
        return replace(self, linear=linear, beyond=beyond, black=black)

    def tone_at(self, exposure: float) -> Tone | None:
        """The tone of the photo times an exposure; None where it is black and white, or has colours."""
        return None if self._tone is None else self._tone.exposed(exposure)

    @cached_property
    def _tone(self) -> Tone | None:
        if not self.monochrome:
            return None
        # A page may be cream around a print without a tone.
        (x0, y0, x1, y1), step = self.picture, self._few[0].step
        few = slice(y0, y1, step), slice(x0, x1, step)
        seen = self.linear[few]
        return tone_of(seen.reshape(-1, 3) if self.alpha is None else seen[self.alpha[few] > 0])

    @property
    def _few(self) -> tuple[slice, slice]:
        """Every so many rows and columns, where all would take long and tell no more."""
        step = max(max(self.linear.shape[:2]) // _LOOKED_AT, 1)
        return slice(None, None, step), slice(None, None, step)

    @property
    def seen(self) -> Photo:
        """The photo for whoever looks for something in it: opaque, a cut-out before an even grey.

        What a file stores under alpha 0 is anything, and nobody's to see.
        """
        return self._on_grey if self.is_cut_out else self

    @cached_property
    def picture(self) -> tuple[int, int, int, int]:
        """x0, y0, x1, y1 in pixels of what it shows, without the frame or the bars around it; all of most photos.

        Networks that see a frame take somebody's white cap for a part of it, or its corner for a coat. To them the
        picture goes on beyond it, as beyond the photo's border.
        """
        height, width = self.linear.shape[:2]
        step = max(-(-max(height, width) // _LOOKED_AT), 1)
        few = self.linear[::step, ::step]
        if self.is_cut_out or not (white := _white(few)) > 0:
            return 0, 0, width, height
        inside = inside_frame(srgb_encode(np.minimum(few / np.float32(white), 1)), PLAINLY)
        if inside is None:
            return 0, 0, width, height
        (y0, y1), (x0, x1) = (
            _well_within(span, count, length, step)
            for span, count, length in zip(inside, few.shape[:2], (height, width), strict=True)
        )
        return x0, y0, x1, y1

    @cached_property
    def _on_grey(self) -> Photo:
        share = self.alpha[..., None]
        linear = self.linear * share
        linear += (1 - share) * (_GREY * np.float32(self._unit))
        return Photo(linear, None, self.path, self.bits)

    @property
    def _unit(self) -> float:
        """What is white beside a cut-out: 1 unless it is dark all over, or so bright that it has units of its own."""
        brightness = luminance(self.linear[self._few][self.alpha[self._few] > 0.5])
        if not brightness.size:
            return 1.0
        bright = float(np.percentile(brightness, _BRIGHT_PERCENT))
        return max(bright, 1.0) if bright > _DIM else bright / _DIM

    @classmethod
    def from_srgb(cls, srgb: np.ndarray) -> Photo:
        """A photo from sRGB pixels in memory.

        Args:
            srgb: (H, W, 3) uint8, uint16, or float in [0, 1], in any byte order.

        Raises:
            ValueError: an array of another shape or type.
        """
        srgb = np.asarray(srgb)
        kind = srgb.dtype.newbyteorder("=")
        if kind in (np.uint8, np.uint16):
            linear = srgb_decode_integers(srgb.astype(kind, copy=False))
            return cls(np.ascontiguousarray(linear), None, None, 8 * kind.itemsize)
        if kind.kind != "f":
            # Which of an integer's values is white is anyone's guess.
            raise ValueError(f"sRGB pixels are uint8, uint16 or floats in [0, 1], not {kind}")
        clipped = np.clip(np.nan_to_num(srgb.astype(np.float32)), 0.0, 1.0)
        return cls(np.ascontiguousarray(srgb_decode(clipped)), None, None, 32)


def without_black(linear: np.ndarray, black: Black | None) -> np.ndarray:
    """Radiance (..., 3) without what lies over all of it, or None for nothing; what is darker is below 0 then."""
    return linear if black is None else (linear - black.level) / black.left


def with_black(linear: np.ndarray, black: Black | None) -> np.ndarray:
    """The reverse of `without_black`."""
    return linear if black is None else black.level + black.left * linear


def _well_within(span: slice, count: int, length: int, step: int) -> tuple[int, int]:
    """The first and the last pixel's end of a side of `length` within `span` of `count` pixels, one in `step`.

    Where something was cut off: a frame's edge is soft, and nothing of it may go on.
    """
    start = min(span.start + _SOFT_PX, span.stop - 1) * step if span.start > 0 else 0
    return start, max((span.stop - 1 - _SOFT_PX) * step, start + 1) if span.stop < count else length


def _white(pixels: np.ndarray) -> float:
    """What of (..., 3) radiance hardly a pixel is brighter than, lamps and glints aside; 0 where there is nothing."""
    return float(np.percentile(np.abs(pixels).max(-1), _WHITE_PERCENT)) if pixels.size else 0.0
