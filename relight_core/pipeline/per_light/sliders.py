"""What the sliders do beside scaling an effect: shadows with softer edges, and shine of another colour."""

from __future__ import annotations

import cv2
import numpy as np
import torch

from relight_core.imaging.tensor_colour import grey
from relight_core.lighting.light_edit import colour_gain
from relight_core.pipeline.per_light.hints import Effects, hidden_share, with_hidden_share
from relight_core.pipeline.stages import Surface

_WIDEST = 0.09
"""Standard deviation of the blur at softness 1, as a share of the view's side."""

_STEP = 0.09
"""A change of height, in half-widths of the view, that keeps the blur from crossing it about as two deviations do."""

_OUTLINE = 0.5
"""What the person's outline counts for, as a change of height."""


def soften_shadow(effects: Effects, surface: Surface, reflected: torch.Tensor, softness: float) -> Effects:
    """The effects with softer shadow edges, as a larger lamp casts them.

    What is blurred is the share of the diffuse light that is hidden, not the shadow itself, so that skin keeps
    its pattern; and it is blurred within a surface, not across the step from a chin to the neck behind it
    (domain transform of Gastal and Oliveira 2011, guided by relief and outline).

    Args:
        effects, reflected: as of `hints.explicit_sum`.
        softness: [0, 1]; 0 returns the effects themselves.
    """
    if softness <= 0:
        return effects
    diffuse = grey(surface.albedo * reflected[:, :3])
    gloss = grey(reflected[:, 3:])
    hidden = hidden_share(effects, diffuse, gloss)
    soft = _within_surfaces(_plane(hidden), _plane(surface.relief), _plane(surface.person), softness)
    return with_hidden_share(effects, torch.from_numpy(soft)[None, None].to(diffuse), diffuse, gloss)


def specular_gain(gain: float, tint: float, device: torch.device | str = "cpu") -> float | torch.Tensor:
    """The gain on the specular channel; with a tint one for each colour, (1, 3, 1, 1), of luminance `gain`.

    Args:
        tint: [-1, 1], from cool to warm; 0 leaves the light's own colour.
        device: where the channel lies.
    """
    if tint == 0:
        return gain
    return gain * torch.from_numpy(colour_gain(tint, 0.0).astype(np.float32)).reshape(1, 3, 1, 1).to(device)


def _within_surfaces(hidden: np.ndarray, relief: np.ndarray, person: np.ndarray, softness: float) -> np.ndarray:
    hidden, deviation_px = np.nan_to_num(hidden), softness * _WIDEST * hidden.shape[0]
    guide = np.ascontiguousarray(np.dstack([relief, _OUTLINE * person]), np.float32)
    # Of the filter's kinds the recursive one alone has no windows of whole pixels, which make the slider jump.
    blurred = cv2.ximgproc.dtFilter(
        guide, hidden, sigmaSpatial=max(deviation_px, 1.0), sigmaColor=_STEP, mode=cv2.ximgproc.DTF_RF
    )
    blurred = np.clip(np.nan_to_num(blurred.reshape(hidden.shape)), 0, 1)
    # It takes less than a pixel for one.
    return hidden + np.float32(min(deviation_px, 1.0)) * (blurred - hidden)


def _plane(tensor: torch.Tensor) -> np.ndarray:
    return np.ascontiguousarray(tensor[0, 0].float().cpu().numpy())
