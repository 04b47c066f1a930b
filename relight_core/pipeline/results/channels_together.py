"""The channels of several faces, mixed where their views meet, as the relit picture is."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from relight_core.face.crop import Crop
from relight_core.face.paste import seen_across
from relight_core.pipeline.results.channels import unrolled
from relight_core.pipeline.results.finish import Placement, weights_on_views

Channels = Mapping[str, np.ndarray]

_COUNTS = 0.05
"""Where views count for less than this, toward their edges and on people they are not of, channels fade to 0."""


def channels_together(
    placement: Placement, first: Channels, of_others: Sequence[Callable[[], Channels]]
) -> list[dict[str, np.ndarray]]:
    """Every face's channels with what other faces' views have to say within its own.

    Args:
        first: (S, S) or (S, S, C) each, of the first face; what the others don't have, as the lights, may be of any
            size.
        of_others: make those of the other faces, of the same size.

    Returns:
        for each face what its own view shows, so that views can be laid side by side; normals in camera space.
    """
    views, classes = placement.views, 0
    faces = [_turned_back(one, view) for one, view in zip([first, *(make() for make in of_others)], views, strict=True)]
    faces = _with_no_shadow(faces)
    names = [name for name in faces[0] if all(name in one for one in faces)]
    if "parsing" in names:
        classes = 1 + max(int(one["parsing"].max()) for one in faces)
    shares = _shares(placement, len(faces[0][names[0]])) if names else []
    together: list[dict[str, np.ndarray]] = [{} for _ in views]
    for name in names:
        of_faces = [one[name] if name != "parsing" else one[name][..., None] == np.arange(classes) for one in faces]
        for index, mixed in enumerate(together):
            seen = _mixed(of_faces, views, index, shares[index])
            mixed[name] = seen.argmax(-1).astype(np.int32) if name == "parsing" else seen
    return together


def _turned_back(channels: Channels, view: Crop) -> dict[str, np.ndarray]:
    return {name: unrolled(one, view.roll_deg) if name == "normal" else one for name, one in channels.items()}


def _with_no_shadow(faces: Sequence[dict[str, np.ndarray]]) -> Sequence[dict[str, np.ndarray]]:
    """Where a shadow from outside falls on some of the faces, the others have one of 0."""
    shadows = [one["foreign_shadow"] for one in faces if "foreign_shadow" in one]
    return [{"foreign_shadow": np.zeros_like(shadows[0])} | one for one in faces] if shadows else faces


def _shares(placement: Placement, size: int) -> list[list[np.ndarray | None]]:
    """For each view, how much of each pixel of its own maps of `size` is whose: (size, size, 1), None for nothing."""
    shares = []
    for weights in weights_on_views(placement, size):
        total = np.maximum(sum(weight for weight in weights.of_views if weight is not None), _COUNTS)
        shares.append([None if weight is None else weight / total for weight in weights.of_views])
    return shares


def _mixed(
    of_faces: Sequence[np.ndarray], views: Sequence[Crop], index: int, shares: Sequence[np.ndarray | None]
) -> np.ndarray:
    """One channel within one view, of all faces that have a share in it."""
    size = len(of_faces[index])
    total = np.zeros((size, size, 1), np.float32)
    for other, (channel, share) in enumerate(zip(of_faces, shares, strict=True)):
        if share is None:
            continue
        maps = np.asarray(channel, np.float32).reshape(*channel.shape[:2], -1)
        if other != index:
            maps = seen_across(views[index], size, maps, views[other]).reshape(size, size, -1)
        total = total + share * maps
    return total[..., 0] if of_faces[index].ndim == 2 else np.broadcast_to(total, of_faces[index].shape)
