"""Draws icon.png beside this file: a ball in a bundled light on a dark tile. Run it from the project's root:

python -m resources.icon.draw_icon
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from relight_core.imaging.colour import srgb_encode
from relight_core.lighting.preview import lit_ball
from relight_core.lighting.rigs import load_rig

SIZE = 256
_RIG = "golden-hour"
_BALL_SHARE, _CORNER_SHARE = 0.74, 0.22
_TILE_SRGB = 0.13


def draw() -> np.ndarray:
    """(SIZE, SIZE, 4) sRGB and coverage, [0, 1]."""
    side = round(SIZE * _BALL_SHARE)
    start = (SIZE - side) // 2
    ball = lit_ball(load_rig(_RIG), side)
    icon = np.full((SIZE, SIZE, 4), _TILE_SRGB, np.float32)
    icon[..., 3] = _rounded_tile()
    inside = icon[start : start + side, start : start + side, :3]
    coverage = ball[..., 3:]
    inside[:] = inside * (1 - coverage) + np.clip(srgb_encode(ball[..., :3]), 0, 1) * coverage
    return icon


def _rounded_tile() -> np.ndarray:
    """(SIZE, SIZE) coverage of a square with rounded corners."""
    radius = SIZE * _CORNER_SHARE
    from_middle = np.abs(np.arange(SIZE) + 0.5 - SIZE / 2)
    beyond = np.maximum(from_middle - (SIZE / 2 - radius), 0)
    return np.clip(radius - np.hypot(beyond[:, None], beyond[None, :]) + 0.5, 0, 1).astype(np.float32)


if __name__ == "__main__":
    from PIL import Image

    codes = np.rint(np.clip(draw(), 0, 1) * 255).astype(np.uint8)
    Image.fromarray(codes).save(Path(__file__).with_name("icon.png"), optimize=True)
