"""A folder of panoramas as a light library."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from relight_core.errors import InputError
from relight_core.imaging.files import whole_file
from relight_core.lighting.environment import Environment, read_environment
from relight_core.lighting.panorama import shrink

_HEIGHT = 64
_SUFFIXES = (".hdr", ".exr")


def panoramas_in(folder: Path) -> list[Path]:
    """All .hdr and .exr files of a folder and its sub-folders, in order of path."""
    return sorted(path for path in folder.rglob("*") if path.suffix.lower() in _SUFFIXES and path.is_file())


def read_light_folder(folder: Path) -> dict[str, np.ndarray]:
    """The arrays of a light library from all .hdr and .exr panoramas of a folder and its sub-folders.

    Panoramas of one place share a group: those of one sub-folder, and of those that lie in the folder itself
    the ones whose names differ only in numbers and what follows them ("kitchen_01", "kitchen_02_4k").

    Returns:
        env64 (N, 64, 128, 3) float32 linear radiance, names (N,), group (N,), in order of path.

    Raises:
        InputError: no panorama in the folder, or one that can't be read or isn't 2:1.
    """
    paths = panoramas_in(folder)
    if not paths:
        raise InputError(f"{folder}: no .hdr or .exr panorama in this folder; put some there")
    places = [path.relative_to(folder) for path in paths]
    return {
        "env64": np.stack([_reduced(read_environment(path)) for path in paths]),
        "names": np.array([place.with_suffix("").as_posix() for place in places]),
        "group": np.array([_group(place) for place in places]),
    }


def write_light_library(path: Path, arrays: dict[str, np.ndarray]) -> None:
    """Keep what `read_light_folder` found as one .npz, which opens in no time."""
    with whole_file(path) as beside, open(beside, "wb") as file:
        np.savez_compressed(file, **arrays)


def _reduced(environment: Environment) -> np.ndarray:
    return shrink(environment.shape * np.float32(min(environment.level, 1e30)), _HEIGHT)


def _group(place: Path) -> str:
    if len(place.parts) > 1:
        return place.parts[0]
    # A year or a resolution may come first; what follows the next number counts views.
    name = re.sub(r"^(?:\d+\w?[ _.\-]+)+", "", place.stem)
    return re.split(r"[ _.\-]*\d", name, maxsplit=1)[0] or place.stem
