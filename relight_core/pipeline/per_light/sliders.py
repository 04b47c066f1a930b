"""What the sliders do to a relit view: effects scaled, shadows with softer edges, and shine of another colour."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import torch

from relight_core.face.parsing import INDEX
from relight_core.imaging.tensor_colour import grey
from relight_core.imaging.tensor_images import as_image, as_tensor
from relight_core.lighting.light_edit import colour_gain
from relight_core.pipeline.per_light.hints import Effects, explicit_parts, hidden_share, with_hidden_share
from relight_core.pipeline.stages import Composed, Surface

_WIDEST = 0.09
"""Standard deviation of the blur at softness 1, as a share of the view's side."""

_STEP = 0.09
"""A change of height, in half-widths of the view, that keeps the blur from crossing it about as two deviations do."""

_NOSTRIL = 0.055
"""Of the view's side: nostrils are narrower."""

_SOCKET = 0.12
"""Of the view's side: eyes with their lids are narrower."""

_EAR_HOLLOW = 0.08
"""The same of the hollows of ears."""

_OUTLINE = 0.5
"""What the person's outline counts for, as a change of height."""


@dataclass(frozen=True)
class SliderChange:
    """What the sliders do to a composed image: image * kept + added + lifted; all (1, 3, S, S), >= 0, kept <= 1.

    Attributes:
        kept: what is left of it.
        added: gloss.
        lifted: diffuse light that a weaker or softer shadow lets through, which multiplies what the surface shows.
    """

    kept: torch.Tensor
    added: torch.Tensor
    lifted: torch.Tensor


@torch.inference_mode()
def move_sliders(
    composed: Composed,
    surface: Surface,
    reflected: torch.Tensor,
    effects: Effects,
    specular_gain: float | torch.Tensor,
    shadow_gain: float,
) -> SliderChange:
    """The change of the image with its effects scaled (paper, Figure 12); none at gains of 1.

    The network's correction is learned at gains of 1. The sliders move the explicit sum, and the image
    with it: darker by the sum's ratio, brighter by its difference, so that more shadow never brightens
    and more gloss never darkens a pixel, and the network need not run again.

    Args:
        effects: those that the image was composed of, but for a softer shadow. An image may have been composed without
            its gloss where `specular_gain` is 0.
    """
    matt, gloss = explicit_parts(surface.albedo, reflected, effects, shadow_gain)
    moved = matt + specular_gain * gloss
    kept = ((moved + 1e-3) / (composed.plain + 1e-3)).clamp(0, 1)
    added = (moved - composed.plain).clamp_min(0)
    lifted = torch.minimum(added, (matt - (composed.plain - gloss)).clamp_min(0))
    if not lifted.any():
        return SliderChange(kept, added, lifted)
    open_to_light, _ = explicit_parts(surface.albedo, reflected, effects, 0.0)
    given_back = _without_nostrils(lifted, surface.parsing)
    given_back = given_back * _share_as_around(open_to_light, composed.plain - gloss, surface)
    return SliderChange(kept, added - lifted, given_back)


def _without_nostrils(lifted: torch.Tensor, parsing: torch.Tensor) -> torch.Tensor:
    """Light given back (1, 3, S, S), but in nostrils no more of it than around them.

    Their normals face the lamp as often as not, so that without a shadow they would shine out of a nose.
    """
    window = _window(_NOSTRIL, lifted, cv2.MORPH_RECT)
    nose = as_tensor(cv2.dilate(as_image(parsing[:, INDEX["nose"], None]), window), lifted.device)
    return lifted + nose * (_opened(lifted, window) - lifted)


def _share_as_around(open_to_light: torch.Tensor, before: torch.Tensor, surface: Surface) -> torch.Tensor:
    """Share of what is given back that gives eyes no colour, and ears no more, than their surroundings get.

    Balls face both of two lamps, where of a socket's skin one side alone faces each: without the shadow of the nose a
    blue eye would look out of a red cheek. What is given back of all colours alike stays. The hollow of an ear faces
    lamps that are behind the head's other side, and would glow. The share is that of no shadow at all, so that less
    shadow never darkens a pixel.

    Args:
        open_to_light, before: (1, 3, S, S) what is seen of diffuse light with no shadow, and before it is lifted.

    Returns:
        (1, 3, S, S) in [0, 1].
    """
    lifted, albedo = (open_to_light - before).clamp_min(0), surface.albedo.clamp_min(1e-3)
    light = open_to_light / albedo
    around = (_opened(light, _window(widest, light, cv2.MORPH_ELLIPSE)) for widest in (_SOCKET, _EAR_HOLLOW))
    stray, glow = (torch.minimum(lifted, (open_to_light - most * albedo).clamp_min(0)) for most in around)
    of_all_colours = open_to_light * (stray / open_to_light.clamp_min(1e-6)).amin(1, keepdim=True)
    taken = torch.maximum(surface.eye_sockets * (stray - of_all_colours), _ears(surface.parsing) * glow)
    return (1 - taken / lifted.clamp_min(1e-6)).clamp(0, 1)


def _window(widest: float, like: torch.Tensor, shape: int) -> np.ndarray:
    """Of an opening that takes away what is narrower than a share of a view."""
    side_px = max(round(widest * like.shape[-1]), 1) | 1
    return cv2.getStructuringElement(shape, (side_px, side_px))


def _opened(image: torch.Tensor, window: np.ndarray) -> torch.Tensor:
    """An image (1, 3, S, S) without bright spots that a window does not fit into."""
    return as_tensor(cv2.morphologyEx(as_image(image), cv2.MORPH_OPEN, window), image.device)


def _ears(parsing: torch.Tensor) -> torch.Tensor:
    """(1, 1, S, S) in [0, 1]: bare skin beside the face that lies above its lips; none where no lips are seen."""
    lips = (parsing[0, INDEX["lips"]] > 0.5).any(1).nonzero()
    ears = parsing[:, INDEX["neck"], None].clone()
    ears[..., int(lips[0]) if len(lips) else 0 :, :] = 0
    return ears


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
    soft = _within_surfaces(*map(as_image, (hidden, surface.relief, surface.person)), softness)
    return with_hidden_share(effects, as_tensor(soft, diffuse.device), diffuse, gloss)


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
