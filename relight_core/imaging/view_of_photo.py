"""What a light does to a photo, as a gain and an offset of its pixels, in linear light.

Light multiplies what a surface shows and adds gloss to it. So the relit picture without its gloss, over the
photo, is the gain, and the gloss is the offset. A photo has more pixels than the networks see; gain and
offset are enlarged along its edges (`joint_upsampling`) and then meet its own pixels. docs/detail.md
compares this with other ways.

A network blurs small things that it sees in a few pixels only. Where an eye, a brow or hair lost contrast on
the way, the gain would paint the blur over the photo: pupils turn milky, dark hair hazy. There the gain
follows what the photo's own pattern doesn't explain, and the pattern keeps its contrast.

Of a mouth or an eye it sees even less: every tooth would get a gain of its own, an open corner a gloss, an iris a
veil. The light there is as even as the light around it, also what a weaker shadow gives back.

Of a nostril they see nothing: where skin is far darker than all around it, light that a weaker shadow gives back
brightens it by no more than that.

Gloss that is added as smooth as the networks see it lies over skin like a veil. Pores and hairs break a highlight
as they break all light, so most of the gloss follows the photo's texture: it is part of the gain.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import cv2
import numpy as np

from relight_core.imaging.colour import luminance
from relight_core.imaging.half_floats import within_halves
from relight_core.imaging.light_change import LightChange, share_in_reach
from relight_core.imaging.ramp import ramp

_DARK = 1e-3
_CALM = 0.1
_LOSS = 0.3
_EVEN_PX = (9, 9)
_TEXTURED = 0.8
_PALE = 0.05
_WARM = (0.2, 0.4)
"""What red has before blue, of the sum of the three, where something dark counts as skin, in part and altogether."""
_OF_OWN, _OF_GREY = (0.3, 0.6), -0.02
"""The shares of what a face's own lit skin has that are enough, too, and where counting begins if it has none."""
_LIT_PX = (30, 60)
"""How many pixels of skin in the light may tell, and surely tell, how warm it is."""
_NOT_BLACK = (0.0015, 0.005)
"""The luminance from which on what is worn shows something of itself, little and enough; 5 and 16 of 255 in a file."""
_HOLE_SHARE = 0.07
"""Of the view: nostrils are lower, and so are the corners beside them."""
_HOLE = (0.5, 0.25)
"""What is left of the brightness all around from which on a place counts as a hole, in part and altogether."""


@dataclass(frozen=True, eq=False)
class Materials:
    """Masks of what is seen in a view, by what it does with light; (s, s) each, [0, 1].

    Attributes:
        patterned: where contrast comes from colour rather than from shading: eyes, brows, lips, hair, cloth.
        evenly_lit: where no network resolves the surface: mouth and eyes.
        textured: where the photo's texture breaks gloss as it breaks all light: all but what is wet or polished.
        skin: where skin is bare.
        mouth: the mouth's part of `evenly_lit`.
        worn: hair, brows, hats and clothes.
    """

    patterned: np.ndarray
    evenly_lit: np.ndarray
    textured: np.ndarray
    skin: np.ndarray
    mouth: np.ndarray
    worn: np.ndarray

    @classmethod
    def plain(cls, size: int) -> Materials:
        """Smooth and of one colour."""
        return cls(*np.zeros((6, size, size), np.float32))


class ViewOfPhoto:
    """A view of a photo, to take apart what lights make of it. What follows from the photo alone is found once.

    Everything is of size (s, s, 3): NumPy multiplies by one channel ten times as slowly.
    """

    def __init__(self, photo: np.ndarray, materials: Materials, surely_skin: float):
        """Look at a view.

        Args:
            photo: (s, s, 3) linear, the view as the networks saw it. NaN and infinities are cleaned.
            materials: of (s, s).
            surely_skin: the share of skin above which a pixel may tell what the face's skin looks like.
        """
        patterned, even, textured, skin, mouth, worn = (
            cv2.merge([np.clip(getattr(materials, mask.name), 0.0, 1.0).astype(np.float32)] * 3)
            for mask in fields(Materials)
        )
        self._photo = photo = within_halves(photo)
        self._mean = _mean(photo)
        self._variance = np.maximum(_mean(photo * photo) - self._mean**2, 0.0)
        self._calm = (_CALM * np.maximum(self._mean, _DARK)) ** 2
        self._patterned, self._even, self._uneven = patterned, even, 1 - even
        self._evened = np.maximum(_smooth((photo + _DARK) * even), 1e-9)
        self._plain = (1 - patterned) * (1 - even) * textured
        self._in_shadow = self._plain * skin * _like_skin(self._mean, skin, surely_skin)
        shown = worn * ramp(luminance(self._mean), *_NOT_BLACK)[..., None]
        self._laid_over = (self._in_shadow + mouth + shown) * (photo + _DARK)
        carried = np.maximum(_TEXTURED * textured, even) * np.minimum(photo / _PALE, 1.0)
        self._shine, self._veil = carried / np.maximum(photo, _DARK), (1 - carried) * (1 - even)
        self._lift = 1 / (_as_lifted(photo, self._mean, patterned) + _DARK)
        around = luminance(self._evened / np.maximum(_smooth(even), 1e-6))[..., None]
        self._lift_evenly = np.minimum(around / _PALE, 1.0) / self._evened

    def change_to(self, relit: np.ndarray, gloss: np.ndarray) -> LightChange:
        """Take the view, relit, apart into gain and offset.

        Args:
            relit: (s, s, 3) linear. NaN and infinities are cleaned.
            gloss: (s, s, 3) linear, how much of `relit` is mirrored light.

        Returns:
            Maps of size (s, s).
        """
        relit = within_halves(relit)
        gloss = np.minimum(within_halves(gloss), relit) * self._uneven
        matt = relit - gloss
        gain = np.maximum(self._evenly(matt, self._with_pattern(matt)), 0.0)
        reached = share_in_reach(gain)
        missed, gain = gain * (1 - reached), gain * reached
        # In a deep shadow skin would stay black, or grey of the gloss on top; mouth, hair and collar black beside it.
        kept = 1 - (1 - reached) * (self._plain - self._in_shadow)
        offset = self._veil * gloss * kept + _DARK * np.maximum(gain - 1.0, 0.0) + missed * self._laid_over
        gain = gain + self._shine * gloss
        return LightChange(gain * share_in_reach(gain), offset, self._shine, self._veil, self._gain_of_lifted)

    def _gain_of_lifted(self, lifted: np.ndarray) -> np.ndarray:
        """By how much diffuse light (s, s, 3) raises the gain, as even as the gain is.

        Where all is nearly black, as in an open mouth, by less: networks fill it with skin.
        """
        gain = lifted * self._lift
        return gain + (_smooth(lifted * self._even) * self._lift_evenly - gain) * self._even

    def evened(self, share: np.ndarray) -> np.ndarray:
        """A map (s, s) that multiplies light, as even as the gain (of green) is: over mouth and eyes a mean nearby."""
        shares = cv2.merge((share,) * 3)
        return self._evenly(shares * (self._photo + _DARK) - _DARK, shares)[..., 1]

    def _with_pattern(self, matt: np.ndarray) -> np.ndarray:
        """The gain, but where the photo's pattern lost contrast, the gain of its surroundings."""
        mean = _mean(matt)
        covariance = _mean(self._photo * matt) - self._mean * mean
        ratio = (mean + _DARK) / (self._mean + _DARK)
        slope = (covariance + self._calm * ratio) / (self._variance + self._calm)
        unexplained = matt - mean - slope * (self._photo - self._mean)
        around = np.maximum(mean + unexplained, 0.0) / (self._mean + _DARK)
        lost = np.clip((ratio - slope) / (_LOSS * ratio + 1e-6), 0.0, 1.0)
        gain = (matt + _DARK) / (self._photo + _DARK)
        return gain + (around - gain) * (lost * self._patterned)

    def _evenly(self, matt: np.ndarray, gain: np.ndarray) -> np.ndarray:
        """The gain, but where the light is even, that of all such pixels nearby."""
        return gain + (_smooth((matt + _DARK) * self._even) / self._evened - gain) * self._even


def _as_lifted(photo: np.ndarray, mean: np.ndarray, patterned: np.ndarray) -> np.ndarray:
    """The photo (s, s, 3) as light that a shadow gives back sees it.

    Of a pattern, it brightens the dark places as it does those around them. A nostril is dark in whatever light: albedo
    and normals have filled it with skin, so that light given back to skin would be many times what the photo shows of
    it, noise and a glowing rim.
    """
    seen = photo + patterned * (mean - photo)
    side_px = max(round(_HOLE_SHARE * len(photo)), 1) | 1
    around = cv2.morphologyEx(photo, cv2.MORPH_CLOSE, np.ones((side_px, side_px), np.uint8))
    hole = ramp((luminance(photo) + _DARK) / (luminance(around) + _DARK), *_HOLE)[..., None]
    return seen + hole * (1 - patterned) * (around - seen).clip(0)


def _like_skin(photo: np.ndarray, skin: np.ndarray, surely_skin: float) -> np.ndarray:
    """How surely a dark place (s, s, 3), parsed as skin, is skin in a shadow: (s, s, 1) in [0, 1].

    It is warm there, mostly more than in the light; where a face shows little warmth in the light, less will do. What
    is black and not warm was parsed as skin by mistake, a beard's edge or a collar, and would be a haze.
    """
    warmth = (photo[..., :1] - photo[..., 2:]) / (photo.sum(axis=-1, keepdims=True) + _DARK)
    lit = warmth[(skin[..., :1] > surely_skin) & (luminance(photo)[..., None] > _PALE)]
    own, told = max(float(np.median(lit)), 0.0) if len(lit) else 0.0, ramp(float(len(lit)), *_LIT_PX)
    start, full = (
        limit + told * (min(share * own, limit) - limit) for limit, share in zip(_WARM, _OF_OWN, strict=True)
    )
    return ramp(warmth, start + told * _OF_GREY, full)


def _smooth(image: np.ndarray) -> np.ndarray:
    return cv2.GaussianBlur(image, _EVEN_PX, 0)


def _mean(image: np.ndarray) -> np.ndarray:
    return cv2.blur(image, (3, 3), borderType=cv2.BORDER_REFLECT)
