"""From a relit view to a finished picture: pasted into the photo, over the background that was asked for."""

from __future__ import annotations

import re

import numpy as np

from relight_core.errors import InputError
from relight_core.face.crop import Crop
from relight_core.face.paste import paste_crop, soft_edge
from relight_core.imaging.colour import srgb_decode
from relight_core.imaging.matte import replace_background

_EDGE_SHARE = 0.12


def finish(photo: np.ndarray, relit: np.ndarray, view: Crop, matte: np.ndarray) -> np.ndarray:
    """The relit view in the photo: the person changes, what is behind stays.

    Args:
        photo: (H, W, 3) linear.
        relit: (S, S, 3) linear, the view at the photo's resolution.
        matte: (H, W) person in [0, 1].

    Returns:
        (H, W, 3) float32 linear.
    """
    pasted = paste_crop(photo, relit, view, _fading_edge(relit.shape[0], view, photo.shape[:2]))
    return photo + matte[..., None] * (pasted - photo)


def _fading_edge(size: int, view: Crop, photo_size: tuple[int, int]) -> np.ndarray:
    """A soft edge only on the sides where the photo goes on: nothing fades at its own border."""
    ramp = soft_edge(size, _EDGE_SHARE)
    middle = ramp[size // 2]
    across, down = middle.copy(), middle.copy()
    x0, y0, x1, y1 = view.window
    half = size // 2
    if x0 <= 0:
        across[:half] = 1
    if x1 >= photo_size[1]:
        across[half:] = 1
    if y0 <= 0:
        down[:half] = 1
    if y1 >= photo_size[0]:
        down[half:] = 1
    return down[:, None] * across[None, :]


def over_background(
    image: np.ndarray, matte: np.ndarray, background: str, panorama: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray | None]:
    """The picture over another background: image (H, W, 3) linear and alpha (H, W) or None.

    Args:
        background: "keep", "light", "transparent" or "#rrggbb".
        panorama: (H, W, 3) linear, what is behind the person where the background is "light".

    Raises:
        InputError: a background that is none of these.
    """
    if background == "keep":
        return image, None
    if background == "transparent":
        return image, matte
    return replace_background(image, matte, panorama if background == "light" else _colour(background)), None


def _colour(text: str) -> np.ndarray:
    """Linear (3,) of "#rrggbb"."""
    if not re.fullmatch(r"#[0-9a-fA-F]{6}", text):
        raise InputError(f"unknown background {text!r}: use keep, light, transparent or a colour such as #30343a")
    codes = np.array([int(text[i : i + 2], 16) for i in (1, 3, 5)], np.float32)
    return srgb_decode(codes / 255)
