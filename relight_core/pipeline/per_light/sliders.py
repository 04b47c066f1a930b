"""What the sliders do to a relit view: scale effects, soften shadows, and tint highlights."""

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
"""A step of height, in half-widths of the view, that stops the blur about as much as two standard deviations do."""

_NOSTRIL = 0.055
"""Nostrils are narrower than this share of the view's side."""

_SOCKET = 0.12
"""Eyes with their lids are narrower than this share."""

_EAR_HOLLOW = 0.08
"""The hollows of ears are narrower than this share."""

_OUTLINE = 0.5
"""The step of height that the person's outline stands for."""


@dataclass(frozen=True)
class SliderChange:
    """The sliders' change of a composed image: image * kept + added + lifted; all (1, 3, S, S), >= 0, kept <= 1.

    Attributes:
        kept: the factor by which it is darkened.
        added: gloss.
        lifted: diffuse light that a weaker or softer shadow lets through. It is kept apart from gloss, since it shows
            the surface's pattern.
    """

    kept: torch.Tensor
    added: torch.Tensor
    lifted: torch.Tensor

    @property
    def is_none(self) -> bool:
        """Whether the image stays as it is, as at gains of 1."""
        return not (self.added.any() or self.lifted.any() or (self.kept < 1).any())


@torch.inference_mode()
def move_sliders(
    composed: Composed,
    surface: Surface,
    reflected: torch.Tensor,
    effects: Effects,
    specular_gain: float | torch.Tensor,
    shadow_gain: float,
) -> SliderChange:
    """The change of the image when its effects are scaled (paper, Figure 12); none at gains of 1.

    The network's correction is trained at gains of 1 and isn't computed again. The sliders change the explicit sum, and
    the image with it: it is darkened by the sum's ratio and brightened by its difference. So more shadow never
    brightens a pixel, and more gloss never darkens one.

    Args:
        composed: the image.
        surface: of the view.
        reflected: as of `hints.explicit_sum`.
        effects: those the image was composed from, possibly with a softer shadow. If `specular_gain` is 0, the image
            may have been composed without gloss.
        specular_gain, shadow_gain: the sliders' values.
    """
    matt, gloss = explicit_parts(surface.albedo, reflected, effects, shadow_gain)
    moved = matt + specular_gain * gloss
    kept = ((moved + 1e-3) / (composed.plain + 1e-3)).clamp(0, 1)
    added = (moved - composed.plain).clamp_min(0)
    lifted = torch.minimum(added, (matt - (composed.plain - gloss)).clamp_min(0))
    if not lifted.any():
        return SliderChange(kept, added, lifted)
    open_to_light, _ = explicit_parts(surface.albedo, reflected, effects, 0.0)
    limited = _without_nostrils(lifted, surface.parsing)
    limited = limited * _share_as_around(open_to_light, composed.plain - gloss, surface)
    return SliderChange(kept, added - lifted, limited)


def _without_nostrils(lifted: torch.Tensor, parsing: torch.Tensor) -> torch.Tensor:
    """Lifted light (1, 3, S, S), of which nostrils get no more than their surroundings.

    Their normals often face the lamp, so without a shadow they would shine.
    """
    window = _window(_NOSTRIL, lifted, cv2.MORPH_RECT)
    nose = as_tensor(cv2.dilate(as_image(parsing[:, INDEX["nose"], None]), window), lifted.device)
    return lifted + nose * (_opened(lifted, window) - lifted)


def _share_as_around(open_to_light: torch.Tensor, before: torch.Tensor, surface: Surface) -> torch.Tensor:
    """The share of lifted light with which eyes get no other colour, and ears no more light, than their surroundings.

    Eyes: their normals are those of balls, which face two lamps at once, while each side of a socket faces only one.
    Without the shadow of the nose, a red cheek would have a blue eye. So the part of the lifted light that exceeds the
    surroundings is reduced to what all colours have of it.
    Ears: their hollows face lamps behind the other side of the head, and would glow.

    The share is computed for no shadow at all, whatever the slider's value, so that less shadow never darkens a pixel.

    Args:
        open_to_light, before: (1, 3, S, S) diffuse light without any shadow, and before it is lifted.
        surface: of the view.

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
    """The structuring element of an opening that removes what is narrower than a share of the view's side."""
    side_px = max(round(widest * like.shape[-1]), 1) | 1
    return cv2.getStructuringElement(shape, (side_px, side_px))


def _opened(image: torch.Tensor, window: np.ndarray) -> torch.Tensor:
    """The morphological opening of an image (1, 3, S, S): without bright spots that are smaller than the window."""
    return as_tensor(cv2.morphologyEx(as_image(image), cv2.MORPH_OPEN, window), image.device)


def _ears(parsing: torch.Tensor) -> torch.Tensor:
    """The ears, (1, 1, S, S) in [0, 1]: bare skin outside the face, above the lips; none if no lips are seen."""
    lips = (parsing[0, INDEX["lips"]] > 0.5).any(1).nonzero()
    ears = parsing[:, INDEX["neck"], None].clone()
    ears[..., int(lips[0]) if len(lips) else 0 :, :] = 0
    return ears


def soften_shadow(effects: Effects, surface: Surface, reflected: torch.Tensor, softness: float) -> Effects:
    """The effects with softer shadow edges, as if from a larger lamp.

    The hidden share of the diffuse light is blurred, not the shadow itself, so that skin keeps its pattern. The blur
    stays within a surface and doesn't cross, for example, the step from a chin to the neck behind it (domain transform
    of Gastal and Oliveira 2011, guided by relief and outline).

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
    """The gain on the specular channel; with a tint, one per colour, (1, 3, 1, 1), with a luminance of `gain`.

    Args:
        gain: the slider's value.
        tint: [-1, 1], from cool to warm; 0 keeps the light's own colour.
        device: of the channel.
    """
    if tint == 0:
        return gain
    return gain * torch.from_numpy(colour_gain(tint, 0.0).astype(np.float32)).reshape(1, 3, 1, 1).to(device)


def _within_surfaces(hidden: np.ndarray, relief: np.ndarray, person: np.ndarray, softness: float) -> np.ndarray:
    """A hidden share (S, S) blurred by a softness, without crossing steps of the relief or the person's outline."""
    hidden, deviation_px = np.nan_to_num(hidden), softness * _WIDEST * hidden.shape[0]
    guide = np.ascontiguousarray(np.dstack([relief, _OUTLINE * person]), np.float32)
    # The recursive variant, since the others have windows of whole pixels, with which the slider would jump.
    blurred = cv2.ximgproc.dtFilter(
        guide, hidden, sigmaSpatial=max(deviation_px, 1.0), sigmaColor=_STEP, mode=cv2.ximgproc.DTF_RF
    )
    blurred = np.clip(np.nan_to_num(blurred.reshape(hidden.shape)), 0, 1)
    # The filter's smallest deviation is one pixel; below that its result is mixed in.
    return hidden + np.float32(min(deviation_px, 1.0)) * (blurred - hidden)
