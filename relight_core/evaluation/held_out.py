"""The held-out pictures: heads and lights that no training has seen, the same ones for everybody.

Everything follows from seeds: which heads (`dataset.recipe.SPLIT_SEEDS`), their skin, how far each
panorama is turned, which light a photo is taken under and which one it is then relit with.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from relight_core.dataset.baking.bake import add_relief
from relight_core.dataset.baking.shard import read_shard
from relight_core.dataset.camera import metered_gain, photograph
from relight_core.dataset.lighting.lights import load_lights
from relight_core.dataset.painting.skin import paint
from relight_core.dataset.painting.texture import TexturePool
from relight_core.dataset.recipe import load_split
from relight_core.dataset.samples import LitHead, channels_of, light_head, subsample, surface_of
from relight_core.errors import InputError
from relight_core.evaluation.stride import stride_around
from relight_core.imaging.colour import srgb_decode
from relight_core.lighting.environment import NETWORK_HEIGHT, Environment, network_light
from relight_core.lighting.lamps import Lamp, lamps_of
from relight_core.lighting.sphere import directions, off_axis, solid_angles

_YAW_SEED = 391
_SKIN_SEED = 438
_CAMERA_SEED = 439
_RELIEF_STRENGTH = 0.1
_SUBJECT_SHARE = 0.45
_DRAWN_HEIGHT = 64
_LAMP_RADIUS_DEG = 5.0
_LAMP_SHARE = 0.95

LAMPS = ((50.0, 0.0), (60.0, 35.0), (60.0, 145.0), (70.0, 180.0))
"""Angle from the camera's axis and angle around it (0 is +x, 90 is +y) of the single lamps, in degrees."""

Photos = Literal["clean", "camera"]


@dataclass(frozen=True)
class HeldOutLight:
    """A light of the test.

    Attributes:
        radiance: (16, 32, 3) of mean luminance 1.
        lamp: whether it is one small lamp.
        small_lamps: what the editor finds in it at its own size.
    """

    name: str
    radiance: np.ndarray
    lamp: bool
    small_lamps: tuple[Lamp, ...] = ()


@dataclass(frozen=True)
class HeldOutHead:
    """A painted head under every light of the test, in the lights' order."""

    name: str
    seed: int
    lit: LitHead
    albedo: np.ndarray
    pool: TexturePool

    def channels(self, light: int) -> dict[str, np.ndarray]:
        """The true channels under one light, images (S, S, ...), linear, black outside the head."""
        return channels_of(self.lit, self.albedo, light)

    def surface(self) -> dict[str, np.ndarray]:
        """The true albedo, normal, relief, labels and coverage, images (S, S, ...)."""
        return surface_of(self.lit, self.albedo)

    def white_level(self, light: int) -> float:
        """Mean radiance that a white head would have in this one's place."""
        return float(self.lit.illumination.irradiance[light].mean())

    def exposure(self, light: int) -> float:
        """The gain at which a meter would show this head under one light: the training camera's, without its chance."""
        radiance, covered = self.channels(light)["image"], self.lit.head.covered
        return metered_gain(radiance, covered, self.white_level(light), _SUBJECT_SHARE)

    def photo(self, light: int, kind: Photos) -> np.ndarray:
        """A photo under one light: linear (S, S, 3), [0, 1].

        "clean": the rendering before black, metered and clipped at 1. "camera": through the training
        camera (white balance, tone, noise, JPEG, background), drawn by the seeds of head and light.
        """
        radiance, covered = self.channels(light)["image"], self.lit.head.covered
        if kind == "clean":
            return np.clip(radiance * self.exposure(light), 0, 1).astype(np.float32)
        rng = np.random.default_rng([_CAMERA_SEED, self.seed, light])
        white_level = self.white_level(light)
        return srgb_decode(photograph(radiance, covered, self.lit.lights[light], white_level, self.pool, rng))


@dataclass(frozen=True)
class Case:
    """One relighting: a photo under `source`, relit with `target`; both index the lights."""

    source: int
    target: int


def held_out_lights(path: Path, split: str) -> list[HeldOutLight]:
    """The split's panoramas, each turned by its own fixed angle, then the single lamps.

    Raises:
        InputError: the library can't be read, or has no lights for this split.
    """
    library = load_lights(path, split)
    yaws_deg = np.random.default_rng(_YAW_SEED).uniform(0, 360, len(library.names))
    lights = [
        _held_out(Environment.from_radiance(panorama, name), float(yaw_deg), is_lamp=False)
        for name, panorama, yaw_deg in zip(library.names, library.panoramas, yaws_deg, strict=True)
    ]
    return lights + [_held_out(lamp(*angles), 0.0, is_lamp=True) for angles in LAMPS]


def _held_out(light: Environment, yaw_deg: float, *, is_lamp: bool) -> HeldOutLight:
    return HeldOutLight(light.name, network_light(_in_rows(light), yaw_deg), is_lamp, lamps_of(light, yaw_deg))


def _in_rows(light: Environment) -> Environment:
    """The light with its rows averaged to as many as the networks read.

    The editor spreads a lamp over two of them. Here it stays as sharp as in training, and as it was in every figure.
    """
    rows, width = light.shape.shape[:2]
    shares = solid_angles(rows, width)[:, 0].reshape(NETWORK_HEIGHT, -1)
    bands = light.shape.reshape(*shares.shape, width, 3)
    means = np.einsum("ij,ijwc->iwc", shares / shares.sum(1, keepdims=True), bands)
    return Environment(means.astype(np.float32), light.level, light.name)


def lamp(off_axis_deg: float, around_deg: float) -> Environment:
    """One round lamp of 5 degrees' radius with 95 % of the light, the rest from everywhere; angles as of `off_axis`."""
    cosine = directions(_DRAWN_HEIGHT, 2 * _DRAWN_HEIGHT) @ off_axis(off_axis_deg, around_deg)
    disc = Environment.from_radiance((cosine > np.cos(np.radians(_LAMP_RADIUS_DEG))).astype(np.float32))
    grey = _LAMP_SHARE * disc.shape + (1 - _LAMP_SHARE)
    return Environment.from_radiance(grey, f"lamp-{off_axis_deg:g}-{around_deg:g}")


def held_out_paths(folder: Path, split: str, count: int) -> list[Path]:
    """The first `count` heads of a split; raises InputError when none is baked."""
    paths = load_split(folder, split)
    if not paths:
        raise InputError(
            f"{folder}: no heads of the {split} split; bake them: "
            f"relight dataset bake --split {split} --count {count} --out {folder} --heads MODEL.npz"
        )
    return paths[:count]


def held_out_textures() -> TexturePool:
    """What all heads of the test are painted with."""
    return TexturePool(np.random.default_rng(_SKIN_SEED))


def load_head(path: Path, lights: list[HeldOutLight], pool: TexturePool, size: int | None = None) -> HeldOutHead:
    """Read, paint (natural skin only) and light one head.

    Args:
        size: of its images, the baked size or a divisor of it; pixels between are left out, as in training.

    Raises:
        InputError: the file is damaged, or its head can't have this size.
    """
    head, seed = read_shard(path), int(path.stem.split("-")[1])
    rng = np.random.default_rng([_SKIN_SEED, seed])
    if size is not None:
        if head.size % size:
            raise InputError(f"{path}: a head of {head.size} pixels has no size of {size}; bake it larger")
        head = subsample(head, head.size // size, rng)
    normal = add_relief(head, head.normal, pool.noise(rng), _RELIEF_STRENGTH)
    albedo = paint(head, pool, rng, wild=False)
    lit = light_head(head, normal, np.stack([light.radiance for light in lights]))
    return HeldOutHead(path.stem, seed, lit, albedo, pool)


def cases_of(head_number: int, lights: list[HeldOutLight]) -> list[Case]:
    """The relightings of one head: every panorama once as source and once as target, then every lamp.

    Which target goes with which source differs between heads, as long as there are pairs; source and target are
    different lights where there are two panoramas or more.
    """
    panoramas = [index for index, light in enumerate(lights) if not light.lamp]
    lamps = [index for index, light in enumerate(lights) if light.lamp]
    count = len(panoramas)
    shifts = max(count - 1, 1)
    shift = 1 + (stride_around(shifts) * head_number) % shifts
    cases = [Case(panoramas[i], panoramas[(i + shift) % count]) for i in range(count)]
    first = head_number * len(lamps)
    # Once all panoramas have been sources for lamps, each is one for the next lamp.
    first += first // count
    return cases + [Case(panoramas[(first + i) % count], lamp) for i, lamp in enumerate(lamps)]
