"""The plain frame that some photos come in, of a print or a card: no part of anybody who is cut off by it."""

from __future__ import annotations

import numpy as np

_FLAT, _STEP = 6 / 255, 16 / 255
"""sRGB values: within the first of its colour is frame, beyond the second surely picture."""
_ALIKE, _LEAST_LINE, _LEAST_BESIDE = 0.98, 0.4, 0.2
"""Shares of a row that are frame in a frame, and picture just behind one: on one side at least, and on every other."""
_WIDEST_SHARE = 0.25
_BLURRED_PX = 2
_RINGING_PX, _RINGING = 16, 0.9
"""JPEG's blocks carry the picture's edge that far into a frame, hardly anywhere by as much as is surely picture."""


def inside_frame(shown: np.ndarray) -> tuple[slice, slice] | None:
    """What of a picture lies within a frame of one colour all around it.

    A frame ends along a straight line. A wall or a night about somebody is as plain, and does not; where a frame's
    colour goes on as such a wall, somebody's hair or hand may reach into it.

    Args:
        shown: (h, w, 3) sRGB, [0, 1].

    Returns:
        Rows and columns; None where there is no frame.
    """
    sides = shown, shown[::-1], shown.swapaxes(0, 1), shown[:, ::-1].swapaxes(0, 1)
    colours = np.array([np.median(side[0], axis=0) for side in sides])
    if np.ptp(colours, axis=0).max() > _FLAT:
        return None
    away = [
        np.abs(side[: max(int(_WIDEST_SHARE * len(side)), 1)] - colour).max(axis=2)
        for side, colour in zip(sides, colours, strict=True)
    ]
    top, bottom, left, right = depths = [_depth(rows) for rows in away]
    if not all(0 < depth < len(rows) for depth, rows in zip(depths, away, strict=True)):
        return None
    height, width = shown.shape[:2]
    rows, columns = slice(top, height - bottom), slice(left, width - right)
    along = columns, columns, rows, rows
    ends = [
        (part[min(depth + _BLURRED_PX, len(part) - 1), span] > _STEP).mean()
        for part, depth, span in zip(away, depths, along, strict=True)
    ]
    if max(ends) < _LEAST_LINE:
        return None
    top, bottom, left, right = (depth if end >= _LEAST_BESIDE else 0 for depth, end in zip(depths, ends, strict=True))
    return slice(top, height - bottom), slice(left, width - right)


def _depth(away: np.ndarray) -> int:
    """How many rows from the first on (n, m) have the frame's colour, all but where a picture rings in it."""
    depth = _first_not(away <= _FLAT, _ALIKE)
    return depth + _first_not(away[depth : min(depth + _RINGING_PX, len(away) - 1)] <= _STEP, _RINGING)


def _first_not(alike: np.ndarray, least: float) -> int:
    """The first row (n, m) of which less than a share is alike; their number where there is none."""
    fulfilled = np.append(alike.mean(axis=1) >= least, False)
    return int(np.argmin(fulfilled))
