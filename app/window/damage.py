"""What of the interface differs from one frame to the next, so that only that is drawn again.

Where the processor draws, a frame that is drawn whole takes longer than one that finds out what it need not draw.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from itertools import combinations, zip_longest

import numpy as np

Rect = tuple[int, int, int, int]
"""x0, y0, x1, y1 in framebuffer pixels, y down; the last ones are outside."""

Part = tuple[float, float, float, float]
"""x0, y0, x1, y1 of a rectangle in a texture, as shares of its width and height."""

WHOLE: Part = (0.0, 0.0, 1.0, 1.0)

_MOST_RECTS = 8
"""Each repeats the calls that draw what it touches."""

_WHOLE_SHARE = 0.8
"""From this share of the window on it is drawn whole."""


@dataclass(frozen=True)
class Piece:
    """One draw call: triangles with one texture, inside one rectangle.

    Attributes:
        clip: nothing is drawn beyond it.
        texture: its number.
        first, count: which of the sheet's indices.
    """

    clip: Rect
    texture: int
    first: int
    count: int


@dataclass(frozen=True, eq=False)
class Sheet:
    """What one window of Dear ImGui lists.

    Attributes:
        owner: the window's name.
        vertices: (n, 5) uint32, as the bits of what the graphics get: x and y in framebuffer pixels as float32, then
            texel and colour.
        indices: (m,) integers, three for a triangle.
        pieces: in the order they are drawn.
    """

    owner: str
    vertices: np.ndarray
    indices: np.ndarray
    pieces: tuple[Piece, ...]

    def triangles(self, piece: Piece) -> np.ndarray:
        """(k, 3, 5) uint32: the vertices of each triangle."""
        return self.vertices[self.indices[piece.first : piece.first + piece.count]].reshape(-1, 3, 5)


def damage(
    before: tuple[Sheet, ...], now: tuple[Sheet, ...], touched: dict[int, Part], size: tuple[int, int]
) -> list[Rect]:
    """Rectangles outside which the two frames look the same.

    Args:
        touched: the textures whose contents are others than before, by number, and in which part of them.
        size: of the framebuffer.
    """
    whole = [(0, 0, *size)]
    old, new = ({sheet.owner: sheet for sheet in frame} for frame in (before, now))
    if len(old) < len(before) or len(new) < len(now):
        return whole
    if [name for name in old if name in new] != [name for name in new if name in old]:
        return whole
    rects: list[Rect] = []
    for name in old.keys() | new.keys():
        rects += _sheets_damage(old.get(name), new.get(name), touched)
    rects = _joined([rect for rect in (cut(rect, whole[0]) for rect in rects) if rect])
    while len(rects) > _MOST_RECTS:
        first, second = min(combinations(rects, 2), key=_waste)
        rects = [rect for rect in rects if rect not in (first, second)] + [_around([first, second])]
    return whole if sum(map(_area, rects)) > _WHOLE_SHARE * size[0] * size[1] else rects


def seen_in(
    rect: Rect, sheets: tuple[Sheet, ...], opaque: Collection[int]
) -> tuple[list[tuple[int, Piece, Rect]], bool]:
    """What has to be drawn of a rectangle.

    Args:
        opaque: numbers of the textures that nothing shines through.

    Returns:
        The pieces in the order they are drawn, each with its sheet's index and the part of the rectangle it may touch,
        from the last picture on that hides all before it; and whether there is such a picture.
    """
    found, hides = [], False
    for index, sheet in enumerate(sheets):
        for piece in sheet.pieces:
            part = cut(piece.clip, rect)
            if part is None:
                continue
            if part == rect and piece.texture in opaque and _covers(sheet.triangles(piece), piece, rect):
                found, hides = [], True
            found.append((index, piece, part))
    return found, hides


def _covers(triangles: np.ndarray, piece: Piece, rect: Rect) -> bool:
    bounds = _bounds(triangles, piece)
    return len(triangles) == 2 and bounds is not None and cut(rect, bounds) == rect


def _sheets_damage(old: Sheet | None, new: Sheet | None, touched: dict[int, Part]) -> list[Rect]:
    """As of `damage`, for one window; None is one that is not there."""
    if old and new and _same(old, new):
        pieces = [piece for piece in new.pieces if piece.texture in touched]
        rects = [_part_bounds(new.triangles(piece), piece, touched[piece.texture]) for piece in pieces]
        return [rect for rect in rects if rect]
    rects = []
    for was, now in zip_longest(old.pieces if old else (), new.pieces if new else ()):
        earlier, later = old.triangles(was) if was else None, new.triangles(now) if now else None
        if was and now and (was.clip, was.texture) == (now.clip, now.texture):
            if now.texture in touched:
                rects.append(_part_bounds(later, now, touched[now.texture]))
            earlier, later = _unlike(earlier, later)
        rects += [_bounds(earlier, was), _bounds(later, now)]
    return [rect for rect in rects if rect]


def _same(old: Sheet, new: Sheet) -> bool:
    pairs = (old.vertices, new.vertices), (old.indices, new.indices)
    return old.pieces == new.pieces and all(np.array_equal(was, now) for was, now in pairs)


def _unlike(old: np.ndarray, new: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The triangles that are not the same ones; where their number differs, all between equal ends."""
    shorter = min(len(old), len(new))
    differ = (old[:shorter] != new[:shorter]).any(axis=(1, 2))
    if len(old) == len(new):
        return old[differ], new[differ]
    start = int(differ.argmax()) if differ.any() else shorter
    backwards = (old[::-1][: shorter - start] != new[::-1][: shorter - start]).any(axis=(1, 2))
    end = int(backwards.argmax()) if backwards.any() else shorter - start
    return old[start : len(old) - end], new[start : len(new) - end]


def _bounds(triangles: np.ndarray | None, piece: Piece | None) -> Rect | None:
    if triangles is None or not len(triangles):
        return None
    places = np.ascontiguousarray(triangles[..., :2]).view(np.float32).reshape(-1, 2)
    (x0, y0), (x1, y1) = np.floor(places.min(axis=0)), np.ceil(places.max(axis=0))
    far = 1e6
    x0, y0, x1, y1 = (int(min(max(edge, -far), far)) for edge in (x0, y0, x1, y1))
    return cut((x0, y0, x1, y1), piece.clip)


def _part_bounds(triangles: np.ndarray, piece: Piece, part: Part) -> Rect | None:
    """Where a part of the texture is seen; for anything but one upright picture, all of the piece."""
    if part == WHOLE or len(triangles) != 2:
        return _bounds(triangles, piece)
    (x0, y0, u0, v0), (x1, y1, u1, v1) = triangles[0, ::2, :4].copy().view(np.float32).tolist()
    if not (x0 < x1 and y0 < y1 and u0 < u1 and v0 < v1):
        return _bounds(triangles, piece)
    left, right = (x0 + (edge - u0) / (u1 - u0) * (x1 - x0) for edge in (part[0], part[2]))
    top, bottom = (y0 + (edge - v0) / (v1 - v0) * (y1 - y0) for edge in (part[1], part[3]))
    # One more, for a blend with the neighbour.
    narrow = math.floor(left) - 1, math.floor(top) - 1, math.ceil(right) + 1, math.ceil(bottom) + 1
    whole = _bounds(triangles, piece)
    return whole and cut(narrow, whole)


def cut(rect: Rect, by: Rect) -> Rect | None:
    """What two rectangles share."""
    x0, y0, x1, y1 = max(rect[0], by[0]), max(rect[1], by[1]), min(rect[2], by[2]), min(rect[3], by[3])
    return (x0, y0, x1, y1) if x0 < x1 and y0 < y1 else None


def _joined(rects: list[Rect]) -> list[Rect]:
    """The same, with one around those that cost no less apart."""
    done: list[Rect] = []
    for rect in rects:
        while other := next((one for one in done if _waste((one, rect)) <= 0), None):
            done.remove(other)
            rect = _around([rect, other])
        done.append(rect)
    return done


def _around(rects: list[Rect]) -> Rect:
    x0, y0, x1, y1 = zip(*rects, strict=True)
    return min(x0), min(y0), max(x1), max(y1)


def _waste(pair: tuple[Rect, Rect]) -> int:
    """How much larger one rectangle around both is than they are."""
    return _area(_around(list(pair))) - sum(map(_area, pair))


def _area(rect: Rect) -> int:
    return (rect[2] - rect[0]) * (rect[3] - rect[1])
