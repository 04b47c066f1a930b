"""Colours in the albedo of skin that must come from other lights, and their removal.

A person's skin has one colour, apart from flush and tan. If a large part of it is purple, there was a purple lamp that
the estimated light doesn't contain. What the estimated light hardly reaches has the colour of other lights: of a wall,
a screen, the sky. And where a photo is nearly black, its colours are noise.

Paint is kept. It differs from light in that it is surrounded by plain skin, lies in the light, and has sharp edges.
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
"""Flush and tan change the log ratio of two channels by at most this."""
_BLUE, _BLUE_OF_PALE = 0.05, 1.4
"""How much bluer than the rest skin may be by itself, in log ratios of blue to green: the first, plus the second times
how much less red it is. Less blood and melanin make skin bluer only together with less red, and blue changes more,
since melanin absorbs less toward red. Skin that is still bluer is lit by blue light."""
NO_COLOUR = (0.025, 0.008)
"""Ramp of a photo's linear luminance, 8-bit codes 42 to 22, over which its colours become meaningless: there, a few
codes of JPEG's chroma look like a colour."""
_DEEP_SHADOW = (0.7, 0.2)
"""Ramp of luminance, as a share of the skin's median, over which skin comes to lie in deep shadow, where other lights
are brighter than the estimated one."""
_PAINT, _PLAIN = 0.5, 0.25
"""Distances from the skin's median in log ratios to green: paint exceeds the first, plain skin stays below the
second."""
_RIM_SHARE, _BESIDE_SHARE = 1 / 128, 2 / 128
"""Widths as shares of the view's side: of the mixed edge of a patch of paint, and of the ring around it that is
examined."""
_FEWEST_OF_PAINT = 12
"""Pixels of the smallest patch."""
_MOSTLY, _NOT_AT_A_SILHOUETTE = 0.6, 0.75
"""In the ring around a patch, the share of skin that must be plain, and the share of the ring that must be skin."""


def in_one_colour(surface: Surface, skin: torch.Tensor) -> Surface:
    """The surface without the colours that other lights gave to its skin's albedo.

    - Colour is measured as log ratios of channels, relative to the skin's median. It is averaged over some hundredths
      of the view, so that moles, beards and make-up keep theirs; in deep shadow, where all of them are in that other
      light, it is measured pixel by pixel.
    - What deviates by more than flush and tan explain is reduced to that deviation, and no pixel passes the median.
    - Where the photo is too dark to have a colour, skin gets that of the median.
    - Luminance and paint are kept.

    Args:
        surface: of the photo.
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
    # Limited to each pixel's own deviation. Otherwise skin beside a red collar that is parsed as neck would turn green.
    around = torch.minimum(_unnatural(local_means(ratios, skin) - middle), off.clamp_min(0)).maximum(off.clamp_max(0))
    excess = torch.lerp(around, _unnatural(off), deep_shadow(surface.photo, skin))
    excess = torch.lerp(excess, off, ramp(grey(surface.photo), *NO_COLOUR))
    evened = as_bright_as(surface.albedo * torch.exp(-excess * skin), surface.albedo)
    return replace(surface, albedo=evened.clamp(0, 1))


def deep_shadow(photo: torch.Tensor, skin: torch.Tensor) -> torch.Tensor:
    """Certainty that a pixel of skin lies in deep shadow, (1, 1, S, S) in [0, 1].

    Args:
        photo: (1, 3, S, S) linear.
        skin: (1, 1, S, S) probability of bare skin.
    """
    known, seen = skin > SURELY, grey(photo)
    if int(known.sum()) < FEWEST_OF_SKIN:
        return torch.zeros_like(skin)
    return skin * ramp(seen / seen[known].median().clamp_min(1e-6), *_DEEP_SHADOW)


def painted(off: torch.Tensor, photo: torch.Tensor, skin: torch.Tensor) -> torch.Tensor:
    """Where skin is painted, (1, 1, S, S) bool.

    Args:
        off: (1, 3, S, S) log ratios to green, minus the skin's median.
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
    """A patch (S, S), bool, dilated by a share of the view's side."""
    reach_px = max(round(share * len(patch)), 1)
    return cv2.dilate(patch.astype(np.uint8), np.ones((2 * reach_px + 1,) * 2, np.uint8)).astype(bool)


def _unnatural(off: torch.Tensor) -> torch.Tensor:
    """The part of log ratios to green (1, 3, S, S), relative to the skin's median, that skin can't have by itself."""
    natural = off.clamp(-_COMMON, _COMMON)
    paler = (-natural[:, :1]).clamp_min(0)
    bluest = (_BLUE + _BLUE_OF_PALE * paler).clamp_max(_COMMON)
    return off - torch.cat([natural[:, :2], torch.minimum(natural[:, 2:], bluest)], 1)
