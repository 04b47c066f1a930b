"""Painted skins in the head model's texture tiles, as a file beside the baked heads."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from relight_core.dataset.archive import read_arrays
from relight_core.errors import InputError
from relight_core.imaging.colour import srgb_decode_integers
from relight_core.imaging.files import whole_file

FILE_NAME = "skins.npz"
_VERSION = 1
_ARRAYS = ("version", "names", "fine", "smooth")
_MEND = "delete it and run 'relight dataset skins' again"
_REMAP_WIDTH = 1024  # cv2.remap takes at most 32,766 rows or columns


@dataclass(frozen=True)
class SkinTextures:
    """N skins; the first tile of each is the face, the second the back of the head and the neck.

    Attributes:
        fine: (N, 2, T, T, 3) uint8 sRGB, row 0 is v = 1.
        smooth: (N, 2, t, t, 3) uint8 sRGB: the same skins without what is smaller than about a centimetre.
    """

    names: tuple[str, ...]
    fine: np.ndarray
    smooth: np.ndarray

    def colour(self, number: int, uv: np.ndarray, on_back: np.ndarray) -> np.ndarray:
        """Linear reflectance (P, 3) of a skin at (P, 2) coordinates; `on_back` (P,) bool picks the second tile."""
        return _in_tiles(self.fine[number], uv, on_back)

    def smooth_colour(self, number: int, uv: np.ndarray, on_back: np.ndarray) -> np.ndarray:
        """`colour` without detail."""
        return _in_tiles(self.smooth[number], uv, on_back)

    def tone(self, number: int) -> np.ndarray:
        """Mean linear reflectance (3,) of the middle of the face."""
        side = self.smooth.shape[2]
        middle = self.smooth[number, 0, side // 4 : side * 3 // 4, side // 4 : side * 3 // 4]
        return srgb_decode_integers(middle).mean((0, 1))


def _in_tiles(tiles: np.ndarray, uv: np.ndarray, on_back: np.ndarray) -> np.ndarray:
    """Bilinear linear colours (P, 3) from two tiles (2, T, T, 3) uint8; neither tile bleeds into the other."""
    size, count = tiles.shape[1], len(uv)
    rows = -(-count // _REMAP_WIDTH)
    if count == 0:
        return np.empty((0, 3), np.float32)
    x, y = np.zeros((2, rows * _REMAP_WIDTH), np.float32)
    x[:count] = np.clip(uv[:, 0] * size - 0.5, 0, size - 1)
    y[:count] = np.clip((1 - uv[:, 1]) * size - 0.5, 0, size - 1) + size * on_back
    stacked = srgb_decode_integers(tiles.reshape(2 * size, size, 3))
    shape = (rows, _REMAP_WIDTH)
    return cv2.remap(stacked, x.reshape(shape), y.reshape(shape), cv2.INTER_LINEAR).reshape(-1, 3)[:count]


def write_skins(folder: Path, skins: SkinTextures) -> Path:
    """Store skins beside the heads of a folder; training picks them up from there."""
    path = folder / FILE_NAME
    with whole_file(path) as beside, open(beside, "wb") as file:
        np.savez_compressed(
            file,
            version=np.int32(_VERSION),
            names=np.array(skins.names),
            fine=skins.fine,
            smooth=skins.smooth,
        )
    return path


def load_skins(folder: Path) -> SkinTextures | None:
    """The skins beside the heads of a folder, None where there are none; InputError for a damaged file."""
    path = Path(folder) / FILE_NAME
    if not path.exists():
        return None
    data = read_arrays(path, _ARRAYS, "a file of skins", _MEND)
    names, fine, smooth = (data[name] for name in ("names", "fine", "smooth"))
    sound = names.ndim == 1 and all(_are_tiles(tiles, len(names)) for tiles in (fine, smooth))
    if data["version"].tolist() != _VERSION or not sound:
        raise InputError(f"{path}: skins of another version or shape; {_MEND}")
    return SkinTextures(tuple(str(name) for name in names), fine, smooth)


def _are_tiles(tiles: np.ndarray, count: int) -> bool:
    """Whether an array has two square tiles of colours for each of some skins, and there are any."""
    return tiles.size > 0 and tiles.dtype == np.uint8 and tiles.shape == (count, 2, *tiles.shape[2:3] * 2, 3)
