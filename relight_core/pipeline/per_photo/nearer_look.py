"""A second look at a face, from as near as the paper's crop, where its view shows much besides the face.

In a view of a person down to the chest a face is as small for the de-lighting network as it ever saw one in training:
the bridge of the nose comes out low, its shadow faint, old shading stays in the albedo. The nearer look says what the
face is like, the view what is around it. SS and composition, too, draw a sharper shadow where the face is larger.
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
"""The view's side, in sides of the nearer view."""

_EDGE_SHARE = 0.12
"""Share of the nearer view's side over which it fades toward its edge."""
_DARKEST_ALBEDO = 0.01
"""Albedos count as no darker where the levels of both looks are compared."""
_LEVELS = (0.6, 1.6)
"""The least and the most by which the view's albedo is brought to the nearer look's level."""
_LITTLE = 1e-3


def nearer_view(portrait: Portrait) -> Crop | None:
    """What a nearer look sees; None where the view is near enough."""
    nearer = replace(portrait.crop, side=_AROUND * portrait.crop.side)
    return nearer if portrait.view.side > _WORTH_IT_FROM * nearer.side else None


@torch.inference_mode()
def with_nearer_look(surface: Surface, seen_nearer: Surface, view: Crop, nearer: Crop) -> Surface:
    """A surface with its face as a nearer look found it.

    How high the relief is and how light the albedo are a guess in either; the albedo takes the nearer one's level
    throughout, the relief keeps the view's.

    Args:
        surface: of the view.
        seen_nearer: of the same size, of the nearer view, whose roll is that of the view.
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
    """What a light makes of a view, with what it makes of the nearer one in its place; maps of the same size."""
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
    """The effect channels (S, S) of a view, with those of the nearer one, of the same size, in their place."""
    size = len(next(iter(effects.values())))
    weight = _weight(_window_of(view, nearer, size), size)
    from_near = seen_across(view, size, np.dstack([seen_nearer[name] for name in effects]), nearer)
    return {name: own + weight * (from_near[..., index] - own) for index, (name, own) in enumerate(effects.items())}


def _window_of(view: Crop, nearer: Crop, size: int) -> tuple[float, float, float, float]:
    """Where the view lies in maps of `size` pixels of the nearer one: x0, y0, x1, y1."""
    x, y = nearer.from_photo(np.array([view.centre_x, view.centre_y]), size)
    half = view.side / nearer.side * size / 2
    return x - half, y - half, x + half, y + half


def _weight(window: tuple[float, float, float, float], size: int) -> np.ndarray:
    """(S, S) how much the nearer look counts at each pixel of the view."""
    places = (np.arange(size) + 0.5) / size
    across, down = ((low + (high - low) * places) / size for low, high in (window[::2], window[1::2]))
    return fade(down, _EDGE_SHARE)[:, None] * fade(across, _EDGE_SHARE)[None]


def _resampled(image: torch.Tensor, window: tuple[float, float, float, float]) -> torch.Tensor:
    """A window of (1, C, S, S), at the same size."""
    return as_tensor(resample_window(as_image(image), window, image.shape[-2:]), image.device)


def _mean(image: torch.Tensor, weight: torch.Tensor) -> torch.Tensor:
    """Of all channels, a scalar; 0 where nothing counts."""
    return (image * weight).sum() / (weight.sum() * image.shape[1]).clamp_min(_LITTLE)
