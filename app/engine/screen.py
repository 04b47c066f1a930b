"""From the library's arrays to arrays a texture takes. All arithmetic is relight_core's."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from relight_core.imaging.half_floats import LARGEST_HALF
from relight_core.imaging.resampling import at_size, resize_cut_out, shrunk_size
from relight_core.imaging.view_transform import apply_view
from relight_core.lighting.enlarge import COARSE_HEIGHT, enlarge
from relight_core.lighting.environment import Environment
from relight_core.lighting.panorama import shrink
from relight_core.lighting.preview import lit_ball
from relight_core.lighting.rigs import load_rig
from relight_core.pipeline.results.channel_view import channel_to_srgb
from relight_core.pipeline.results.display import LARGEST_SIDE

PANORAMA_HEIGHT = 256
BALL_SIZE = 96
_PANORAMA_EV = -1.0
_ROWS = 256


def radiance_for_screen(linear: np.ndarray, alpha: np.ndarray | None = None) -> np.ndarray:
    """(H, W, 3) linear and perhaps (H, W) alpha as one (h, w, 3 or 4) float16 array, at most LARGEST_SIDE.

    Under alpha 0 it is black: what a file hides there would shine through where a texture is magnified.
    """
    size = shrunk_size(linear.shape[:2], LARGEST_SIDE)
    if alpha is None:
        pixels = at_size(linear, size)
    else:
        linear = np.where(alpha[..., None] > 0, linear, 0)
        pixels = np.dstack((linear, alpha) if alpha.shape == size else resize_cut_out(linear, alpha, size))
    halves = np.empty(pixels.shape, np.float16)
    for top in range(0, len(pixels), _ROWS):
        # In one piece it would need another copy of the whole photo for a moment.
        halves[top : top + _ROWS] = np.minimum(pixels[top : top + _ROWS], np.float32(LARGEST_HALF))
    return halves


def channels_for_screen(channels: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Every channel as (h, w, 3) uint8 sRGB."""
    return {name: _codes(channel_to_srgb(name, array)) for name, array in channels.items()}


def panorama_for_screen(environment: Environment, gain: float = 1.0) -> np.ndarray:
    """(h, 2h, 3) uint8 sRGB of a light's shape, unturned, `gain` times as bright; h is at most 256."""
    shape = environment.shape
    if environment.height > PANORAMA_HEIGHT:
        shape = shrink(shape, PANORAMA_HEIGHT)
    elif environment.height < COARSE_HEIGHT:
        shape = enlarge(shape, environment.height * (PANORAMA_HEIGHT // environment.height))
    return _codes(apply_view(shape * np.float32(gain), _PANORAMA_EV))


def ball_for_screen(environment: Environment) -> np.ndarray:
    """(96, 96, 4) uint8: sRGB of a ball in the light, and its coverage."""
    ball = lit_ball(environment, BALL_SIZE)
    return _codes(np.dstack([apply_view(ball[..., :3]), ball[..., 3]]))


@lru_cache(maxsize=64)
def rig_for_screen(name: str) -> tuple[Environment, np.ndarray, np.ndarray]:
    """A bundled light with its panorama and its ball."""
    environment = load_rig(name)
    return environment, panorama_for_screen(environment), ball_for_screen(environment)


def _codes(srgb: np.ndarray) -> np.ndarray:
    return np.rint(np.clip(srgb, 0.0, 1.0) * 255).astype(np.uint8)
