"""Contact sheets: labelled pictures in a grid."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from relight_core.imaging.colour import srgb_decode, srgb_encode

_GROUND = (24, 24, 26)
_INK = (226, 226, 226)
_GAP_PX = 8
_LABEL_PX = 22


def contact_sheet(pictures: Sequence[tuple[str, np.ndarray]], columns: int, cell_px: int) -> np.ndarray:
    """Lay labelled pictures out row by row, each shrunk or enlarged to fit its cell.

    Args:
        pictures: label and (h, w, 3) float sRGB in [0, 1], sizes as they come.
        columns: pictures in a row.
        cell_px: width and height of the room for a picture.

    Returns:
        (H, W, 3) uint8 sRGB.
    """
    rows = math.ceil(len(pictures) / columns)
    step = np.array([cell_px + _GAP_PX, cell_px + _LABEL_PX + _GAP_PX])
    width, height = (step * (columns, rows) + _GAP_PX).tolist()
    sheet = Image.new("RGB", (width, height), _GROUND)
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(size=14)
    for index, (label, srgb) in enumerate(pictures):
        left, top = (step * (index % columns, index // columns) + _GAP_PX).tolist()
        picture = _fitted(srgb, cell_px)
        sheet.paste(picture, (left + (cell_px - picture.width) // 2, top + (cell_px - picture.height) // 2))
        draw.text((left + cell_px // 2, top + cell_px + _LABEL_PX // 2), label, _INK, font, anchor="mm")
    return np.asarray(sheet)


def on_ground(srgb: np.ndarray, alpha: np.ndarray) -> np.ndarray:
    """A picture as it is seen before the sheet's ground.

    Args:
        srgb: (h, w, 3) float sRGB in [0, 1], not multiplied by its alpha.
        alpha: (h, w) in [0, 1].

    Returns:
        (h, w, 3) float32 sRGB.
    """
    ground = srgb_decode(np.array(_GROUND) / 255.0)
    share = alpha[..., None]
    return srgb_encode(srgb_decode(srgb) * share + ground * (1.0 - share))


def _fitted(srgb: np.ndarray, cell_px: int) -> Image.Image:
    image = Image.fromarray(np.uint8(np.clip(srgb, 0.0, 1.0) * 255.0 + 0.5))
    scale = cell_px / max(image.size)
    size = tuple(max(1, round(edge * scale)) for edge in image.size)
    return image.resize(size, Image.Resampling.LANCZOS)
