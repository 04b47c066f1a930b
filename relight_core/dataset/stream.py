"""The endless stream of training samples: a pure function of its seed and of the place in it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import IntEnum
from pathlib import Path

import numpy as np
import torch
from torch.utils.data import IterableDataset, get_worker_info

from relight_core.dataset.baking.bake import FABRIC, BakedHead, add_relief
from relight_core.dataset.baking.shard import read_shard
from relight_core.dataset.camera import photograph
from relight_core.dataset.lighting.appearance import Appearance, appear
from relight_core.dataset.lighting.lights import LightLibrary, load_lights, sample_light
from relight_core.dataset.lighting.occluders import sample_occluder
from relight_core.dataset.painting.skin import paint, paint_smooth
from relight_core.dataset.painting.skin_textures import load_skins
from relight_core.dataset.painting.texture import TexturePool
from relight_core.dataset.recipe import load_split
from relight_core.dataset.samples import (
    LitHead,
    as_tensors,
    channels_of,
    light_head,
    mirrored,
    relief_shadows,
    subsample,
    surface_of,
    without_hidden,
)
from relight_core.dataset.surroundings import Neighbour, sample_local_light, sample_neighbour, with_local_light
from relight_core.dataset.warp import sample_warp, warped
from relight_core.errors import InputError
from relight_core.lighting.environment import NETWORK_HEIGHT
from relight_core.lighting.panorama import shrink
from relight_core.lighting.reflection import GLOSS, Gloss

_OCCLUDED_SHARE, _SCATTERING_SHARE = 0.25, 0.6
_DULLNESS = (0.4, 1.4)
_LOCALLY_LIT_SHARE, _ACCOMPANIED_SHARE = 0.2, 0.2


class Draw(IntEnum):
    """What is random about samples: each kind of draw has random streams of its own."""

    TEXTURES = 1
    HEADS = 2
    LIGHTING = 3
    TURNS = 4
    SAMPLE = 5


@dataclass(frozen=True)
class Ingredients:
    """What all samples of a worker are made from."""

    heads: list[Path]
    library: LightLibrary
    pool: TexturePool


class SampleStream(IterableDataset):
    """Pairs of lights of the same head, pose and albedo, as fine-tuning needs them (paper, section 4.3).

    Each item is a dict of tensors: "photo_srgb" (2, 3, S, S), "image", "specular", "shadow", ... with a
    leading axis of two lights; "albedo", "normal", "relief", "label", "covered" without one.

    Lighting a head is the slow part, so each lit head is painted and photographed many times. Many samples of one head
    in a row would bias the gradient steps toward it, so many lit heads are held at once and take turns, and the oldest
    is replaced by the next. Every item is drawn from a random stream of its own, so that training can be resumed at any
    batch as if it had never stopped.

    Args:
        folder: baked shards, the heads that are there when the stream starts, and painted skins if there are any.
        size: side of the images; the shards' own size or a divisor of it.
        photographs: also take photos (de-lighting needs them, the other networks do not).
        relief_shadow: also march a relief as rough as a predicted one ("relief_shadow", a hint to SS).
        plain: smooth skin, the reference gloss, no occluders and no warps, to measure what all these are worth.
        lights_per_head: lights on each lit head; a sample takes two of them.
        paints_per_head: mean number of samples of a lit head.
        heads_at_once: lit heads that take turns, divided among the loader's workers. A worker has at least as many as
            there are pairs in a batch.
        first_batch: the batch to resume at.
        pairs: pairs in a batch, the loader's batch size.
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
        plain: bool = False,
        lights_per_head: int = 10,
        paints_per_head: int = 16,
        heads_at_once: int = 32,
        first_batch: int = 0,
        pairs: int = 1,
    ):
        super().__init__()
        self.folder, self.lights, self.split, self.size, self.seed = folder, lights, split, size, seed
        self.photographs, self.relief_shadow = photographs, relief_shadow
        self.plain = plain
        self.lights_per_head, self.paints_per_head = lights_per_head, paints_per_head
        self.heads_at_once = heads_at_once
        self.first_batch, self.pairs = first_batch, pairs

    def __iter__(self) -> Iterator[dict[str, torch.Tensor]]:
        worker = get_worker_info()
        number, workers = (worker.id, worker.num_workers) if worker else (0, 1)
        turn, lane = divmod(self.first_batch + number, workers)
        heads = load_split(self.folder, self.split)
        if not heads:
            raise InputError(f"{self.folder}: no baked heads; run 'relight dataset bake' first")
        library = load_lights(self.lights, self.split)
        pool = TexturePool(self._random(Draw.TEXTURES, lane), library.panoramas, skins=load_skins(self.folder))
        at_once = max(-(-self.heads_at_once // workers), self.pairs)
        yield from self._samples(lane, turn * self.pairs, at_once, Ingredients(heads, library, pool))

    def _random(self, draw: Draw, *place: int) -> np.random.Generator:
        return np.random.default_rng([self.seed, draw, *place])

    def _samples(
        self, lane: int, first: int, at_once: int, ingredients: Ingredients
    ) -> Iterator[dict[str, torch.Tensor]]:
        """The samples of one worker from the `first` on, without end."""

        def lit_head(number: int) -> LitHead:
            path = self._head(lane, number, ingredients.heads)
            return self._light(path, ingredients, self._random(Draw.LIGHTING, lane, number))

        oldest, place = divmod(first, self.paints_per_head)
        lit = {number % at_once: lit_head(number) for number in range(oldest, oldest + at_once - 1)}
        while True:
            newest = oldest + at_once - 1
            lit[newest % at_once] = lit_head(newest)
            for number in range(oldest * self.paints_per_head + place, (oldest + 1) * self.paints_per_head):
                turn = self._turn(lane, number, at_once)
                yield self._sample(lit, turn, ingredients.pool, self._random(Draw.SAMPLE, lane, number))
            oldest, place = oldest + 1, 0

    def _turn(self, lane: int, number: int, at_once: int) -> int:
        """Index of the lit head that a sample shows: all take their turn in random order before one comes again."""
        lap, place = divmod(number, at_once)
        return int(self._random(Draw.TURNS, lane, lap).permutation(at_once)[place])

    def _head(self, lane: int, number: int, heads: list[Path]) -> Path:
        """The head a worker lights after `number` others: all come once, in random order, before any comes again."""
        epoch, place = divmod(number, len(heads))
        return heads[self._random(Draw.HEADS, lane, epoch).permutation(len(heads))[place]]

    def _light(self, path: Path, ingredients: Ingredients, rng: np.random.Generator) -> LitHead:
        head = self._read(path, rng)
        normal = head.normal if self.plain else textured(head, ingredients.pool, rng)
        fine = np.stack([sample_light(ingredients.library, rng) for _ in range(self.lights_per_head)])
        lights = np.stack([shrink(light, NETWORK_HEIGHT) for light in fine])
        lit = replace(light_head(head, normal, lights), fine_lights=fine)
        if self.photographs:
            lit = replace(lit, appearance=self._appearance(lit, rng))
        return replace(lit, relief_shadow=relief_shadows(lit, rng)) if self.relief_shadow else lit

    def _read(self, path: Path, rng: np.random.Generator) -> BakedHead:
        """A head at the samples' size."""
        head = read_shard(path)
        if head.size % self.size:
            raise InputError(f"{path}: a head of {head.size} pixels has no size of {self.size}; give a divisor of it")
        return subsample(head, head.size // self.size, rng)

    def _appearance(self, lit: LitHead, rng: np.random.Generator) -> Appearance:
        if self.plain:
            return appear(lit.head, lit.normal, lit.lights, lit.illumination, GLOSS)
        gloss = sample_gloss(rng)
        occluder = sample_occluder(rng) if rng.random() < _OCCLUDED_SHARE else None
        scatter_px = rng.uniform(0.3, 2.0) * self.size / 128 if rng.random() < _SCATTERING_SHARE else 0.0
        dullness = rng.uniform(*_DULLNESS)
        return appear(lit.head, lit.normal, lit.lights, lit.illumination, gloss, occluder, scatter_px, dullness)

    def _sample(
        self, heads: dict[int, LitHead], index: int, pool: TexturePool, rng: np.random.Generator
    ) -> dict[str, torch.Tensor]:
        lit = heads[index]
        albedo = (paint_smooth if self.plain else paint)(lit.head, pool, rng)
        mirror = rng.random() < 0.5
        warp = None if self.plain else sample_warp(rng)
        surface = surface_of(lit, albedo)
        neighbour = self._neighbour(heads, pool, rng)
        pair = []
        for k in rng.choice(self.lights_per_head, 2, replace=False):
            channels = channels_of(lit, albedo, k) | surface | {"light": lit.fine_lights[k]}
            if lit.appearance is not None:
                channels |= self._before_camera(lit, albedo, k, pool, rng)
                channels |= without_hidden(channels, lit.appearance.hidden)
            if lit.relief_shadow is not None:
                channels["relief_shadow"] = lit.relief_shadow[k]
            channels = mirrored(channels) if mirror else channels
            if warp is None:
                channels["light"] = lit.lights[k][:, ::-1] if mirror else lit.lights[k]
            else:
                channels = warped(channels, warp)
            # The photo is taken last, so that the warp does not resample noise and JPEG's blocks.
            pair.append(channels if lit.appearance is None else _photographed(channels, lit, k, pool, neighbour, rng))
        return as_tensors(pair, shared=set(surface))

    def _before_camera(
        self, lit: LitHead, albedo: np.ndarray, k: int, pool: TexturePool, rng: np.random.Generator
    ) -> dict[str, np.ndarray]:
        """What a photo will be taken of, before warping.

        Returns:
            "radiance" (S, S, 3) linear, premultiplied; "silhouette", the head, and "hidden", the head behind an
            occluder, (S, S) float32, 1 inside.
        """
        radiance = _radiance(lit, albedo, k)
        if not self.plain and rng.random() < _LOCALLY_LIT_SHARE:
            other = _radiance(lit, albedo, rng.integers(self.lights_per_head))
            radiance = with_local_light(radiance, other, sample_local_light(self.size, pool, rng))
        silhouette = lit.head.covered.astype(np.float32)
        hidden = np.zeros_like(silhouette) if lit.appearance.hidden is None else lit.appearance.hidden
        return {"radiance": radiance, "silhouette": silhouette, "hidden": hidden.astype(np.float32)}

    def _neighbour(self, heads: dict[int, LitHead], pool: TexturePool, rng: np.random.Generator) -> Neighbour | None:
        """Now and then another lit head under a light of its own; None for the other samples."""
        if self.plain or not self.photographs or rng.random() >= _ACCOMPANIED_SHARE:
            return None
        other = heads[rng.integers(len(heads))]
        radiance = _radiance(other, paint(other.head, pool, rng), rng.integers(self.lights_per_head))
        return sample_neighbour(radiance, other.head.covered, rng)


def _radiance(lit: LitHead, albedo: np.ndarray, k: int) -> np.ndarray:
    """What a photo sees of a head under light `k`, (S, S, 3)."""
    return lit.head.scatter(lit.appearance.radiance(lit.head, albedo, lit.own, k))


def _photographed(
    channels: dict[str, np.ndarray],
    lit: LitHead,
    k: int,
    pool: TexturePool,
    neighbour: Neighbour | None,
    rng: np.random.Generator,
) -> dict[str, np.ndarray]:
    """The sample with "photo_srgb" in the place of the "radiance", "silhouette" and "hidden" that it is a photo of."""
    radiance, silhouette, hidden = (channels[name] for name in ("radiance", "silhouette", "hidden"))
    photo = photograph(
        radiance,
        silhouette,
        lit.lights[k],
        float(lit.illumination.irradiance[k].mean()),
        pool,
        rng,
        hidden=hidden > 0.5 if hidden.any() else None,
        neighbour=neighbour,
    )
    others = channels.keys() - {"radiance", "silhouette", "hidden"}
    return {name: channels[name] for name in sorted(others)} | {"photo_srgb": photo}


def sample_gloss(rng: np.random.Generator) -> Gloss:
    """The random gloss of one head."""
    return Gloss(rng.uniform(0.2, 1.2), rng.uniform(0.3, 0.65))


def textured(head: BakedHead, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Normals (P, 3) with pores in the skin and threads and small folds in what is worn."""
    normal = add_relief(head, head.normal, pool.noise(rng), rng.uniform(0, 0.2))
    if rng.random() < 0.4:
        return normal
    return add_relief(head, normal, pool.noise(rng), rng.uniform(0, 0.25), FABRIC, int(rng.integers(1, 5)))
