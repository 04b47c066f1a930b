"""What photos come in, the frame of a print or the page of a screenshot: no part of anybody who is cut off by it."""

from __future__ import annotations

import math
from collections.abc import Callable

import cv2
import numpy as np

FLAT, STEP = 6 / 255, 16 / 255
"""sRGB values: within the first of its colour is a frame, a page or a filled corner, beyond the second surely
picture."""
_ALIKE, _LEAST_LINE, _LEAST_BESIDE = 0.98, 0.4, 0.2
"""Shares of a row that are frame in a frame, and picture just behind one: on one side at least, and on every other."""
_WIDEST_SHARE = 0.25
_ENDS = 0.008
_BLURRED_PX = 2
_RINGING_PX, _RINGING = 16, 0.9
"""JPEG's blocks carry the picture's edge that far into a frame, hardly anywhere by as much as is surely picture."""
_WIDEST_BAR, _PLAIN, _LINE, _LEAST_RUN_PX = 0.6, 0.75, 0.6, 3
"""Of a bar: its share of the picture at most, how much of it has its colour, and how much of the row just behind it
is surely picture; and before that row so many have its colour throughout."""
PLAINLY = _LINE

_NEAR_CELLS = 5
"""So many cells of a small copy about where a frame ends in it, it ends in the picture itself."""

_EVERY_PX = 7
"""Of a row, one pixel in so many is looked at."""

Inside = tuple[slice, slice]
"""Rows and columns of a picture."""


def inside_frame(shown: np.ndarray, least_beside: float = _LEAST_BESIDE) -> Inside | None:
    """What of a picture lies within a frame of one colour all around it, and within bars.

    Args:
        shown: (h, w, 3) sRGB, [0, 1].
        least_beside: what share of the row behind each side of a frame all around is surely picture. Of a wall in the
            frame's colour the default keeps what reaches as far as somebody does; `PLAINLY` leaves it a wall.

    Returns:
        None where there is neither.
    """
    everything = slice(0, shown.shape[0]), slice(0, shown.shape[1])
    rows, columns = everything if (framed := _inside_all_around(shown, least_beside)) is None else framed
    while any(bars := [_bar(side) for side in _sides(shown[rows, columns])]):
        top, bottom, left, right = bars
        left_over = slice(rows.start + top, rows.stop - bottom), slice(columns.start + left, columns.stop - right)
        if any(span.start >= span.stop for span in left_over):
            # Bars that meet have no picture between them: they are its own stripes.
            break
        rows, columns = left_over
    return None if (rows, columns) == everything else (rows, columns)


def shrunk_inside(inside: Inside, size: tuple[int, int], small: tuple[int, int]) -> Inside:
    """The cells of a copy of `small`, (height, width), that lie within a frame's inside in a picture of `size`."""
    return tuple(_cells(span, many, few) for span, many, few in zip(inside, size, small, strict=True))


def whole_inside(
    inside: Inside, small: tuple[int, int], size: tuple[int, int], shown: Callable[[Inside], np.ndarray]
) -> Inside:
    """What of a picture lies within a frame that is known in a copy of it, to a pixel.

    Args:
        inside: rows and columns of the copy.
        small, size: (height, width) of the copy, of the picture.
        shown: some rows and columns of the picture, (h, w, 3) sRGB.
    """
    scales = [many / few for few, many in zip(small, size, strict=True)]
    rows, columns = (
        slice(span.start * many // few, -(-span.stop * many // few))
        for span, few, many in zip(inside, small, size, strict=True)
    )

    def end(at: int, sign: int, scale: float, length: int, part: Callable[[slice], np.ndarray]) -> int:
        """Where a side ends, known to lie near `at`; its frame lies before that where the sign is 1."""
        if at in (0, length):
            return at
        reach = math.ceil(_NEAR_CELLS * scale)
        window = slice(max(at - reach, 0), min(at + reach, length))
        lines = part(window)[::sign]
        depth = _depth(np.abs(lines - np.median(lines[0], axis=0)).max(axis=2))
        if not 0 < depth < len(lines):
            return at
        # JPEG lets the picture ring in the last rows of a frame; the largest step is where it ends.
        first = max(depth - _BLURRED_PX, 1)
        depth = first + int(np.abs(np.diff(lines[first - 1 : depth + _BLURRED_PX + 1], axis=0)).mean((1, 2)).argmax())
        return window.start + depth if sign > 0 else window.stop - depth

    across = lambda window: shown((window, columns))  # noqa: E731
    down = lambda window: shown((rows, window)).swapaxes(0, 1)  # noqa: E731
    return (
        slice(*(end(at, sign, scales[0], size[0], across) for at, sign in ((rows.start, 1), (rows.stop, -1)))),
        slice(*(end(at, sign, scales[1], size[1], down) for at, sign in ((columns.start, 1), (columns.stop, -1)))),
    )


def going_on(part: np.ndarray, inside: Inside, size: tuple[int, int]) -> np.ndarray:
    """What lies within a frame (k, l) or (k, l, 3), its edge pixels continued over the frame to (height, width)."""
    (rows, columns), (height, width) = inside, size
    around = rows.start, height - rows.stop, columns.start, width - columns.stop
    return cv2.copyMakeBorder(np.ascontiguousarray(part), *around, cv2.BORDER_REPLICATE)


def picture_cells(picture: tuple[int, int, int, int], size: tuple[int, int], small: tuple[int, int]) -> Inside:
    """The same of x0, y0, x1, y1 in a picture of `size`."""
    x0, y0, x1, y1 = picture
    return shrunk_inside((slice(y0, y1), slice(x0, x1)), size, small)


def _cells(span: slice, many: int, few: int) -> slice:
    # Fractions of floats would round a whole side to a cell less.
    start = -(-span.start * few // many)
    return slice(start, max(span.stop * few // many, start + 1))


def _sides(shown: np.ndarray) -> tuple[np.ndarray, ...]:
    """A picture (h, w, 3) with its rows counted from the top and the bottom, and its columns as rows from each side."""
    return shown, shown[::-1], shown.swapaxes(0, 1), shown[:, ::-1].swapaxes(0, 1)


def _bar(side: np.ndarray) -> int:
    """How many of the first rows of a picture (n, m, 3) are a bar that lies across it; 0 where none does.

    A bar is of one colour, of a film's or of a page, but for what is written on it, and ends along a straight line
    from one side of the picture to the other. Nobody crosses that line: the rows before it are plain.
    """
    few = side[:, ::_EVERY_PX]
    first = few[: int(_WIDEST_BAR * len(few))]
    colours = np.median(first, axis=1)
    plain = (np.abs(first - colours[:, None]).max(axis=2) <= FLAT).mean(axis=1) >= _ALIKE
    goes_on = plain[1:] & (np.abs(np.diff(colours, axis=0)).max(axis=1) <= FLAT)
    ends = np.flatnonzero(plain & ~np.append(goes_on, False))
    return next((depth for last in ends[::-1] if (depth := _bar_to(few, last, colours[last]))), 0)


def _bar_to(side: np.ndarray, last: int, colour: np.ndarray) -> int:
    """How many rows of a picture (n, m, 3) a bar of a colour has whose last plain row that is; 0 where it is none."""
    away = np.abs(side[: last + _RINGING_PX + _BLURRED_PX + 1] - colour).max(axis=2)
    depth = last + 1 + _first_not(away[last + 1 : -_BLURRED_PX] <= STEP, _RINGING)
    run = (away[max(last + 1 - _LEAST_RUN_PX, 0) : last + 1] <= FLAT).mean(axis=1)
    whole = len(run) == _LEAST_RUN_PX and run.min() >= _ALIKE and (away[:depth] <= FLAT).mean() >= _PLAIN
    ends = (away[min(depth + _BLURRED_PX, len(away) - 1)] > STEP).mean() >= _LINE
    return int(depth) if whole and ends else 0


def _inside_all_around(shown: np.ndarray, least_beside: float) -> Inside | None:
    """What of a picture (h, w, 3) lies within a frame of one colour all around it; None where there is no frame.

    A frame ends along a straight line. A wall or a night about somebody is as plain, and does not; where a frame's
    colour goes on as such a wall, somebody's hair or hand may reach into it.
    """
    sides = _sides(shown)
    colours = np.array([np.median(side[0], axis=0) for side in sides])
    if np.ptp(colours, axis=0).max() > FLAT:
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
        _share_of_line(part[min(depth + _BLURRED_PX, len(part) - 1), span] > STEP)
        for part, depth, span in zip(away, depths, along, strict=True)
    ]
    if max(ends) < _LEAST_LINE:
        return None
    top, bottom, left, right = (depth if end >= least_beside else 0 for depth, end in zip(depths, ends, strict=True))
    return slice(top, height - bottom), slice(left, width - right)


def _share_of_line(picture: np.ndarray) -> float:
    """How much of the row behind a frame's side (n,) is surely picture: all of it where that begins at both its ends.

    A wall of the frame's colour would go on in one of them. What has that colour between them is somebody's white cap
    or a bright sky.
    """
    few = max(round(_ENDS * len(picture)), 2)
    return 1.0 if picture[:few].all() and picture[-few:].all() else float(picture.mean())


def _depth(away: np.ndarray) -> int:
    """How many rows from the first on (n, m) have the frame's colour, all but where a picture rings in it."""
    depth = _first_not(away <= FLAT, _ALIKE)
    return depth + _first_not(away[depth : min(depth + _RINGING_PX, len(away) - 1)] <= STEP, _RINGING)


def _first_not(alike: np.ndarray, least: float) -> int:
    """The first row (n, m) of which less than a share is alike; their number where there is none."""
    fulfilled = np.append(alike.mean(axis=1) >= least, False)
    return int(np.argmin(fulfilled))
