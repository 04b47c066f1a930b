"""The colours of skin, and those that only other lights can have given it.

Skin has one colour, but for flush and tan. Where a large part of it is purple, there was a purple lamp that the one
estimated light doesn't have. What the estimated light hardly reaches has the colour of others altogether: of a wall, a
screen, the sky. And where a photo is nearly black its colours are noise.

Paint is no light: it lies in the light, among plain skin, and ends where its edge is, not little by little.
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import torch

from relight_core.face.parsing import FEWEST_OF_SKIN, SURELY
from relight_core.imaging.ramp import ramp
from relight_core.imaging.tensor_colour import as_bright_as, grey
from relight_core.imaging.tensor_logs import exact_logs
from relight_core.imaging.tensor_means import local_means, middle_values
from relight_core.pipeline.stages import Surface

_COMMON = 0.15
"""The most by which flush and tan move the log of a ratio of two channels."""
_BLUE, _BLUE_OF_PALE = 0.05, 1.4
"""How much bluer than most of it skin may be by itself, in logs of blue to green: the first, plus the second times what
it is less red. Less blood and melanin make skin bluer only as they make it less red, and more so, since melanin absorbs
less toward red. Skin that is bluer still is lit so."""
NO_COLOUR = (0.025, 0.008)
"""Luminances of a photo, linear, below which its colours say less, and nothing: 8-bit codes 42 and 22. There a few
codes of JPEG's chroma are a colour of their own."""
_DEEP_SHADOW = (0.7, 0.2)
"""Shares of most of the skin's luminance below which skin may lie, and surely lies, in deep shadow, where other lights
are brighter than the estimated one."""
_PAINT, _PLAIN = 0.5, 0.25
"""Log ratios to green: paint is further off most of the skin than the first, plain skin less than the second."""
_RIM_SHARE, _BESIDE_SHARE = 1 / 128, 2 / 128
"""Widths in sides of the view: of a patch of paint's mixed edge, and of the ring around that which is looked at."""
_FEWEST_OF_PAINT = 12
"""Pixels of the smallest patch."""
_MOSTLY, _NOT_AT_A_SILHOUETTE = 0.6, 0.75
"""Shares of the ring around a patch that must be plain, of what is skin in it, and that must be skin."""


def in_one_colour(surface: Surface, skin: torch.Tensor) -> Surface:
    """The surface without the colours that other lights gave to its skin.

    Colour is measured as log ratios of channels, smoothed over some hundredths of the view, so that moles, beards
    and make-up keep theirs; in deep shadow, where each of them is of that light, pixel by pixel. What lies further
    from the skin's median than flush and tan explain is taken back to that distance, no pixel of it past the median,
    and what the photo is too dark to tell to the median; luminance stays, and so does paint.

    Args:
        skin: (1, 1, S, S) probability of bare skin.
    """
    known = skin > SURELY
    if int(known.sum()) < FEWEST_OF_SKIN:
        return surface
    log_albedo = exact_logs(surface.albedo)
    ratios = log_albedo - log_albedo[:, 1:2]
    middle = middle_values(local_means(ratios, skin), known[0, 0])
    off = ratios - middle
    skin = skin * ~painted(off, surface.photo, skin)
    # Beside a red collar that the parsing takes for a neck, skin has its own colour and would turn green.
    around = torch.minimum(_unnatural(local_means(ratios, skin) - middle), off.clamp_min(0)).maximum(off.clamp_max(0))
    excess = torch.lerp(around, _unnatural(off), deep_shadow(surface.photo, skin))
    excess = torch.lerp(excess, off, ramp(grey(surface.photo), *NO_COLOUR))
    evened = as_bright_as(surface.albedo * torch.exp(-excess * skin), surface.albedo)
    return replace(surface, albedo=evened.clamp(0, 1))


def deep_shadow(photo: torch.Tensor, skin: torch.Tensor) -> torch.Tensor:
    """(1, 1, S, S) how surely a pixel of skin is darker than most of it by more than its own colour, [0, 1].

    Args:
        photo: (1, 3, S, S) linear.
        skin: (1, 1, S, S) probability of bare skin.
    """
    known, seen = skin > SURELY, grey(photo)
    if int(known.sum()) < FEWEST_OF_SKIN:
        return torch.zeros_like(skin)
    return skin * ramp(seen / seen[known].median().clamp_min(1e-6), *_DEEP_SHADOW)


def painted(off: torch.Tensor, photo: torch.Tensor, skin: torch.Tensor) -> torch.Tensor:
    """(1, 1, S, S) bool, where skin is painted.

    Args:
        off: (1, 3, S, S) log ratios to green beside the skin's median.
        photo: (1, 3, S, S) linear.
        skin: (1, 1, S, S) probability of bare skin.
    """
    distance, bare = off.abs().amax(1)[0].cpu().numpy(), skin[0, 0].cpu().numpy() > SURELY
    lit = deep_shadow(photo, skin)[0, 0].cpu().numpy() < 0.5
    count, patches = cv2.connectedComponents((bare & lit & (distance > _PAINT)).astype(np.uint8))
    paint = np.zeros(bare.shape, bool)
    for number in range(1, count):
        patch = patches == number
        if patch.sum() < _FEWEST_OF_PAINT:
            continue
        within = _grown(patch, _RIM_SHARE)
        around = _grown(within, _BESIDE_SHARE) & ~within
        beside = around & bare
        if beside.sum() > _NOT_AT_A_SILHOUETTE * around.sum() and (distance[beside] < _PLAIN).mean() > _MOSTLY:
            paint |= within
    return torch.from_numpy(paint)[None, None].to(skin.device)


def _grown(patch: np.ndarray, share: float) -> np.ndarray:
    reach_px = max(round(share * len(patch)), 1)
    return cv2.dilate(patch.astype(np.uint8), np.ones((2 * reach_px + 1,) * 2, np.uint8)).astype(bool)


def _unnatural(off: torch.Tensor) -> torch.Tensor:
    """The part of log ratios to green (1, 3, S, S) beside the skin's median that skin doesn't have by itself."""
    natural = off.clamp(-_COMMON, _COMMON)
    paler = (-natural[:, :1]).clamp_min(0)
    bluest = (_BLUE + _BLUE_OF_PALE * paler).clamp_max(_COMMON)
    return off - torch.cat([natural[:, :2], torch.minimum(natural[:, 2:], bluest)], 1)
