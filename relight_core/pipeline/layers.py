"""A relit portrait as layers of one size: the picture and its channels, each at its place in the photo."""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np

from relight_core.face.crop import Crop
from relight_core.face.paste import paste_crop
from relight_core.imaging.resampling import resize_area
from relight_core.pipeline.relighter import Relit

CHANNEL_LAYERS = ("albedo", "normal", "specular", "shadow", "parsing", "composition")
LAYERS = (*CHANNEL_LAYERS, "matte", "background")
"""What can be had beside the picture itself. Channels are 0 where the networks' view does not reach."""


def photo_layers(relit: Relit, names: Iterable[str], longest_side: int | None = None) -> dict[str, np.ndarray]:
    """The picture as "RGB" or, with its alpha multiplied in, "RGBA", and the named layers.

    Args:
        relit: what to take apart.
        names: of LAYERS; those the Relit does not have are left out.
        longest_side: pixels; smaller pictures stay as they are, None keeps the photo's size.

    Returns:
        arrays (H, W), (H, W, 3) or (H, W, 4), float32 linear; "normal" in camera space, unit length inside the
        view; "parsing" labels; "background" what is seen beside the person, premultiplied.

    Raises:
        ValueError: a name that is none.
    """
    wanted = list(names)
    unknown = [name for name in wanted if name not in LAYERS]
    if unknown:
        raise ValueError(f"no layer {unknown[0]!r}; there are {', '.join(LAYERS)}")
    size = shrunk_size(relit.image.shape[:2], longest_side)
    layers = {"RGB": _sized(relit.image, size)}
    if relit.alpha is not None:
        premultiplied = np.dstack([relit.image * relit.alpha[..., None], relit.alpha])
        layers = {"RGBA": _sized(premultiplied, size)}
    for name in wanted:
        layer = _layer(relit, name, size)
        if layer is not None:
            layers[name] = layer
    return layers


def shrunk_size(size: tuple[int, int], longest_side: int | None) -> tuple[int, int]:
    """(height, width) of a picture shrunk so that no side is longer; never enlarged."""
    height, width = size
    if longest_side is None or max(size) <= longest_side:
        return height, width
    scale = longest_side / max(size)
    return max(1, round(height * scale)), max(1, round(width * scale))


def shrunk_picture(relit: Relit, longest_side: int | None) -> tuple[np.ndarray, np.ndarray | None]:
    """Image (H, W, 3) linear, not premultiplied, and alpha (H, W) or None, no side longer than asked."""
    size = shrunk_size(relit.image.shape[:2], longest_side)
    if relit.alpha is None:
        return _sized(relit.image, size), None
    alpha = _sized(relit.alpha, size)
    colour = _sized(relit.image * relit.alpha[..., None], size) / np.maximum(alpha, 1e-4)[..., None]
    return np.ascontiguousarray(colour), alpha


def _layer(relit: Relit, name: str, size: tuple[int, int]) -> np.ndarray | None:
    if name in ("matte", "background"):
        if relit.matte is None:
            return None
        behind = relit.matte if name == "matte" else relit.image * (1.0 - relit.matte)[..., None]
        return _sized(behind, size)
    channel = relit.channels.get(name)
    if channel is None or relit.window is None:
        return None
    x0, y0, x1, y1 = relit.window
    height, width = relit.image.shape[:2]
    scale = size[1] / width
    crop = Crop((x0 + x1) / 2 * scale, (y0 + y1) / 2 * scale, (x1 - x0) * scale)
    if name == "parsing":
        return _nearest(channel, crop, size)
    canvas = np.zeros((*size, *channel.shape[2:]), np.float32)
    placed = paste_crop(canvas, channel, crop, np.ones((2, 2), np.float32))
    if name == "normal":
        length = np.linalg.norm(placed, axis=2, keepdims=True)
        return placed / np.maximum(length, 1e-6) * (length > 0.25)
    return np.maximum(placed, 0.0)


def _nearest(labels: np.ndarray, crop: Crop, size: tuple[int, int]) -> np.ndarray:
    scale = crop.side / labels.shape[0]
    x0, y0 = crop.window[:2]
    # Pixel centres: i + 0.5 in the one is (i + 0.5) * scale + x0 in the other.
    place = np.float32([[scale, 0.0, x0 + 0.5 * scale - 0.5], [0.0, scale, y0 + 0.5 * scale - 0.5]])
    flags = cv2.INTER_NEAREST
    return cv2.warpAffine(labels.astype(np.float32), place, (size[1], size[0]), flags=flags)


def _sized(image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    if image.shape[:2] == size:
        return np.asarray(image, np.float32)
    return resize_area(image, size)
