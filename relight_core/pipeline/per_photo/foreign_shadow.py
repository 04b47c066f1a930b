"""Shadows on a person from outside: found by a network, and removed before the person is de-lit.

De-lighting knows the shadows that a head casts on itself. It leaves half of a hand's or of leaves' shadow in the
albedo.
"""

from __future__ import annotations

import cv2
import numpy as np
import torch

from relight_core.face.parsing import FEWEST_PIXELS, KINDS, likely, share_of
from relight_core.imaging.masks import disc
from relight_core.imaging.ramp import ramp
from relight_core.imaging.tensor_colour import srgb_encode
from relight_core.imaging.tensor_images import resized
from relight_core.imaging.tensor_logs import BLACK, exact_logs
from relight_core.networks.bundle import NetworkBundle
from relight_core.pipeline.stages import in_precision

_SIZE = 256
"""Side of the view that the network sees."""

_EDGE_PX = 5
"""The soft edge of a shadow may reach so far beyond what is surely shadow."""
_DEEPEST = 3.0
"""Depth of the deepest shadow in logs, a twentieth of the light; a camera shows little of what is darker."""
_HARDLY, _SURELY = 0.1, 0.25
"""Ramp of depth, in logs averaged over the channels, over which something becomes a shadow."""
_LEAST_OF_FACE = 0.01
"""A shadow counts only if it covers at least this share of the face's skin and features."""
_LEAST_SKIN, _MUCH_SKIN = 0.05, 0.25
"""Shares of a patch of shadow that are skin. With less than the first it is dark cloth, hair or a hat. With less than
the second it may be, and only its part on skin counts."""
_RIM_PX = 5
"""Such a part on skin is only the edge of the dark material beside it, if it is no wider than twice this."""
_MUCH_OF_FACE, _SMALL = 0.1, 0.25
"""If more than the first share of a face lies in shadows from outside, patches beside the skin count as such too, as
long as they cover less than the second share of the rest of the person."""
_SOFT, _MOST_OF_EDGE = 0.08, 0.9
"""If this share of a shadow's edge has a slope below so many mean logs per pixel, the shadow is as soft as those that
de-lighting knows, or is the shading of a cheek."""
_OFF_COLOUR = 0.7
"""If skin differs by this log ratio to green after its shadow has been removed, the shadow is paint."""


@torch.inference_mode()
def find_foreign_shadow(
    bundle: NetworkBundle, view: torch.Tensor, parsing: torch.Tensor, precision: str
) -> torch.Tensor | None:
    """Find shadows from outside in a view (1, 3, D, D), linear.

    Args:
        bundle: with or without a foreign-shadow network.
        view: of the photo.
        parsing: (1, classes, S, S) probabilities of the view.
        precision: of the network.

    Returns:
        (1, 3, 256, 256) logs in [-3, 0] of the share of the light that they leave, 0 outside the person. None if no
        such shadow is on a face, or without the network.
    """
    if bundle.foreign_shadow is None:
        return None
    network = in_precision(bundle, view.device.type, precision).foreign_shadow
    small = resized(view, _SIZE)
    photo = srgb_encode(small.clamp(0, 1))
    kinds = resized(torch.cat([share_of(parsing, names) for names in KINDS], 1), _SIZE)
    one, other = network(*(torch.cat([image, image.flip(-1)]) for image in (photo, kinds))).split(1)
    logs = ((one + other.flip(-1)) / 2).clamp(-_DEEPEST, 0)
    depth = -logs.mean(1, keepdim=True)
    person, face = kinds.sum(1), kinds[:, :2].sum(1)
    colour = exact_logs(without_shadow(small, logs))
    seen = (depth[:, 0], person, face, colour[:, ::2] - colour[:, 1:2])
    kept = _from_outside(*(image[0].cpu().numpy() for image in seen))
    if kept is None:
        return None
    near = torch.from_numpy(kept)[None, None].to(view.device)
    return logs * ramp(depth, _HARDLY, _SURELY) * near * likely(person[:, None])


def _from_outside(depth: np.ndarray, person: np.ndarray, face: np.ndarray, ratios: np.ndarray) -> np.ndarray | None:
    """Select those of the network's shadows that really are shadows from outside.

    The network sometimes takes dark cloth, hair and hats for shadows. Such a patch ends with the material, so little of
    it is skin. It also takes paint for a shadow (see `_not_paint`).

    Args:
        depth: (S, S) depth in logs, averaged over the channels, >= 0.
        person, face: (S, S) probabilities; the face is bare skin and features.
        ratios: (2, S, S) log ratios of red and blue to green, with the shadows removed.

    Returns:
        (S, S) float32, 1 in those shadows and 0 elsewhere, with soft edges; None if none of them is on a face.
    """
    on_person, skin = person > 0.5, face > 0.5
    shadow = (depth > _SURELY) & on_person
    count, patches, stats, _ = cv2.connectedComponentsWithStats(shadow.astype(np.uint8))
    area = stats[:, cv2.CC_STAT_AREA]
    share_of_skin = np.bincount(patches[skin], minlength=count) / np.maximum(area, 1)
    is_patch = np.arange(count) > 0
    has_skin = is_patch & (share_of_skin > _LEAST_SKIN)
    is_cast = _not_paint(has_skin, patches, skin, skin & ~shadow, ratios)
    is_whole = is_cast & (share_of_skin > _MUCH_SKIN)
    kept = is_whole[patches] | _without_rims((is_cast & ~is_whole)[patches] & skin)
    of_face = (kept & skin).sum() / max(skin.sum(), 1)
    if of_face < _LEAST_OF_FACE or _is_soft(depth, kept, on_person):
        return None
    if of_face > _MUCH_OF_FACE:
        kept |= (is_patch & ~has_skin & (area < _SMALL * (on_person & ~skin).sum()))[patches]
    # Widened, since their soft edges lie beyond what is surely shadow.
    return cv2.blur(cv2.dilate(kept.astype(np.float32), disc(_EDGE_PX)), (_EDGE_PX, _EDGE_PX))


def _not_paint(
    in_question: np.ndarray, patches: np.ndarray, skin: np.ndarray, lit: np.ndarray, ratios: np.ndarray
) -> np.ndarray:
    """Which of the patches in question are not paint: their skin has the colour of lit skin once the shadow is removed.

    Args:
        in_question: (patches,) bool, the patches in question.
        patches: (S, S) the number of the patch that each pixel is in.
        skin, lit: (S, S) bool, all of the face, and the part of it outside all shadows.
        ratios: as of `_from_outside`.

    Returns:
        (patches,) bool; all in question if too little skin is lit to tell.
    """
    result = in_question.copy()
    if lit.sum() < FEWEST_PIXELS:
        return result
    own = np.median(ratios[:, lit], 1)
    for number in np.flatnonzero(in_question):
        off = np.median(ratios[:, (patches == number) & skin], 1) - own
        result[number] = np.abs(off).max() < _OFF_COLOUR
    return result


def _without_rims(shadow: np.ndarray) -> np.ndarray:
    """Shadows (S, S), bool, without thin rims, such as those of a beard that the parsing takes for skin."""
    return cv2.morphologyEx(shadow.astype(np.uint8), cv2.MORPH_OPEN, disc(_RIM_PX)) > 0


def _is_soft(depth: np.ndarray, shadow: np.ndarray, person: np.ndarray) -> bool:
    """Whether shadows (S, S), bool, end softly where they end on the person."""
    inside, near = shadow.astype(np.uint8), disc(_EDGE_PX // 2)
    edge = (cv2.dilate(inside, near) > cv2.erode(inside, near)) & (cv2.erode(person.astype(np.uint8), near) > 0)
    slope = np.hypot(*np.gradient(depth))
    return bool(edge.any() and np.quantile(slope[edge], _MOST_OF_EDGE) < _SOFT)


def without_shadow(view: torch.Tensor, logs: torch.Tensor) -> torch.Tensor:
    """A view (1, 3, D, D), linear, with shadows removed; their logs (1, 3, s, s) may have any size."""
    return ((view + BLACK) * resized(-logs, view.shape[-1]).exp() - BLACK).clamp_min(0)
