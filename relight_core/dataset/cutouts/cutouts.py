"""People cut out of their pictures, and put into others: bigger, smaller, with a body below the bust."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from relight_core.dataset.painting.texture import TexturePool
from relight_core.face.parsing import FACE_LABELS, INDEX

_FRIZZ_SHARE = 0.6
_NEW_CLOTHES_SHARE = 0.4
_CUT_SHARE = 0.02
_SHOULDERS_IN_FACES = 1.5
_SMALLEST_FACE_PX = 8


@dataclass(frozen=True)
class Cutout:
    """A lit person without a background.

    Attributes:
        premultiplied: (S, S, 4) float32, linear radiance as a camera exposes it times coverage, and coverage.
        centre: (x, y) of the face in pixels.
        face_px: the longer side of the face's bounding box.
        bust_row: where the bust ends; below, a body has to be added.
        known: left, top, right, bottom: how far from the face's middle the person is known, in faces; inf
            where the picture's border cuts through nobody, and below where shoulders are seen.
    """

    premultiplied: np.ndarray
    centre: tuple[float, float]
    face_px: float
    bust_row: int
    known: tuple[float, float, float, float]

    def mirrored(self) -> Cutout:
        """The same in a mirror."""
        left, top, right, bottom = self.known
        flipped = np.ascontiguousarray(self.premultiplied[:, ::-1])
        centre = flipped.shape[1] - self.centre[0], self.centre[1]
        return Cutout(flipped, centre, self.face_px, self.bust_row, (right, top, left, bottom))


def cut_out(radiance: np.ndarray, covered: np.ndarray, label: np.ndarray, rng: np.random.Generator) -> Cutout | None:
    """A person from a rendering; None where no face is in it.

    Hair gets a ragged edge most of the time: rendered hair ends in smooth shells.

    Args:
        radiance: (S, S, 3) linear, as a camera exposes it.
        covered: (S, S) bool.
        label: (S, S) integers, `face.parsing.CLASSES`.
    """
    face = np.isin(label, FACE_LABELS) & covered
    rows, columns = np.flatnonzero(face.any(1)), np.flatnonzero(face.any(0))
    if min(len(rows), len(columns)) < _SMALLEST_FACE_PX:
        return None
    both = np.dstack([radiance * covered[..., None], covered]).astype(np.float32)
    if rng.random() < _FRIZZ_SHARE:
        both = _frizzed(both, label == INDEX["hair"], rng)
    x, y = float(columns[0] + columns[-1] + 1) / 2, float(rows[0] + rows[-1] + 1) / 2
    face_px = float(max(rows[-1] - rows[0], columns[-1] - columns[0]) + 1)
    reach = ((covered[:, 0], x), (covered[0], y), (covered[:, -1], len(covered) - x))
    known = [far / face_px if border.mean() > _CUT_SHARE else np.inf for border, far in reach]
    bust_row = _bust_row(covered, int(rows[-1]))
    shoulders = covered[bust_row].sum() > _SHOULDERS_IN_FACES * face_px or bust_row > rows[-1] + 0.4 * face_px
    known.append(np.inf if shoulders else (len(covered) - 3 - y) / face_px)
    return Cutout(both, (x, y), face_px, bust_row, tuple(known))


def _bust_row(covered: np.ndarray, chin: int) -> int:
    """The last row in which a bust is about as wide as it becomes: models of busts end in a curve."""
    wide = covered[chin:].sum(1)
    return min(chin + int(np.flatnonzero(wide >= 0.95 * wide.max())[-1]), len(covered) - 3)


def _frizzed(both: np.ndarray, hair: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Curls and strands at the edge of hair: there the picture is bent by noise of a few pixels."""
    size = len(both)
    deviation = size * rng.uniform(0.01, 0.03)
    near = cv2.GaussianBlur(hair.astype(np.float32), (0, 0), deviation)
    strength = np.clip(3 * near, 0, 1) * size * 10 ** rng.uniform(-2.3, -1.5)
    noise = rng.standard_normal((2, size, size)).astype(np.float32)
    fine = [cv2.GaussianBlur(n, (0, 0), rng.uniform(1.0, 4.0)) for n in noise]
    y, x = np.mgrid[:size, :size].astype(np.float32)
    moved = [place + strength * f / max(float(f.std()), 1e-6) for place, f in zip((x, y), fine, strict=True)]
    return cv2.remap(both, *moved, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def place(
    cutout: Cutout,
    size: int,
    centre: np.ndarray,
    face_px: float,
    pool: TexturePool,
    rng: np.random.Generator,
) -> np.ndarray:
    """Put a person into a picture of size x size pixels; a bust gets a body.

    Args:
        centre: (x, y) where the face's middle goes, in pixels.
        face_px: how large the face becomes.

    Returns:
        (size, size, 4) premultiplied, as of `Cutout`.
    """
    scale, source = face_px / cutout.face_px, cutout.premultiplied
    if scale < 1:
        source = cv2.GaussianBlur(source, (0, 0), max(0.45 / scale - 0.2, 0.25))
    shift = np.asarray(centre) - scale * np.asarray(cutout.centre)
    # OpenCV counts from the middle of the first pixel.
    matrix = np.column_stack([np.eye(2) * scale, shift + 0.5 * (scale - 1)])
    placed = cv2.warpAffine(source, matrix, (size, size), flags=cv2.INTER_LINEAR)
    return _with_body(placed, int(shift[1] + scale * cutout.bust_row), face_px, pool, rng)


def _with_body(placed: np.ndarray, row: int, face_px: float, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """A trunk below the row at which a bust ends, of its own stuff or another."""
    size = len(placed)
    if not 0 < row < size:
        return placed
    columns = np.flatnonzero(placed[row, :, 3] > 0.5)
    if len(columns) < 4:
        return placed
    down = np.arange(size - row, dtype=np.float32)
    wide = face_px * rng.uniform(1.0, 1.9)
    grown = 1 - np.exp(-down / (face_px * rng.uniform(0.1, 0.5)))
    tapering = -rng.uniform(0, 0.15) * down
    wobble = np.interp(down, np.linspace(0, size, 12), rng.normal(0, 0.06 * face_px, 12)) * np.clip(down / 20, 0, 1)
    beyond = grown * max(wide - (columns[-1] - columns[0]) / 2, 0) + tapering - wobble
    left, right = columns[0] - beyond, columns[-1] + beyond
    x = np.arange(size, dtype=np.float32)
    alpha = np.clip(np.minimum(x[None] - left[:, None], right[:, None] - x[None]) + 0.5, 0, 1)
    colour = _stuff_of_body(placed, row, columns, (left, right), pool, rng)
    body = placed.copy()
    body[row:] = np.dstack([colour * alpha[..., None], alpha])
    return body


def _stuff_of_body(
    placed: np.ndarray,
    row: int,
    columns: np.ndarray,
    edges: tuple[np.ndarray, np.ndarray],
    pool: TexturePool,
    rng: np.random.Generator,
) -> np.ndarray:
    """(h, S, 3): what the last rows of the bust show, stretched to the body's width, with folds; or new clothes."""
    size, count = placed.shape[1], len(edges[0])
    last = placed[max(row - 3, 0) : row + 1].mean(0)
    edge = last[:, :3] / np.maximum(last[:, 3:], 0.3)
    x = np.arange(size, dtype=np.float32)[None]
    within = np.clip((x - edges[0][:, None]) / np.maximum(edges[1] - edges[0], 1)[:, None], 0, 1)
    source = (columns[0] + within * (columns[-1] - columns[0])).astype(np.intp)
    colour = edge[source]
    down = (np.arange(count, dtype=np.float32) / size)[:, None, None]
    folds = cv2.resize(pool.noise(rng), (size, size))[:count, :, None]
    colour = colour * np.exp(rng.uniform(0.05, 0.35) * folds * np.clip(8 * down, 0, 1))
    if rng.random() < _NEW_CLOTHES_SHARE:
        level = max(float(edge[columns].mean()), 0.02)
        other = cv2.resize(pool.picture(rng), (size, size))[:count] if rng.random() < 0.4 else rng.beta(0.8, 0.8, 3)
        turns_at = rng.uniform(0.0, 0.3)
        colour = np.where(down > turns_at, level * 2 * other * np.exp(0.25 * folds), colour)
    return colour.astype(np.float32)
