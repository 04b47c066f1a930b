"""Whether a picture is black and white or toned: of one colour for each brightness, its tone."""

from __future__ import annotations

import cv2
import numpy as np

_LEVELS = 48
_STEPS = 4 * 255
"""Of brightness in a unit of code: two colours that differ by less are as bright as each other."""

_COLOURLESS = 5 / 255
_STRAY_SHARE = 0.015
"""Of all pixels, those that compression and clipping may take off the tone."""

_PLAIN_COLOUR = 12 / 255

_BLOCK_PX = 17
"""JPEG blurs and coarsens chroma in blocks of 16 pixels, whose means it keeps: a strong tone is off at every edge, by
as much to one side as to the other."""

_COLOURED_SHARE = 0.2
"""Of a tile's pixels, those whose plain colour makes it a coloured one: a small face, not an edge."""

_EVERY, _COARSE_BLOCK_PX, _PLAINLY_OFF_SHARE = 4, 5, 0.06
"""Where so much of every 4th pixel, down and across, is off the tone, the rest won't tell otherwise: most photos are in
colour, and known by that in a tenth of the time."""

_EXACTLY_GREY, _MOST = 1.25 / 255, 0.6
"""Off green, on average over a block: of seventeen colour photos' faces, up to 0.5 % are as grey, foggy ones 5 %."""

_NEAR_BLACK, _NEAR_WHITE, _LEAST_TELLING = 0.12, 0.97, 0.2

_CELLS = 32
_LEAST_CELL_PX = 4
_SRGB_OFFSET = 0.055
"""sRGB's codes are a power of light less this, so a tone's distance from grey grows with code plus this."""


def is_monochrome(codes: np.ndarray, counted: np.ndarray | None = None) -> bool:
    """Whether a picture has no colour but a tone's.

    Colour may be spread thinly or stand in one small place, as a face does before a grey wall: there is none only
    where hardly a pixel is off the tone and no tile of a coarse grid has many that are plainly off it.

    Args:
        codes: (H, W, 3) sRGB, up to 1; below 0 what lies outside Rec.709.
        counted: (H, W) which pixels have a say; None for all.
    """
    counted = np.ones(codes.shape[:2], bool) if counted is None else counted
    few = (slice(None, None, _EVERY),) * 2
    at_a_glance, _ = _off_tone(codes[few], counted[few], _COARSE_BLOCK_PX)
    if (at_a_glance > _COLOURLESS).sum() > _PLAINLY_OFF_SHARE * counted[few].sum():
        return False
    off, most = _off_tone(codes, counted, _BLOCK_PX)
    if (off > _COLOURLESS).sum() > _STRAY_SHARE * counted.sum():
        return False
    return _densest_share(off > most) <= _COLOURED_SHARE


def is_grey(codes: np.ndarray) -> bool:
    """Whether a picture has no colour at all, not even a tone's, but for what compression adds.

    Args:
        codes: (H, W, 3) sRGB.
    """
    return bool((_off_grey(codes) > _COLOURLESS).mean() <= _STRAY_SHARE)


def is_mostly_grey(codes: np.ndarray) -> bool:
    """Whether most of a picture has exactly no colour, as only black-and-white photos have, the rest any.

    In neither black nor white would a colour show, so they have no say. A picture of them alone is not grey.

    Args:
        codes: (H, W, 3) sRGB.
    """
    brightness = codes.mean(-1)
    telling = (brightness > _NEAR_BLACK) & (brightness < _NEAR_WHITE)
    grey = telling & (_off_grey(codes) <= _EXACTLY_GREY)
    return bool(telling.mean() > _LEAST_TELLING and grey.sum() >= _MOST * telling.sum())


def _off_grey(codes: np.ndarray) -> np.ndarray:
    """How far red or blue is from green, (H, W), on average over a block: noise and compression cancel out there."""
    means = cv2.blur(np.ascontiguousarray(_beside_green(codes)), (_COARSE_BLOCK_PX, _COARSE_BLOCK_PX))
    return np.abs(means).max(-1)


def _beside_green(codes: np.ndarray) -> np.ndarray:
    """(..., 2) red and blue less green."""
    return (codes - codes[..., 1:2])[..., [0, 2]]


def _off_tone(codes: np.ndarray, counted: np.ndarray, block_px: int) -> tuple[np.ndarray, np.ndarray]:
    """How far each pixel (H, W) is off a tone over a block, 0 where it isn't counted, and what is plainly a colour."""
    off, most = np.zeros(counted.shape, np.float32), np.full(counted.shape, np.float32(_PLAIN_COLOUR))
    if counted.any():
        beside_tone, most[counted] = _beside_tone(codes[counted])
        off[counted] = np.abs(_block_means(beside_tone, counted, block_px)).max(1)
    return off, most


def _toned_levels(brightness: np.ndarray, colour: np.ndarray) -> tuple[list[np.ndarray], np.ndarray]:
    """The pixels by brightness in up to 48 levels of as many each, and the colour (L, 2) that each level has.

    Pixels of one brightness may fall into two levels, sorted by nothing but their order or what rounding makes of a
    sum. So that two colours never pass there for the tones of two levels, all of them have a say in either.
    """
    steps = np.round(brightness * _STEPS)
    order = np.argsort(steps, kind="stable")
    levels = np.array_split(order, min(_LEVELS, len(order)))
    starts = np.searchsorted(steps, [steps[level[0]] for level in levels], "left", sorter=order)
    stops = np.searchsorted(steps, [steps[level[-1]] for level in levels], "right", sorter=order)
    known: dict[tuple[int, int], np.ndarray] = {}
    for span in zip(starts, stops, strict=True):
        if span not in known:
            known[span] = np.median(colour[order[slice(*span)]], 0)
    return levels, np.array([known[span] for span in zip(starts, stops, strict=True)])


def _beside_tone(flat: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What a tone that goes smoothly from level to level, and on beyond them, leaves of pixels' colours.

    Args:
        flat: (N, 3) codes.

    Returns:
        (N, 2) red and blue less green, less the tone's, and (N,) from where on that is plainly a colour.
    """
    brightness, colour = np.maximum(flat.sum(1), 0), _beside_green(flat)
    levels, tones = _toned_levels(brightness, colour)
    middles = np.array([np.median(brightness[level]) for level in levels])
    within = np.clip(brightness, middles[0], middles[-1])
    growth = (brightness + 3 * _SRGB_OFFSET) / (within + 3 * _SRGB_OFFSET)
    # A tone that is known from the dark alone is known to half a code, which grows with it.
    most = _PLAIN_COLOUR + np.maximum(growth - 1, 0) * (0.5 / 255)
    tone = np.stack([growth * np.interp(within, middles, tones[:, i]) for i in range(2)], axis=-1)
    return colour - tone, most


def _block_means(values: np.ndarray, counted: np.ndarray, block_px: int) -> np.ndarray:
    """(N, 2) means about each of the N counted pixels (H, W), over a block of those."""
    spread = np.zeros((*counted.shape, 3), np.float32)
    spread[counted] = np.column_stack([values, np.ones(len(values))])
    means = cv2.blur(spread, (block_px, block_px), borderType=cv2.BORDER_CONSTANT)[counted]
    return means[:, :2] / means[:, 2:]


def _densest_share(marked: np.ndarray) -> float:
    """Of (H, W) booleans, the largest share in a tile; tiles overlap by half, so that a small spot lies within one."""
    starts = [np.linspace(0, side, _cells(side) + 1).astype(int) for side in marked.shape]
    counts = np.add.reduceat(np.add.reduceat(marked, starts[0][:-1], 0, np.int64), starts[1][:-1], 1)
    areas = np.multiply.outer(*(np.diff(edges) for edges in starts))
    return float((_two_by_two(counts) / _two_by_two(areas)).max())


def _cells(side_px: int) -> int:
    return min(max(side_px // _LEAST_CELL_PX, 1), _CELLS)


def _two_by_two(cells: np.ndarray) -> np.ndarray:
    rows = cells[:-1] + cells[1:] if len(cells) > 1 else cells
    return rows[:, :-1] + rows[:, 1:] if rows.shape[1] > 1 else rows
