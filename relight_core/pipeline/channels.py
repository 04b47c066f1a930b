"""The channels as a viewer gets them: arrays at the view's size, whatever size the networks worked at."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
import torch
import torch.nn.functional as F

from relight_core.imaging.guided_detail import DetailFit, apply_detail, carry_detail
from relight_core.imaging.resampling import resize_smooth
from relight_core.pipeline.hints import Effects
from relight_core.pipeline.stages import Surface


@dataclass(frozen=True, eq=False)
class ViewChange:
    """What a light makes of a photo's view, to be applied at any resolution.

    Attributes:
        fit: the relit view as gain and offset of the photo, sliders at 1, normalised light.
        kept, added: (s, s, 3) what the sliders leave of it, in [0, 1], and add to it; None at gains of 1.
        level: of the light.
    """

    fit: DetailFit
    kept: np.ndarray | None
    added: np.ndarray | None
    level: float

    def apply(self, photo: np.ndarray) -> np.ndarray:
        """The view (S, S, 3), linear, relit."""
        relit = apply_detail(self.fit, photo)
        if self.kept is not None:
            relit = relit * resize_smooth(self.kept, photo.shape[:2]) + resize_smooth(self.added, photo.shape[:2])
        return relit * np.float32(self.level)


SURFACE_CHANNELS = ("photo", "albedo", "normal", "parsing")
LIGHT_CHANNELS = ("specular", "shadow", "composition")


def surface_channel(name: str, surface: Surface, photo_view: np.ndarray, photo_small: np.ndarray) -> np.ndarray:
    """One of SURFACE_CHANNELS, which no light changes.

    Args:
        photo_view: (S, S, 3) linear, the view at the size of the channels.
        photo_small: (s, s, 3) linear, the view as the networks saw it.
    """
    size = photo_view.shape[0]
    if name == "photo":
        return photo_view
    if name == "albedo":
        return np.clip(carry_detail(np.clip(photo_view, 0, 1), photo_small, as_image(surface.albedo)), 0, 1)
    if name == "normal":
        return as_image(F.normalize(enlarge(surface.normal, size), dim=1, eps=1e-4))
    return enlarge(surface.parsing, size)[0].argmax(0).cpu().numpy().astype(np.int32)


def surface_channels(surface: Surface, photo_view: np.ndarray, photo_small: np.ndarray) -> dict[str, np.ndarray]:
    """All of SURFACE_CHANNELS; arguments as in `surface_channel`."""
    return {name: surface_channel(name, surface, photo_view, photo_small) for name in SURFACE_CHANNELS}


def light_channels(
    effects: Effects, change: ViewChange, photo_view: np.ndarray, names: Collection[str] = LIGHT_CHANNELS
) -> dict[str, np.ndarray]:
    """What a light makes, as far as it is named: "specular", "shadow" and "composition", at the light's level."""
    size, level = photo_view.shape[0], np.float32(change.level)
    channels = {
        name: as_image(enlarge(getattr(effects, name), size)) * level
        for name in ("specular", "shadow")
        if name in names
    }
    if "composition" in names:
        channels["composition"] = change.apply(photo_view)
    return channels


def enlarge(tensor: torch.Tensor, size: int) -> torch.Tensor:
    """(1, C, s, s) to (1, C, size, size), bilinear."""
    return F.interpolate(tensor.float(), size=(size, size), mode="bilinear", align_corners=False)


def as_image(tensor: torch.Tensor) -> np.ndarray:
    """(1, C, S, S) to (S, S, C), or (S, S) for one channel; float32."""
    array = np.ascontiguousarray(tensor[0].permute(1, 2, 0).float().cpu().numpy())
    return array[..., 0] if array.shape[-1] == 1 else array
