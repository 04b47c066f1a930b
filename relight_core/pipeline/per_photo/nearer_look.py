"""A nearer look at a face, about as near as the paper's crop, if its view shows much besides the face.

In a view of a person down to the chest, a face is as small as the smallest ones that de-lighting was trained on. The
bridge of the nose comes out low, its shadow faint, and shading stays in the albedo. So the face is taken from the
nearer look, and what is around it from the view. SS and composition also draw sharper shadows where the face is larger.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import cv2
import numpy as np
import torch

from relight_core.face.crop import Crop
from relight_core.face.paste import fade, seen_across
from relight_core.imaging.masks import bounds
from relight_core.imaging.resampling import resample_window
from relight_core.imaging.tensor_images import as_image, as_tensor
from relight_core.imaging.tensor_normals import unit_normals
from relight_core.pipeline.per_photo.portrait import Portrait
from relight_core.pipeline.results.channels import ViewChange
from relight_core.pipeline.stages import Surface, reparsed

_AROUND = 1.1
"""Side of the nearer view, in sides of the paper's crop."""

_WORTH_IT_FROM = 1.25
"""The nearer look is taken if the view is more than so many times as wide."""

_EDGE_SHARE = 0.12
"""Share of the nearer view's side over which it fades toward its edge."""
_DARKEST_ALBEDO = 0.01
"""Smallest albedo when the levels of both looks are compared."""
_LEVELS = (0.6, 1.6)
"""Limits of the factor that brings the view's albedo to the nearer look's level."""
_LITTLE = 1e-3
"""Smallest divisor."""


def nearer_view(portrait: Portrait) -> Crop | None:
    """The view of a nearer look; None if the portrait's view is near enough."""
    nearer = replace(portrait.crop, side=_AROUND * portrait.crop.side)
    return nearer if portrait.view.side > _WORTH_IT_FROM * nearer.side else None


@torch.inference_mode()
def with_nearer_look(surface: Surface, seen_nearer: Surface, view: Crop, nearer: Crop) -> Surface:
    """A surface with its face replaced by that of a nearer look.

    The mean height of the relief and the level of the albedo are guesses in both looks. The albedo takes the nearer
    look's level everywhere, the relief keeps the view's.

    Args:
        surface: of the view.
        seen_nearer: of the nearer view, with the same size and roll.
        view, nearer: the two views.
    """
    size = surface.normal.shape[-1]
    window = _window_of(view, nearer, size)
    weight = as_tensor(_weight(window, size), surface.normal.device)
    albedo, normal, relief, parsing = (
        _resampled(image, window)
        for image in (seen_nearer.albedo, seen_nearer.normal, seen_nearer.relief, seen_nearer.parsing)
    )
    counts = weight * surface.person
    relief = relief * (nearer.side / view.side)
    relief = relief + _mean(surface.relief - relief, counts)
    level = _mean((albedo.clamp_min(_DARKEST_ALBEDO) / surface.albedo.clamp_min(_DARKEST_ALBEDO)).log(), counts)
    around = (surface.albedo * level.exp().clamp(*_LEVELS)).clamp(0, 1)
    both = replace(
        surface,
        albedo=torch.lerp(around, albedo, weight),
        normal=unit_normals(torch.lerp(surface.normal, normal, weight)),
        relief=torch.lerp(surface.relief, relief, weight),
        source_light=(surface.source_light + seen_nearer.source_light) / 2,
    )
    return reparsed(both, torch.lerp(surface.parsing, parsing, weight))


def with_nearer_change(change: ViewChange, seen_nearer: ViewChange, view: Crop, nearer: Crop) -> ViewChange:
    """The change of a view by a light, with the nearer view's change in its place; maps of the same size."""
    size = change.gain.shape[0]
    weight = _weight(_window_of(view, nearer, size), size)
    rows, columns = bounds(weight)
    if rows.start == rows.stop:
        return change
    share = cv2.merge((weight[rows, columns],) * 3)
    gain, offset = change.gain.copy(), change.offset.copy()
    for own, from_near in ((gain, seen_nearer.gain), (offset, seen_nearer.offset)):
        part = own[rows, columns]
        added = seen_across(view, size, from_near, nearer)[rows, columns] - part
        added *= share
        part += added
    return replace(change, gain=gain, offset=offset)


def with_nearer_effects(
    effects: Mapping[str, np.ndarray], seen_nearer: Mapping[str, np.ndarray], view: Crop, nearer: Crop
) -> dict[str, np.ndarray]:
    """The effect channels (S, S) of a view, with those of the nearer view, of the same size, in their place."""
    size = len(next(iter(effects.values())))
    weight = _weight(_window_of(view, nearer, size), size)
    from_near = seen_across(view, size, np.dstack([seen_nearer[name] for name in effects]), nearer)
    return {name: own + weight * (from_near[..., index] - own) for index, (name, own) in enumerate(effects.items())}


def _window_of(view: Crop, nearer: Crop, size: int) -> tuple[float, float, float, float]:
    """Where the view lies in the nearer view's maps of `size` pixels: x0, y0, x1, y1."""
    x, y = nearer.from_photo(np.array([view.centre_x, view.centre_y]), size)
    half = view.side / nearer.side * size / 2
    return x - half, y - half, x + half, y + half


def _weight(window: tuple[float, float, float, float], size: int) -> np.ndarray:
    """The weight of the nearer look at each pixel of the view, (S, S) in [0, 1]."""
    places = (np.arange(size) + 0.5) / size
    across, down = ((low + (high - low) * places) / size for low, high in (window[::2], window[1::2]))
    return fade(down, _EDGE_SHARE)[:, None] * fade(across, _EDGE_SHARE)[None]


def _resampled(image: torch.Tensor, window: tuple[float, float, float, float]) -> torch.Tensor:
    """A window of an image (1, C, S, S), resampled to the same size."""
    return as_tensor(resample_window(as_image(image), window, image.shape[-2:]), image.device)


def _mean(image: torch.Tensor, weight: torch.Tensor) -> torch.Tensor:
    """The weighted mean over pixels and channels, a scalar; 0 if nothing has weight."""
    return (image * weight).sum() / (weight.sum() * image.shape[1]).clamp_min(_LITTLE)
