"""Pixels that show both person and background: how much of each, and the person's own colour."""

from __future__ import annotations

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


def refined_share(
    linear: np.ndarray, share: np.ndarray, person: np.ndarray, behind: np.ndarray, crisp: np.ndarray
) -> np.ndarray:
    """The matte where it is soft, moved toward the mix of both sides' mean colours that is nearest to the pixel.

    A matte of filters ends as softly as their windows are wide, which is more softly than things in focus do. Beside a
    white shirt a pixel of the lawn that was taken for a ninth of shirt lost most of its light when a lamp left that
    side dark: the shirt had a black outline.

    The further a pixel is from any such mix, the less it is believed: white hair before a dark wall may lie amid skin.

    Args:
        linear: (h, w, 3), pixels of the photo.
        share: (h, w) the matte there, [0, 1].
        person, behind: (h, w, 3) linear, mean colours of the foreground and the background.
        crisp: (h, w) in [0, 1], how surely the outline is narrow. In a wide one single pixels show grain and texture.

    Returns:
        (h, w) in [0, 1]; the same where the matte is 0 or 1.
    """
    soft = _soft(share)
    if not soft.size:
        return share
    alpha = share.ravel()[soft]
    along, apart, off, brighter = (np.zeros_like(alpha) for _ in range(4))
    for seen, of_person, of_behind in _channels(soft, linear, person, behind):
        difference, remainder = of_person - of_behind, seen - alpha * of_person - (1.0 - alpha) * of_behind
        along += remainder * difference
        apart += difference * difference
        off += remainder * remainder
        brighter += np.maximum(of_person, of_behind) / 3
    explained = (along / np.maximum(np.sqrt(apart) * np.sqrt(off), _TINY)) ** 2
    change = explained * along / np.maximum(apart + 3 * (_VARIATION * brighter) ** 2, _TINY)
    most = _MOST_REFINED * alpha * (1.0 - alpha) * crisp.ravel()[soft]
    refined = share.copy(order="C")
    refined.ravel()[soft] = np.clip(alpha + np.clip(change, -most, most), 0.0, 1.0)
    return refined


def own_colour(linear: np.ndarray, share: np.ndarray, person: np.ndarray, behind: np.ndarray) -> np.ndarray:
    """The person's own colour where the matte is soft (the foreground of the compositing equation).

    A pixel is modelled as a mix, by the matte, of the mean colours of both sides, plus a remainder. The remainder times
    the matte is added to the person's mean colour. Two cases need more than that:

    - A pixel darker than both means can't be a mix of them, such as hair between skin and a wall where the matte is one
      half. So both means are first dimmed until the darker one is as dark as the pixel. Otherwise clipping at 0 would
      leave the person only the strongest channel.
    - Where a strand in front of a bright sky covers more of a pixel than the matte says, the remainder would remove all
      of the colour, or all but one channel. So no channel falls below half of the person's mean, as far as the pixel
      contains that much.

    Args:
        linear: (h, w, 3), pixels of the photo.
        share: (h, w) the matte there, [0, 1].
        person, behind: (h, w, 3) linear, mean colours of the foreground and the background.

    Returns:
        (h, w, 3) linear, >= 0, not premultiplied; times the matte it is no brighter than the pixel. Where the matte is
        0 or 1, it is the pixel itself.
    """
    soft = _soft(share)
    if not soft.size:
        return linear
    alpha, colour = share.ravel()[soft], linear.copy(order="C")
    for channel, (at, of_person, of_behind) in enumerate(_channels(soft, linear, person, behind)):
        remainder = at - alpha * of_person - (1.0 - alpha) * of_behind
        most = np.maximum(at, 0.0) / alpha
        own = np.clip(of_person + alpha * remainder, np.minimum(_LEAST_OWN * of_person, most), most)
        colour.reshape(-1, 3)[soft, channel] = own
    return colour


def _soft(share: np.ndarray) -> np.ndarray:
    """Indices of the pixels that show both, (n,)."""
    return np.flatnonzero((share > 0.0) & (share < 1.0))


def _channels(
    soft: np.ndarray, linear: np.ndarray, person: np.ndarray, behind: np.ndarray
) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Of each channel of the soft pixels: the pixels, and both sides' means, no brighter than a mix allows; (n,) each.

    Channel by channel, since NumPy is slow with arrays whose last dimension is 3.
    """
    mixed, *means = (side.reshape(-1, 3)[soft] for side in (linear, person, behind))
    seen = np.maximum(luminance(mixed), _TINY)
    dimmed = seen / np.maximum(np.minimum(*(luminance(mean) for mean in means)), seen)
    return [(mixed[:, i], dimmed * means[0][:, i], dimmed * means[1][:, i]) for i in range(3)]
