"""Samples as pictures: every channel that training sees, to be looked at."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np
import torch

from relight_core.dataset.baking.shard import read_shard
from relight_core.dataset.recipe import load_split
from relight_core.dataset.stream import SampleStream
from relight_core.imaging.colour import srgb_encode
from relight_core.pipeline.results.channel_view import channel_to_srgb

Picture = tuple[str, np.ndarray]


def sample_pictures(folder: Path, lights: Path, split: str, count: int, seed: int) -> Iterator[list[Picture]]:
    """Twelve labelled pictures, (S, S, 3) float sRGB in [0, 1], for each of `count` samples.

    Raises:
        InputError: heads or lights are missing or damaged.
    """
    size = read_shard(load_split(folder, split)[0]).size
    stream = SampleStream(
        folder,
        lights,
        split,
        size,
        seed,
        relief_shadow=True,
        lights_per_head=2,
        paints_per_head=1,
        heads_at_once=1,
    )
    for item in islice(iter(stream), count):
        yield pictures_of(item)


def pictures_of(item: dict[str, torch.Tensor]) -> list[Picture]:
    """The pictures of one item of `SampleStream`: what its lights share, then what is the first light's."""
    light, normal, label = item["light"][0].numpy(), _image(item["normal"]), item["label"].numpy()
    relief = np.clip(_image(item["relief"]) * 0.5 + 0.5, 0, 1) * _image(item["covered"])
    photos = [(f"photo {k + 1}", _image(item["photo_srgb"][k])) for k in range(2)]
    lit = {name: _image(item[name][0]) for name in ("image", "specular", "shadow")}
    fractions = {name: _image(item[name][0]) for name in ("shadow_fraction", "gloss_fraction", "relief_shadow")}
    labels_and_relief = np.where(_left_half(label)[..., None], channel_to_srgb("parsing", label), relief[..., None])
    return [
        *photos,
        ("light 1", channel_to_srgb("source_light", light)),
        ("image 1", channel_to_srgb("photo", lit["image"])),
        ("specular", channel_to_srgb("specular", lit["specular"])),
        ("shadow", channel_to_srgb("shadow", lit["shadow"])),
        *((name.replace("_", " "), np.repeat(value[..., None], 3, -1)) for name, value in fractions.items()),
        ("albedo", srgb_encode(_image(item["albedo"]))),
        ("normal", channel_to_srgb("normal", normal)),
        ("labels, relief", labels_and_relief),
    ]


def _left_half(image: np.ndarray) -> np.ndarray:
    return np.broadcast_to(np.arange(image.shape[1]) < image.shape[1] // 2, image.shape[:2])


def _image(tensor: torch.Tensor) -> np.ndarray:
    """(C, S, S) to (S, S, C), or (S, S) for one channel."""
    array = tensor.permute(1, 2, 0).numpy()
    return array[..., 0] if array.shape[-1] == 1 else array
