"""What a light does to a photo, as a gain and an offset of its pixels, in linear light.

Light multiplies what a surface shows and adds gloss to it. So the relit picture without its gloss, over the
photo, is the gain, and the gloss is the offset. A photo has more pixels than the networks see; gain and
offset are enlarged along its edges (`joint_upsampling`) and then meet its own pixels. docs/detail.md
compares this with other ways.

A network blurs small things that it sees in a few pixels only. Where an eye, a brow or hair lost contrast on
the way, the gain would paint the blur over the photo: pupils turn milky, dark hair hazy. There the gain
follows what the photo's own pattern doesn't explain, and the pattern keeps its contrast.

Of a mouth or an eye it sees even less: every tooth would get a gain of its own, an open corner a gloss, an iris a
veil. The light there is as even as the light around it.

Of a nostril they see nothing: where skin is far darker than all around it, light that a weaker shadow gives back
brightens it by no more than that.

Gloss that is added as smooth as the networks see it lies over skin like a veil. Pores and hairs break a highlight
as they break all light, so most of the gloss follows the photo's texture: it is part of the gain.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from relight_core.imaging.colour import luminance
from relight_core.imaging.ramp import ramp

LARGEST_GAIN = 16.0
_DARK = 1e-3
_CALM = 0.1
_LOSS = 0.3
_EVEN_PX = 9
_TEXTURED = 0.8
_PALE = 0.05
_BRIGHTEST = 65504.0
_WARM = (0.2, 0.4)
"""What red has before blue, of the sum of the three, where something dark counts as skin, in part and altogether."""
_HOLE_SHARE = 0.07
"""Of the view: nostrils are lower, and so are the corners beside them."""
_HOLE = (0.5, 0.25)
"""What is left of the brightness all around from which on a place counts as a hole, in part and altogether."""


@dataclass(frozen=True, eq=False)
class LightChange:
    """relit = gain * photo + offset.

    Attributes:
        gain: (S, S, 3) float32, >= 0.
        offset: (S, S, 3) float32, >= 0.
        shine: (S, S, 3) float32, >= 0: by how much a unit of gloss raises the gain.
        veil: (S, S, 3) float32, [0, 1]: by how much it raises the offset.
        lift: (S, S, 3) float32, >= 0: by how much a unit of diffuse light raises the gain; None where it, too, is a
            matter of the offset.
    """

    gain: np.ndarray
    offset: np.ndarray
    shine: np.ndarray
    veil: np.ndarray
    lift: np.ndarray | None = None

    def apply(self, photo: np.ndarray) -> np.ndarray:
        """A picture of the maps' size relit: (S, S, 3), linear."""
        return self.gain * photo + self.offset

    def moved(self, kept: np.ndarray, gloss: np.ndarray, lifted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Gain and offset with a share of the relit picture kept, and gloss and diffuse light added to it.

        Args:
            kept, gloss, lifted: (S, S, 3), >= 0, the first <= 1.
        """
        if self.lift is None:
            return self.gain * kept, self.offset * kept + gloss + lifted
        gain, offset = self.gain * kept + gloss * self.shine, self.offset * kept + gloss * self.veil
        return _with_added(gain, lifted * self.lift), offset


@dataclass(frozen=True, eq=False)
class Makeup:
    """What a view is made up of; (s, s) each, [0, 1].

    Attributes:
        patterned: where contrast comes from colour rather than from shading: eyes, brows, lips, hair, cloth.
        evenly_lit: where no network resolves the surface: mouth and eyes.
        textured: where the photo's texture breaks gloss as it breaks all light: all but what is wet or polished.
    """

    patterned: np.ndarray
    evenly_lit: np.ndarray
    textured: np.ndarray

    @classmethod
    def plain(cls, size: int) -> Makeup:
        """Smooth and of one colour."""
        return cls(*np.zeros((3, size, size), np.float32))


def fit_light_change(photo: np.ndarray, relit: np.ndarray, gloss: np.ndarray, makeup: Makeup) -> LightChange:
    """Take a relit view apart into gain and offset.

    Args:
        photo: (s, s, 3) linear, the view as the networks saw it.
        relit: (s, s, 3) linear, the same relit. NaN and infinities in either are cleaned.
        gloss: (s, s, 3) linear, how much of `relit` is mirrored light.

    Returns:
        Maps of size (s, s).
    """
    photo, relit = _cleaned(photo), _cleaned(relit)
    patterned, even, textured = (
        np.clip(share, 0.0, 1.0)[..., None].astype(np.float32)
        for share in (makeup.patterned, makeup.evenly_lit, makeup.textured)
    )
    gloss = np.minimum(_cleaned(gloss), relit) * (1 - even)
    matt = relit - gloss
    gain = _pattern_kept(photo, matt, (matt + _DARK) / (photo + _DARK), patterned)
    gain = np.maximum(_evened(photo, matt, gain, even), 0.0)
    carried = np.maximum(_TEXTURED * textured, even) * np.minimum(photo / _PALE, 1.0)
    shine, veil = carried / np.maximum(photo, _DARK), (1 - carried) * (1 - even)
    reached = within_reach(gain)
    laid_over, unreached = _out_of_reach(photo, gain, reached, (1 - patterned) * (1 - even) * textured)
    offset = veil * gloss * (1 - unreached) + _DARK * np.maximum(reached - 1.0, 0.0) + laid_over
    # Of a pattern, light that a shadow gives back brightens the dark places as it does those around them.
    seen = photo + patterned * (_mean(photo) - photo)
    around, hole = _holes(photo)
    seen = seen + hole * (1 - patterned) * (around - seen).clip(0)
    lift = even * shine + (1 - even) / (seen + _DARK)
    return LightChange(within_reach(reached + shine * gloss), offset, shine, veil, lift)


def _pattern_kept(photo: np.ndarray, matt: np.ndarray, gain: np.ndarray, patterned: np.ndarray) -> np.ndarray:
    """The gain, but where the photo's pattern lost contrast, the gain of its surroundings."""
    mean_photo, mean_matt = _mean(photo), _mean(matt)
    variance = np.maximum(_mean(photo * photo) - mean_photo**2, 0.0)
    covariance = _mean(photo * matt) - mean_photo * mean_matt
    ratio = (mean_matt + _DARK) / (mean_photo + _DARK)
    calm = (_CALM * np.maximum(mean_photo, _DARK)) ** 2
    slope = (covariance + calm * ratio) / (variance + calm)
    unexplained = matt - mean_matt - slope * (photo - mean_photo)
    around = np.maximum(mean_matt + unexplained, 0.0) / (mean_photo + _DARK)
    lost = np.clip((ratio - slope) / (_LOSS * ratio + 1e-6), 0.0, 1.0)
    return gain + (around - gain) * (lost * patterned)


def _evened(photo: np.ndarray, matt: np.ndarray, gain: np.ndarray, share: np.ndarray) -> np.ndarray:
    """The gain, but where the light is even, that of all such pixels nearby."""
    size = (_EVEN_PX, _EVEN_PX)
    before, after = (cv2.GaussianBlur((image + _DARK) * share, size, 0) for image in (photo, matt))
    return gain + (after / np.maximum(before, 1e-9) - gain) * share


def _holes(photo: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What is around small dark places, (s, s, 3), and how surely each is a hole, (s, s, 1) in [0, 1].

    A nostril is dark in whatever light. Albedo and normals have filled it with skin, so that light given back to
    skin would be many times what the photo shows of it: noise, and a glowing rim.
    """
    side_px = max(round(_HOLE_SHARE * len(photo)), 1) | 1
    around = cv2.morphologyEx(photo, cv2.MORPH_CLOSE, np.ones((side_px, side_px), np.uint8))
    left = (luminance(photo) + _DARK) / (luminance(around) + _DARK)
    return around, ramp(left, *_HOLE)[..., None]


def _out_of_reach(
    photo: np.ndarray, gain: np.ndarray, reached: np.ndarray, skin: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """What the gain that may be leaves of skin's light, to be laid over it, and the share that it leaves of the rest.

    Skin in a deep shadow would stay black, or gray of the gloss that comes on top. It is warm there, more than in the
    light; what is black and not warm was parsed as skin by mistake, a beard's edge or a collar, and gloss would lie on
    it as a haze.

    Returns:
        (s, s, 3) linear, >= 0, and (s, s, 1) in [0, 1].
    """
    warmth = (photo[..., :1] - photo[..., 2:]) / (photo.sum(axis=-1, keepdims=True) + _DARK)
    in_shadow = skin * ramp(warmth, *_WARM)
    left = 1 - reached.max(axis=-1, keepdims=True) / np.maximum(gain.max(axis=-1, keepdims=True), 1e-6)
    return (gain - reached) * (photo + _DARK) * in_shadow, left * (skin - in_shadow)


def _with_added(gain: np.ndarray, more: np.ndarray) -> np.ndarray:
    """The sum, but of what is added no more than LARGEST_GAIN leaves room for."""
    room = np.maximum(LARGEST_GAIN - gain.max(axis=-1, keepdims=True), 0.0)
    return gain + more * np.minimum(1.0, room / np.maximum(more.max(axis=-1, keepdims=True), 1e-6))


def within_reach(gain: np.ndarray) -> np.ndarray:
    """A gain (..., 3) >= 0, at most LARGEST_GAIN, its colour kept: dark hair in a warm light would turn green."""
    largest = gain.max(axis=-1, keepdims=True)
    return gain * (LARGEST_GAIN / np.maximum(largest, LARGEST_GAIN))


def _mean(image: np.ndarray) -> np.ndarray:
    return cv2.blur(image, (3, 3), borderType=cv2.BORDER_REFLECT)


def _cleaned(image: np.ndarray) -> np.ndarray:
    cleaned = np.nan_to_num(np.asarray(image, np.float32), nan=0.0, posinf=_BRIGHTEST, neginf=0.0)
    return np.clip(cleaned, 0.0, _BRIGHTEST)
