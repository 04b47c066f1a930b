"""Pixels that show both person and background: how much of each, and the person's own colour."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from relight_core.imaging.colour import luminance

_LEAST_OWN = 0.5
"""Each channel of the person's own colour has at least this share of the person's mean colour."""
_TINY = np.finfo(np.float32).tiny
_VARIATION = 0.2
"""How much pixels of one side differ from its mean colour, as a share of the brighter side's: a mix of sides that are
no further apart says little about alpha."""
_MOST_REFINED = 1.2
"""By how much colours may change the matte at most, times alpha (1 - alpha)."""


@dataclass(frozen=True, eq=False)
class MixedPixels:
    """Pixels of a photo where the matte is soft, n of them, as mixes of both sides' mean colours.

    A pixel darker than both means can't be a mix of them, such as hair between skin and a wall where the matte is one
    half. So both means are dimmed until the darker one is as dark as the pixel. Otherwise clipping at 0 would leave
    the person only the strongest channel.

    Attributes:
        place: (n,) indices into the photo's pixels, row by row.
        seen: (3, n) linear, their colours.
        person, behind: (3, n) linear, the dimmed mean colours of person and background.
    """

    place: np.ndarray
    seen: np.ndarray
    person: np.ndarray
    behind: np.ndarray

    @classmethod
    def of(cls, linear: np.ndarray, share: np.ndarray, person: np.ndarray, behind: np.ndarray) -> MixedPixels:
        """Those of a photo (h, w, 3), linear, where a matte (h, w) is soft; both sides' mean colours are (h, w, 3)."""
        place = np.flatnonzero((share > 0.0) & (share < 1.0))
        seen, *means = (np.ascontiguousarray(side.reshape(-1, 3)[place].T) for side in (linear, person, behind))
        bright = np.maximum(luminance(seen.T), _TINY)
        darker = np.minimum(*(luminance(mean.T) for mean in means))
        return cls(place, seen, *(mean * (bright / np.maximum(darker, bright)) for mean in means))

    def refined(self, share: np.ndarray, crisp: np.ndarray) -> np.ndarray:
        """The matte moved toward the mix of both sides that is nearest to each pixel.

        A matte of filters ends as softly as their windows are wide, which is more softly than things in focus do.
        Beside a white shirt a pixel of the lawn that was taken for a ninth of shirt lost most of its light when a lamp
        left that side dark: the shirt had a black outline.

        The further a pixel is from any mix, the less it is believed: white hair before a dark wall may lie amid skin.

        Args:
            share: (h, w) the matte, [0, 1].
            crisp: (h, w) in [0, 1], how surely the outline is narrow. In a wide one single pixels show grain and
                texture.

        Returns:
            (h, w) in [0, 1]; the same where the matte is 0 or 1.
        """
        alpha, refined = share.ravel()[self.place], share.copy(order="C")
        difference = self.person - self.behind
        remainder = self.seen - alpha * self.person - (1.0 - alpha) * self.behind
        along, apart, off = (remainder * difference).sum(0), (difference**2).sum(0), (remainder**2).sum(0)
        explained = (along / np.maximum(np.sqrt(apart) * np.sqrt(off), _TINY)) ** 2
        variation = 3 * (_VARIATION * np.maximum(self.person, self.behind).mean(0)) ** 2
        change = explained * along / np.maximum(apart + variation, _TINY)
        most = _MOST_REFINED * alpha * (1.0 - alpha) * crisp.ravel()[self.place]
        refined.reshape(-1)[self.place] = np.clip(alpha + np.clip(change, -most, most), 0.0, 1.0)
        return refined

    def own_colour(self, linear: np.ndarray, share: np.ndarray) -> np.ndarray:
        """The person's own colour where the matte is soft (the foreground of the compositing equation).

        Both sides' mean colours are changed as little as possible, by least squares, until their mix is the pixel.
        Where a strand in front of a bright sky covers more of a pixel than the matte says, that would remove all of the
        colour, or all but one channel. So no channel falls below half of the person's mean, as far as the pixel
        contains that much.

        Args:
            linear: (h, w, 3), the photo.
            share: (h, w) the matte, [0, 1], soft at these pixels at most.

        Returns:
            (h, w, 3) linear, >= 0, not premultiplied; times the matte it is no brighter than the pixel. Where the matte
            is 0 or 1, it is the pixel itself.
        """
        alpha, colour = share.ravel()[self.place], linear.copy(order="C")
        soft = (alpha > 0) & (alpha < 1)
        remainder = self.seen - alpha * self.person - (1.0 - alpha) * self.behind
        most = np.maximum(self.seen, 0.0) / np.where(soft, alpha, 1)
        change = alpha / (alpha**2 + (1.0 - alpha) ** 2) * remainder
        own = np.clip(self.person + change, np.minimum(_LEAST_OWN * self.person, most), most)
        colour.reshape(-1, 3)[self.place] = np.where(soft, own, self.seen).T
        return colour
