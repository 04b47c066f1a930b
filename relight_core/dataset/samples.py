"""Training samples: a baked head, painted, lit twice, photographed. An endless stream."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
import torch
from torch.utils.data import IterableDataset, get_worker_info

from relight_core.dataset.appearance import Appearance, appear
from relight_core.dataset.bake import BakedHead, add_relief
from relight_core.dataset.camera import photograph
from relight_core.dataset.illumination import Illumination, blocked_by_itself, bounced, illuminate
from relight_core.dataset.lights import LightLibrary, load_lights, sample_light
from relight_core.dataset.occluders import sample_occluder
from relight_core.dataset.recipe import load_split
from relight_core.dataset.shard import read_shard
from relight_core.dataset.skin import paint
from relight_core.dataset.texture import TexturePool
from relight_core.errors import InputError
from relight_core.face.parsing import MIRRORED
from relight_core.lighting.reflection import Gloss
from relight_core.lighting.relief import march_relief

RELIEF_SIZE = 64
"""Side at which reliefs are marched; shadows wider than a few pixels survive it, SS sharpens the rest."""

_OCCLUDED_SHARE, _SCATTERING_SHARE = 0.25, 0.6

_GREY = np.array([0.2126, 0.7152, 0.0722], np.float32)
_MIRRORED_LABELS = np.array(MIRRORED, np.uint8)


@dataclass(frozen=True)
class LitHead:
    """A head under K lights, before paint and camera; what several samples share.

    Attributes:
        blocked: (P,) part of each pixel's hemisphere that the head itself fills.
        appearance: what its photos show, where photos are taken.
        relief_shadow: (K, S, S) the hint to SS, where it is asked for.
    """

    head: BakedHead
    normal: np.ndarray
    lights: np.ndarray
    illumination: Illumination
    blocked: np.ndarray
    appearance: Appearance | None = None
    relief_shadow: np.ndarray | None = None


def subsample(head: BakedHead, step: int, rng: np.random.Generator) -> BakedHead:
    """Every `step`-th pixel in both directions, from a random first one: a smaller image of the same head."""
    if step == 1:
        return head
    y, x = rng.integers(0, step, 2)
    index = np.full(head.covered.shape, -1, np.int64)
    index[head.covered] = np.arange(len(head.normal))
    kept = index[y::step, x::step]
    chosen = kept[kept >= 0]
    return BakedHead(
        covered=kept >= 0,
        normal=head.normal[chosen],
        depth=head.depth[chosen],
        uv=head.uv[chosen],
        material=head.material[chosen],
        label=head.label[chosen],
        visibility=np.packbits(head.visible()[:, chosen], axis=1),
    )


def light_head(head: BakedHead, normal: np.ndarray, lights: np.ndarray) -> LitHead:
    """Light a head with the reference gloss."""
    reference = _denoised(head, illuminate(head, normal, lights))
    return LitHead(head, normal, lights, reference, blocked_by_itself(head, normal))


def _denoised(head: BakedHead, lit: Illumination) -> Illumination:
    """Average the lit fraction over 3 x 3 pixels: one shadow ray per texel leaves grain in a penumbra."""
    coverage = cv2.blur(head.covered.astype(np.float32), (3, 3))

    def smooth(closed: np.ndarray, opened: np.ndarray) -> np.ndarray:
        fraction = closed / np.maximum(opened, 1e-6)
        result = np.empty_like(closed)
        for k in range(len(closed)):
            blurred = cv2.blur(head.scatter(fraction[k]), (3, 3)) / np.maximum(coverage, 1e-6)[..., None]
            result[k] = np.clip(blurred[head.covered], 0, 1) * opened[k]
        return result

    return Illumination(
        smooth(lit.irradiance, lit.irradiance_open),
        lit.irradiance_open,
        smooth(lit.specular, lit.specular_open),
        lit.specular_open,
    )


def channels_of(lit: LitHead, albedo: np.ndarray, k: int) -> dict[str, np.ndarray]:
    """The paper's channels (section 3.2) of one light as images, linear, black outside the head."""
    light = lit.illumination
    irradiance = light.irradiance[k] + bounced(lit.blocked, albedo, light.irradiance[k])
    image = albedo * irradiance + light.specular[k]
    unshadowed = albedo * light.irradiance_open[k] + light.specular_open[k]
    shadow_fraction = 1 - (irradiance @ _GREY) / np.maximum(light.irradiance_open[k] @ _GREY, 1e-6)
    gloss_fraction = 1 - (light.specular[k] @ _GREY) / np.maximum(light.specular_open[k] @ _GREY, 1e-6)
    scatter = lit.head.scatter
    return {
        "image": scatter(image),
        "specular": scatter(light.specular[k] @ _GREY),
        "shadow": scatter(np.maximum((unshadowed - image) @ _GREY, 0)),
        "shadow_fraction": scatter(np.clip(shadow_fraction, 0, 1)),
        "gloss_fraction": scatter(np.clip(gloss_fraction, 0, 1)),
        "light": lit.lights[k],
    }


def surface_of(lit: LitHead, albedo: np.ndarray) -> dict[str, np.ndarray]:
    """What does not depend on the light: albedo (linear), normal, relief, labels, coverage."""
    scatter = lit.head.scatter
    return {
        "albedo": scatter(albedo),
        "normal": scatter(lit.normal),
        "relief": scatter(lit.head.depth),
        "label": scatter(lit.head.label),
        "covered": lit.head.covered.astype(np.float32),
    }


def _without_hidden(channels: dict[str, np.ndarray], hidden: np.ndarray | None) -> dict[str, np.ndarray]:
    """What an object in front hides of the head is background, and nothing is learnt from it."""
    if hidden is None:
        return {}
    return {name: np.where(hidden, 0, channels[name]).astype(channels[name].dtype) for name in ("covered", "label")}


def mirrored(sample: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The same sample in a mirror: images and light flipped, normals and sides exchanged."""
    flipped = {name: np.ascontiguousarray(value[:, ::-1]) for name, value in sample.items()}
    flipped["normal"] = flipped["normal"] * np.array([-1, 1, 1], np.float32)
    flipped["label"] = _MIRRORED_LABELS[flipped["label"]]
    return flipped


def relief_shadows(lit: LitHead, rng: np.random.Generator) -> np.ndarray:
    """Shadow fractions (K, S, S) that a relief casts which is as rough as a predicted one.

    The true relief is stretched, smoothed and bent a little, so that the SS network learns to correct
    the hint rather than to copy it.
    """
    size = lit.head.size
    covered = lit.head.covered.astype(np.float32)
    weight = cv2.GaussianBlur(covered, (0, 0), deviation := size / 128 * rng.uniform(0.4, 1.6))
    smooth = cv2.GaussianBlur(lit.head.scatter(lit.head.depth), (0, 0), deviation) / np.maximum(weight, 1e-3)
    bend = cv2.resize(rng.standard_normal((5, 5)).astype(np.float32), (size, size), interpolation=cv2.INTER_CUBIC)
    rough = smooth * rng.uniform(0.75, 1.2) + 0.02 * bend

    def shrunk(image: np.ndarray) -> torch.Tensor:
        return torch.from_numpy(cv2.resize(image, (RELIEF_SIZE, RELIEF_SIZE), interpolation=cv2.INTER_AREA))

    normal = shrunk(lit.head.scatter(lit.normal)).permute(2, 0, 1)
    normal = torch.nn.functional.normalize(normal, dim=0, eps=1e-3)
    transport = march_relief(shrunk(rough), normal, shrunk(covered))
    fraction = transport.shadow_fraction(torch.from_numpy(lit.lights))[:, 0].numpy()
    return np.stack([cv2.resize(f, (size, size), interpolation=cv2.INTER_LINEAR) for f in fraction])


class SampleStream(IterableDataset):
    """Pairs of lights of the same head, pose and albedo, as fine-tuning needs them (paper, section 4.3).

    Each item is a dict of tensors: "photo_srgb" (2, 3, S, S), "image", "specular", "shadow", ... with a
    leading axis of two lights; "albedo", "normal", "relief", "label", "covered" without one.

    Args:
        folder: baked shards; heads that appear while it runs are picked up at the next pass.
        size: side of the images; the shards' own size or a divisor of it.
        photographs: also take photos (de-lighting needs them, the other networks do not).
        relief_shadow: also march a relief as rough as a predicted one ("relief_shadow", a hint to SS).
    """

    def __init__(
        self,
        folder: Path,
        lights: Path,
        split: str,
        size: int,
        seed: int,
        *,
        photographs: bool = True,
        relief_shadow: bool = False,
        lights_per_head: int = 10,
        paints_per_head: int = 24,
        heads_at_once: int = 8,
    ):
        super().__init__()
        self.folder, self.lights, self.split, self.size, self.seed = folder, lights, split, size, seed
        self.photographs, self.relief_shadow = photographs, relief_shadow
        self.lights_per_head, self.paints_per_head = lights_per_head, paints_per_head
        self.heads_at_once = heads_at_once

    def __iter__(self) -> Iterator[dict[str, torch.Tensor]]:
        worker = get_worker_info()
        rng = np.random.default_rng([self.seed, worker.id if worker else 0])
        library = load_lights(self.lights, self.split)
        pool = TexturePool(rng, library.panoramas)
        while True:
            paths = load_split(self.folder, self.split)
            if not paths:
                raise InputError(f"{self.folder}: no baked heads; run 'relight dataset bake' first")
            order = rng.permutation(len(paths))
            for start in range(0, len(order), self.heads_at_once):
                lit = [self._light(paths[i], library, pool, rng) for i in order[start : start + self.heads_at_once]]
                for draw in rng.permutation(len(lit) * self.paints_per_head):
                    yield self._sample(lit[draw % len(lit)], pool, rng)

    def _light(self, path: Path, library: LightLibrary, pool: TexturePool, rng: np.random.Generator) -> LitHead:
        head = read_shard(path)
        head = subsample(head, head.size // self.size, rng)
        normal = add_relief(head, pool.noise(rng), rng.uniform(0, 0.2))
        lights = np.stack([sample_light(library, rng) for _ in range(self.lights_per_head)])
        lit = light_head(head, normal, lights)
        if self.photographs:
            lit = replace(lit, appearance=self._appearance(lit, rng))
        return replace(lit, relief_shadow=relief_shadows(lit, rng)) if self.relief_shadow else lit

    def _appearance(self, lit: LitHead, rng: np.random.Generator) -> Appearance:
        gloss = Gloss(rng.uniform(0.2, 1.2), rng.uniform(0.3, 0.65))
        occluder = sample_occluder(rng) if rng.random() < _OCCLUDED_SHARE else None
        scatter_px = rng.uniform(0.3, 2.0) * self.size / 128 if rng.random() < _SCATTERING_SHARE else 0.0
        return appear(lit.head, lit.normal, lit.lights, lit.illumination, gloss, occluder, scatter_px)

    def _sample(self, lit: LitHead, pool: TexturePool, rng: np.random.Generator) -> dict[str, torch.Tensor]:
        albedo = paint(lit.head, pool, rng)
        mirror = rng.random() < 0.5
        surface = surface_of(lit, albedo)
        pair = []
        for k in rng.choice(self.lights_per_head, 2, replace=False):
            channels = channels_of(lit, albedo, k) | surface
            if lit.appearance is not None:
                channels["photo_srgb"] = photograph(
                    lit.head.scatter(lit.appearance.radiance(lit.head, albedo, lit.blocked, k)),
                    lit.head.covered,
                    lit.lights[k],
                    float(lit.illumination.irradiance[k].mean()),
                    pool,
                    rng,
                    hidden=lit.appearance.hidden,
                )
                channels |= _without_hidden(channels, lit.appearance.hidden)
            if lit.relief_shadow is not None:
                channels["relief_shadow"] = lit.relief_shadow[k]
            pair.append(mirrored(channels) if mirror else channels)
        return _tensors(pair, shared=set(surface))


def _tensors(pair: list[dict[str, np.ndarray]], shared: set[str]) -> dict[str, torch.Tensor]:
    item = {}
    for name, value in pair[0].items():
        arrays = [value] if name in shared else [channels[name] for channels in pair]
        stacked = torch.from_numpy(np.stack([np.ascontiguousarray(array) for array in arrays]))
        if name == "light":
            item[name] = stacked.float()
        elif name == "label":
            item[name] = stacked[0].long()
        else:
            stacked = stacked.float().unsqueeze(1) if stacked.ndim == 3 else stacked.float().permute(0, 3, 1, 2)
            item[name] = stacked[0] if name in shared else stacked
    return item
