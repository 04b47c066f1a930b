"""The lights a head is shown in: measured panoramas and random studio rigs, split once by place."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from relight_core.dataset.archive import read_arrays
from relight_core.dataset.lighting.light_folder import read_light_folder
from relight_core.errors import InputError
from relight_core.lighting.environment import NETWORK_HEIGHT
from relight_core.lighting.panorama import normalise_light, rotate, shrink
from relight_core.lighting.sphere import directions, off_axis

_SPLIT_SEED = 20
_TEST_LIGHTS = 20
_VALIDATION_LIGHTS = 8
_DRAWN_HEIGHT = 64


@dataclass(frozen=True)
class LightLibrary:
    """Measured panoramas (N, 64, 128, 3) with their names."""

    panoramas: np.ndarray
    names: tuple[str, ...]


def load_lights(path: Path, split: str) -> LightLibrary:
    """Panoramas of one split: "train", "validation" or "test", of a library or of a folder of panoramas.

    Places (`group` in the file, see `light_folder`) never straddle a split: test holds 20 lights as in the
    paper (section 3.2), validation 8, but from six lights up no more than a third and a sixth of all; training
    has the rest.

    Raises:
        InputError: as `read_lights`; or too few lights for this split to have any.
    """
    library, groups = read_lights(path)
    test, validation = _TEST_LIGHTS, _VALIDATION_LIGHTS
    if len(groups) >= 6:
        test, validation = min(test, len(groups) // 3), min(validation, len(groups) // 6)
    order = np.random.default_rng(_SPLIT_SEED).permutation(np.unique(groups))
    held_out: dict[str, list[int]] = {"test": [], "validation": []}
    for group in order:
        members = np.flatnonzero(groups == group).tolist()
        for name, wanted in (("test", test), ("validation", validation)):
            if len(held_out[name]) + len(members) <= wanted:
                held_out[name] += members
                break
    reserved = set(held_out["test"]) | set(held_out["validation"])
    training = [index for index in range(len(groups)) if index not in reserved]
    chosen = {**held_out, "train": training}[split]
    if not chosen:
        raise InputError(f"{path}: too few places for the {split} split to have any; add panoramas of other places")
    return LightLibrary(library.panoramas[chosen], tuple(library.names[index] for index in chosen))


def read_lights(path: Path) -> tuple[LightLibrary, np.ndarray]:
    """All panoramas of a library or of a folder, and the place (N,) of each.

    Raises:
        InputError: missing, damaged or no light library, or a panorama without light.
    """
    data = _read(path)
    panoramas, names = np.clip(data["env64"].astype(np.float32), 0, None), tuple(map(str, data["names"]))
    if not np.isfinite(panoramas).all():
        raise InputError(f"{path}: a panorama has values that are no numbers, or infinite ones; make the library anew")
    for panorama, name in zip(panoramas, names, strict=True):
        if not panorama.any():
            raise InputError(f"{path}: its panorama {name!r} is black, and shows nothing; leave it out")
    return LightLibrary(panoramas, names), data["group"]


def _read(path: Path) -> dict[str, np.ndarray]:
    if path.is_dir():
        return read_light_folder(path)
    mend = "give an .npz of panoramas with env64, names and group, or a folder of .hdr and .exr panoramas"
    arrays = read_arrays(path, ("env64", "names", "group"), "a light library", mend)
    shapes = {name: array.shape for name, array in arrays.items()}
    count = len(arrays["names"]) if shapes["names"] else 0
    wanted = {"env64": (count, _DRAWN_HEIGHT, 2 * _DRAWN_HEIGHT, 3), "names": (count,), "group": (count,)}
    for name, shape in wanted.items():
        if shapes[name] != shape:
            raise InputError(f"{path}: not a light library ({name} is {shapes[name]} and not {shape}); {mend}")
    if arrays["env64"].dtype.kind not in "fiu":
        raise InputError(f"{path}: not a light library (env64 holds no real numbers); {mend}")
    # What equals nothing, not even itself, would be held out of no split.
    if (arrays["group"] != arrays["group"]).any():
        raise InputError(f"{path}: not a light library (a place in group is no number); {mend}")
    return arrays


def sample_light(library: LightLibrary, rng: np.random.Generator) -> np.ndarray:
    """A normalised light (64, 128, 3): a turned, mirrored panorama, at times with a lamp behind, or random lamps."""
    chance = rng.random()
    if chance < 0.4:
        light = sample_panorama(library, rng)
    elif chance < 0.5:
        light = backlit(sample_panorama(library, rng), rng)
    elif chance < 0.85:
        light = sample_rig(rng, lamps=int(rng.integers(1, 5)), ambient=10 ** rng.uniform(-1.5, 0))
    elif chance < 0.97:
        light = sample_rig(rng, lamps=1, ambient=10 ** rng.uniform(-2.5, -1))
    else:
        light = np.ones((_DRAWN_HEIGHT, 2 * _DRAWN_HEIGHT, 3), np.float32)
    return normalise_light(light)


def sample_network_lights(library: LightLibrary, rng: np.random.Generator, count: int) -> np.ndarray:
    """So many of them as the networks see lights, (count, 16, 32, 3)."""
    return np.stack([shrink(sample_light(library, rng), NETWORK_HEIGHT) for _ in range(count)])


def sample_panorama(library: LightLibrary, rng: np.random.Generator) -> np.ndarray:
    """A panorama turned by any angle (section 3.2), mirrored half the time, its saturation varied."""
    light = rotate(library.panoramas[rng.integers(len(library.panoramas))], rng.uniform(0, 360))
    if rng.random() < 0.5:
        light = light[:, ::-1]
    grey = light.mean(-1, keepdims=True)
    return np.maximum(grey + (light - grey) * rng.uniform(0.3, 1.3), 0)


def sample_rig(rng: np.random.Generator, lamps: int, ambient: float) -> np.ndarray:
    """Random round lamps, more often in front than behind, over an ambient gradient. (64, 128, 3)."""
    toward = directions(_DRAWN_HEIGHT, 2 * _DRAWN_HEIGHT)
    light = lamp_colour(rng, 0.3) * ambient * (1 + rng.uniform(-0.9, 0.9) * toward[..., 1:2])
    for _ in range(lamps):
        direction = rng.standard_normal(3) + [0, 0.35, 0.5]
        direction /= np.linalg.norm(direction)
        radius_deg = 10 ** rng.uniform(0.6, 1.6)
        angle_deg = np.degrees(np.arccos(np.clip(toward @ direction, -1, 1)))
        edge = np.clip((radius_deg - angle_deg) / max(0.25 * radius_deg, 2.0) + 0.5, 0, 1)
        power = 10 ** rng.uniform(-0.6, 0.3) / max(1 - np.cos(np.radians(radius_deg)), 2e-3)
        light = light + edge[..., None] * power * lamp_colour(rng, 0.5)
    return light.astype(np.float32)


def backlit(light: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A light (64, 128, 3) with a window or a lamp beside or above and behind the person, and more of that than of it.

    It draws a bright rim along hair, ear and jaw, as photographers like it.
    """
    cosine = directions(_DRAWN_HEIGHT, 2 * _DRAWN_HEIGHT) @ off_axis(rng.uniform(100, 150), rng.uniform(-20, 200))
    lamp = normalise_light((cosine > np.cos(np.radians(rng.uniform(5, 20))))[..., None] * lamp_colour(rng, 0.3))
    return normalise_light(light) + rng.uniform(1, 6) * lamp


def lamp_colour(rng: np.random.Generator, spread: float) -> np.ndarray:
    """Mostly along the warm-cool axis, sometimes a coloured gel."""
    warmth = rng.normal(0, spread)
    colour = np.exp(np.array([0.5, 0.0, -0.6]) * warmth)
    if rng.random() < 0.12:
        colour = colour * np.exp(rng.normal(0, 0.8, 3))
    return (colour / colour.mean()).astype(np.float32)
