"""A hat drawn on a person: caps that flare, crowns high and low, brims, visors and boards, of any stuff.

Of baked heads few wear anything wide. An outline network that has seen little else takes the outer half of an
officer's cap, or a graduate's board, for something behind the head.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from relight_core.dataset.cutouts.around_face import axes_in_faces, coverage, laid_over, noise_over, white_beside
from relight_core.dataset.painting.texture import TexturePool

_ROW_OF_TEMPLES = -0.3
_PICTURED_SHARE, _WHITE_SHARE, _DARK_SHARE, _TWO_STUFFS_SHARE = 0.2, 0.2, 0.25, 0.4
_SOFT_SHARE, _BANDED_SHARE, _WOVEN_SHARE = 0.35, 0.5, 0.35
_KINDS = {"brimmed": 0.25, "visored": 0.15, "disc": 0.25, "boarded": 0.15, "crown alone": 0.2}
_FROM_BELOW_SHARE, _DISC_VISORED_SHARE = 0.6, 0.7
_SKULL, _OVER_HEAD = 0.72, 0.02
_LEAST_ABOVE_MIDDLE = 0.2
"""How far above the face's middle brims and visors end before it, in faces, so that eyes are seen."""


@dataclass(frozen=True)
class Seat:
    """Where a hat sits, and a picture's pixels as seen from there, in faces.

    Attributes:
        half: half the head's width there.
        skull: how far the skull rises above the seat.
        lowest: how far below the seat a hat may come down before the face.
        across, up: (S, S) how far right of and above the middle of the hat's foot pixels are, along its axes.
        foot: (S, S) how far up the foot's line lies, for pixels so far across.
        face_px: pixels to a face.
    """

    half: float
    skull: float
    lowest: float
    across: np.ndarray
    up: np.ndarray
    foot: np.ndarray
    face_px: float

    def coverage(self, inside: np.ndarray) -> np.ndarray:
        """See `around_face.coverage`."""
        return coverage(inside, self.face_px)


def with_hat(
    person: np.ndarray, centre: np.ndarray, face_px: float, pool: TexturePool, rng: np.random.Generator
) -> np.ndarray:
    """A person with a hat on, whose hair ends where the hat begins; unchanged where no head is in the picture.

    Args:
        person: (S, S, 4) premultiplied.
        centre: (x, y) of the face's middle, in pixels.
        face_px: the longer side of the face's bounding box.
    """
    seat = _seat(person, centre, face_px, rng)
    if seat is None:
        return person
    white = white_beside(person)
    stuff, trim, peak = (_stuff(white, len(person), pool, rng) for _ in range(3))
    trim = trim if rng.random() < _TWO_STUFFS_SHARE else stuff
    light = rng.normal(0, 0.3, 2)
    worn = person * (1 - seat.coverage(seat.up - seat.foot))
    kind = rng.choice(list(_KINDS), p=list(_KINDS.values()))
    if kind == "disc":
        band = rng.uniform(0.4, 0.9) * seat.skull
        worn = _laid(worn, _disc(seat, band, rng), stuff, 1 + light[0] * seat.across + light[1] * seat.up)
        worn = _with_crown(worn, seat, band, (trim, trim), light, pool, rng)
        return _with_visor(worn, seat, peak, rng) if rng.random() < _DISC_VISORED_SHARE else worn
    if kind == "boarded":
        height, from_below = seat.skull + rng.uniform(0.0, 0.15), rng.random() < _FROM_BELOW_SHARE
        worn = _with_board(worn, seat, height, (stuff, trim), rng) if from_below else worn
        worn = _with_crown(worn, seat, height, (stuff, trim), light, pool, rng)
        return worn if from_below else _with_board(worn, seat, height, (stuff, trim), rng)
    if kind == "brimmed":
        worn = _laid(worn, _brim(seat, rng), stuff, rng.uniform(0.45, 1.2) + light[0] * seat.across)
    worn = _with_crown(worn, seat, seat.skull + rng.beta(1.0, 2.5), (stuff, trim), light, pool, rng)
    return _with_visor(worn, seat, peak, rng) if kind == "visored" else worn


def _seat(person: np.ndarray, centre: np.ndarray, face_px: float, rng: np.random.Generator) -> Seat | None:
    """A line across the forehead, a little askew, as wide as the head is at the temples."""
    size, row = len(person), int(centre[1] + _ROW_OF_TEMPLES * face_px)
    x, y = np.broadcast_arrays(*axes_in_faces(size, centre, face_px))
    if not 0 <= row < size:
        return None
    seen = x[row][(person[row, :, 3] > 0.5) & (np.abs(x[row]) < 0.65)]
    if seen.size < 4:
        return None
    half = float(np.clip((seen[-1] - seen[0]) / 2, 0.33, 0.55)) * rng.uniform(0.98, 1.12)
    middle, high = float(np.clip((seen[-1] + seen[0]) / 2, -0.2, 0.2)), rng.uniform(0.2, 0.5)
    roll = np.radians(rng.normal(0, 5))
    across = (x - middle) * np.cos(roll) + (y + high) * np.sin(roll)
    up = (x - middle) * np.sin(roll) - (y + high) * np.cos(roll)
    foot = rng.uniform(-0.22, 0.12) * np.minimum((across / half) ** 2, 1.5)
    return Seat(half, _SKULL - high, high - _LEAST_ABOVE_MIDDLE, across, up, foot, face_px)


def _with_crown(
    person: np.ndarray,
    seat: Seat,
    height: float,
    stuffs: tuple[np.ndarray, np.ndarray],
    light: np.ndarray,
    pool: TexturePool,
    rng: np.random.Generator,
) -> np.ndarray:
    """The part above the foot: a cone, a dome, a cylinder, or a top that flares out over its band."""
    share = np.clip((seat.up - seat.foot) / height, 0, 1)
    flare = rng.uniform(-0.15, 0.1) if rng.random() < 0.5 else rng.uniform(0.1, 0.9)
    swell = np.sin(np.pi * share ** rng.uniform(0.6, 1.2))
    roundness = rng.uniform(1.2, 8)
    half = seat.half * (1 + flare * swell) * (1 - share**roundness) ** (1 / rng.uniform(1.6, roundness + 1))
    aside = seat.across - rng.normal(0, 0.15) * share * height
    noise = noise_over(pool, len(share), rng, 2)
    uneven = rng.uniform(0.02, 0.08) if rng.random() < _SOFT_SHARE else 0.0
    bent = cv2.GaussianBlur(noise, (0, 0), 0.06 * seat.face_px) * uneven
    inside = np.minimum(half - np.abs(aside), height + seat.foot - seat.up) + bent
    inside = np.minimum(inside, seat.up - seat.foot + max(_OVER_HEAD, 1 / seat.face_px))
    round_off = np.sqrt(np.clip(1 - (aside / np.maximum(half, 1e-3)) ** 2, 0, 1))
    shade = 0.7 + 0.35 * round_off + light[0] * aside / seat.half + light[1] * (share - 0.5)
    shade = shade * np.exp(_unevenness(noise, seat.face_px, rng))
    banded = rng.uniform(0.08, 0.35) if rng.random() < _BANDED_SHARE else 0.0
    colour = np.where((share < banded)[..., None], stuffs[1], stuffs[0])
    return _laid(person, seat.coverage(inside), colour, shade)


def _unevenness(noise: np.ndarray, face_px: float, rng: np.random.Generator) -> np.ndarray:
    """How much brighter the logarithm of a stuff is at each pixel: folds alone for smooth ones, or a weave too.

    Were all hats of a coarse weave, a network would take that for what tells them from walls.
    """
    folds = cv2.GaussianBlur(noise, (0, 0), face_px * 10 ** rng.uniform(-1.5, -0.5))
    folds = folds / max(float(folds.std()), 1e-6) * rng.uniform(0.0, 0.2)
    return folds + (rng.uniform(0.02, 0.2) * noise if rng.random() < _WOVEN_SHARE else 0.0)


def _brim(seat: Seat, rng: np.random.Generator) -> np.ndarray:
    """Coverage (S, S, 1) of a brim around the foot, from above or below, its sides turned up or down."""
    half = seat.half * rng.uniform(1.15, 2.7)
    thick = min(half * rng.uniform(0.04, 0.45), max(seat.lowest, 0.03))
    up = seat.up - rng.uniform(-0.02, 0.06) - rng.uniform(-0.35, 0.45) * half * (seat.across / half) ** 2
    return seat.coverage((1 - np.hypot(seat.across / half, up / thick)) * thick)


def _disc(seat: Seat, band: float, rng: np.random.Generator) -> np.ndarray:
    """Coverage (S, S, 1) of a stiff top behind a band that is so high: wider than it, and no lower than the skull."""
    middle = band * rng.uniform(0.5, 1.2)
    tall = max(seat.skull - middle, 0.1) + rng.uniform(0.0, 0.5)
    aside = seat.across - rng.normal(0, 0.15) * seat.half
    wide, askew = seat.half * rng.uniform(1.15, 2.0), rng.normal(0, 0.15)
    power = rng.uniform(1.8, 3.0)
    far = np.abs(aside / wide) ** power + np.abs((seat.up - middle - askew * aside) / tall) ** power
    return seat.coverage(np.minimum((1 - far ** (1 / power)) * min(tall, wide), seat.up - seat.foot))


def _with_visor(person: np.ndarray, seat: Seat, stuff: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A peak before the forehead, to one side where the head is turned."""
    half, reach = seat.half * rng.uniform(0.7, 1.1), min(rng.uniform(0.06, 0.35), max(seat.lowest, 0.04))
    aside = seat.across - rng.normal(0, 0.25) * seat.half
    hangs = reach * np.sqrt(np.clip(1 - (aside / half) ** 2, 0, 1))
    below = seat.up - seat.foot
    inside = np.minimum(np.minimum(0.02 - below, hangs + below), half - np.abs(aside))
    return _laid(person, seat.coverage(inside), stuff, rng.uniform(0.4, 1.1) - rng.uniform(0, 2) * seat.up)


def _with_board(
    person: np.ndarray, seat: Seat, height: float, stuffs: tuple[np.ndarray, np.ndarray], rng: np.random.Generator
) -> np.ndarray:
    """A square board on the crown, seen from a little below or above, and a tassel over its edge."""
    wide, deep = seat.half * rng.uniform(1.6, 2.9), rng.uniform(0.04, 0.4)
    level = height * rng.uniform(0.85, 1.0) + rng.uniform(-0.3, 0.3) * seat.across
    lean = rng.uniform(-0.6, 0.6)
    along, upward = seat.across - lean * (seat.up - level), seat.up - level
    inside = (1 - np.abs(along) / wide - np.abs(upward) / deep) * deep
    person = _laid(person, seat.coverage(inside), stuffs[0], rng.uniform(0.4, 1.3) + 0.3 * along)
    at = rng.choice([-1, 1]) * wide * rng.uniform(0.4, 1.0)
    hang, thick = rng.uniform(0.2, 1.1), rng.uniform(0.015, 0.05)
    below = np.interp(at, seat.across[len(person) // 2], level[len(person) // 2]) - seat.up
    cord = np.minimum(thick - np.abs(seat.across - at), np.minimum(below, hang - below))
    return _laid(person, seat.coverage(cord), stuffs[1], np.full_like(cord, rng.uniform(0.6, 1.2)))


def _stuff(white: float, size: int, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """Radiance (size, size, 3) of some cloth, straw or leather where white has so much."""
    kind = rng.random()
    if kind < _PICTURED_SHARE:
        albedo = cv2.resize(pool.picture(rng), (size, size), interpolation=cv2.INTER_AREA)
    elif kind < _PICTURED_SHARE + _WHITE_SHARE:
        albedo = np.full((size, size, 3), rng.uniform(0.55, 0.85) * np.exp(rng.normal(0, 0.06, 3)))
    elif kind < _PICTURED_SHARE + _WHITE_SHARE + _DARK_SHARE:
        albedo = np.full((size, size, 3), rng.uniform(0.01, 0.08) * np.exp(rng.normal(0, 0.2, 3)))
    else:
        albedo = np.full((size, size, 3), rng.beta(0.8, 1.2, 3))
    return (white * albedo).astype(np.float32)


def _laid(person: np.ndarray, alpha: np.ndarray, colour: np.ndarray, shade: np.ndarray) -> np.ndarray:
    """A person with a part laid over: coverage (S, S, 1), radiance (S, S, 3), shade (S, S)."""
    return laid_over(person, alpha, colour * np.clip(shade, 0.08, 2.0)[..., None]).astype(np.float32)
