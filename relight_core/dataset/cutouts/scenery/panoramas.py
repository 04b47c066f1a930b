"""Views into measured panoramas: real places, as a camera would see them behind a person."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from relight_core.dataset.cutouts.scenery.strokes import SIZE
from relight_core.dataset.lighting.light_folder import panoramas_in
from relight_core.errors import InputError
from relight_core.lighting.environment import read_environment

_WIDTH = 1024
_WIDTHS_OF_VIEW_DEG = (30.0, 100.0)
_MIDDLE_GREY = 0.25


def read_places(folder: Path) -> tuple[np.ndarray, ...]:
    """The panoramas (.hdr, .exr) of a folder and its sub-folders, (H, W, 3) linear, exposed for their middle half.

    Raises:
        InputError: none there, or one that can't be read.
    """
    paths = panoramas_in(folder)
    if not paths:
        raise InputError(f"{folder}: no panoramas; give a folder of .hdr and .exr files")
    return tuple(_exposed(read_environment(path).shape) for path in paths)


def _exposed(radiance: np.ndarray) -> np.ndarray:
    if radiance.shape[1] > _WIDTH:
        radiance = cv2.resize(radiance, (_WIDTH, _WIDTH // 2), interpolation=cv2.INTER_AREA)
    level = np.median(radiance[len(radiance) // 4 : -len(radiance) // 4])
    return np.clip(radiance * (_MIDDLE_GREY / max(float(level), 1e-6)), 0, 4).astype(np.float32)


def look_around(panorama: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """(SIZE, SIZE, 3): a view in any direction near the horizon, as wide as a portrait's or a room's."""
    width_deg, pitch_deg = rng.uniform(*_WIDTHS_OF_VIEW_DEG), np.clip(rng.normal(0, 12), -35, 35)
    reach = np.tan(np.radians(width_deg) / 2)
    axis = np.linspace(-reach, reach, SIZE)
    x, y = np.meshgrid(axis, -axis)
    toward = np.stack([x, y, np.ones_like(x)], -1) / np.sqrt(1 + x**2 + y**2)[..., None]
    pitch = np.radians(pitch_deg)
    up = np.cos(pitch) * toward[..., 1] + np.sin(pitch) * toward[..., 2]
    ahead = np.cos(pitch) * toward[..., 2] - np.sin(pitch) * toward[..., 1]
    height, width = panorama.shape[:2]
    column = (np.arctan2(toward[..., 0], ahead) / (2 * np.pi) + rng.random()) * width
    row = np.arccos(np.clip(up, -1, 1)) / np.pi * height
    place = (column % width - 0.5).astype(np.float32), (row - 0.5).astype(np.float32)
    return cv2.remap(panorama, *place, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
