"""Damage tracking: which parts of the interface differ from the frame before, so that only those are redrawn.

With software OpenGL, redrawing a whole frame takes longer than finding out what need not be redrawn.
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
"""The draw commands that touch several rectangles are repeated for each."""

_WHOLE_SHARE = 0.8
"""If more than this share of the window differs, all of it is redrawn."""


@dataclass(frozen=True)
class DrawCommand:
    """A draw command of Dear ImGui: triangles with one texture, inside one rectangle.

    Attributes:
        clip: the scissor rectangle.
        texture: OpenGL's number for it.
        first, count: the range of the draw list's indices.
    """

    clip: Rect
    texture: int
    first: int
    count: int


@dataclass(frozen=True, eq=False)
class DrawList:
    """The draw list of one of Dear ImGui's windows.

    Attributes:
        owner: the window's name.
        vertices: (n, 5) uint32, the bits of the vertex buffer: x and y in framebuffer pixels and texture coordinates
            u and v, as float32, and the packed colour.
        indices: (m,) integers, three for a triangle.
        commands: in the order they are drawn.
    """

    owner: str
    vertices: np.ndarray
    indices: np.ndarray
    commands: tuple[DrawCommand, ...]

    def triangles(self, command: DrawCommand) -> np.ndarray:
        """(k, 3, 5) uint32: the vertices of each triangle."""
        return self.vertices[self.indices[command.first : command.first + command.count]].reshape(-1, 3, 5)


def damage(
    before: tuple[DrawList, ...], now: tuple[DrawList, ...], touched: dict[int, Part], size: tuple[int, int]
) -> list[Rect]:
    """Rectangles outside which the two frames look the same.

    Args:
        touched: by number, the textures whose contents have changed since the frame before, and in which part.
        size: of the framebuffer.
    """
    whole = [(0, 0, *size)]
    old, new = ({draw_list.owner: draw_list for draw_list in frame} for frame in (before, now))
    if len(old) < len(before) or len(new) < len(now):
        return whole
    if [name for name in old if name in new] != [name for name in new if name in old]:
        return whole
    rects: list[Rect] = []
    for name in old.keys() | new.keys():
        rects += _draw_lists_damage(old.get(name), new.get(name), touched)
    rects = _joined([rect for rect in (cut(rect, whole[0]) for rect in rects) if rect])
    while len(rects) > _MOST_RECTS:
        first, second = min(combinations(rects, 2), key=_waste)
        rects = [rect for rect in rects if rect not in (first, second)] + [_around([first, second])]
    return whole if sum(map(_area, rects)) > _WHOLE_SHARE * size[0] * size[1] else rects


def seen_in(
    rect: Rect, draw_lists: tuple[DrawList, ...], opaque: Collection[int]
) -> tuple[list[tuple[int, DrawCommand, Rect]], bool]:
    """The draw commands needed to redraw a rectangle.

    Args:
        opaque: numbers of the textures that are opaque.

    Returns:
        The commands in drawing order, each with its draw list's index and the part of the rectangle that it may touch.
        They begin with the last opaque picture that covers the whole rectangle, if there is one; and whether there is.
    """
    found, hides = [], False
    for index, draw_list in enumerate(draw_lists):
        for command in draw_list.commands:
            part = cut(command.clip, rect)
            if part is None:
                continue
            if part == rect and command.texture in opaque and _covers(draw_list.triangles(command), command, rect):
                found, hides = [], True
            found.append((index, command, part))
    return found, hides


def _covers(triangles: np.ndarray, command: DrawCommand, rect: Rect) -> bool:
    bounds = _bounds(triangles, command)
    return len(triangles) == 2 and bounds is not None and cut(rect, bounds) == rect


def _draw_lists_damage(old: DrawList | None, new: DrawList | None, touched: dict[int, Part]) -> list[Rect]:
    """`damage` of one window; None stands for one that is not in the frame."""
    if old and new and _same(old, new):
        commands = [command for command in new.commands if command.texture in touched]
        rects = [_part_bounds(new.triangles(command), command, touched[command.texture]) for command in commands]
        return [rect for rect in rects if rect]
    rects = []
    for was, now in zip_longest(old.commands if old else (), new.commands if new else ()):
        earlier, later = old.triangles(was) if was else None, new.triangles(now) if now else None
        if was and now and (was.clip, was.texture) == (now.clip, now.texture):
            if now.texture in touched:
                rects.append(_part_bounds(later, now, touched[now.texture]))
            earlier, later = _unlike(earlier, later)
        rects += [_bounds(earlier, was), _bounds(later, now)]
    return [rect for rect in rects if rect]


def _same(old: DrawList, new: DrawList) -> bool:
    pairs = (old.vertices, new.vertices), (old.indices, new.indices)
    return old.commands == new.commands and all(np.array_equal(was, now) for was, now in pairs)


def _unlike(old: np.ndarray, new: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The triangles that differ; if their numbers differ, all those between equal ones at both ends."""
    shorter = min(len(old), len(new))
    differ = (old[:shorter] != new[:shorter]).any(axis=(1, 2))
    if len(old) == len(new):
        return old[differ], new[differ]
    start = int(differ.argmax()) if differ.any() else shorter
    backwards = (old[::-1][: shorter - start] != new[::-1][: shorter - start]).any(axis=(1, 2))
    end = int(backwards.argmax()) if backwards.any() else shorter - start
    return old[start : len(old) - end], new[start : len(new) - end]


def _bounds(triangles: np.ndarray | None, command: DrawCommand | None) -> Rect | None:
    if triangles is None or not len(triangles):
        return None
    places = np.ascontiguousarray(triangles[..., :2]).view(np.float32).reshape(-1, 2)
    (x0, y0), (x1, y1) = np.floor(places.min(axis=0)), np.ceil(places.max(axis=0))
    far = 1e6
    x0, y0, x1, y1 = (int(min(max(edge, -far), far)) for edge in (x0, y0, x1, y1))
    return cut((x0, y0, x1, y1), command.clip)


def _part_bounds(triangles: np.ndarray, command: DrawCommand, part: Part) -> Rect | None:
    """Where a part of the texture is visible; for anything but one upright rectangle, the whole command's bounds."""
    if part == WHOLE or len(triangles) != 2:
        return _bounds(triangles, command)
    (x0, y0, u0, v0), (x1, y1, u1, v1) = triangles[0, ::2, :4].copy().view(np.float32).tolist()
    if not (x0 < x1 and y0 < y1 and u0 < u1 and v0 < v1):
        return _bounds(triangles, command)
    left, right = (x0 + (edge - u0) / (u1 - u0) * (x1 - x0) for edge in (part[0], part[2]))
    top, bottom = (y0 + (edge - v0) / (v1 - v0) * (y1 - y0) for edge in (part[1], part[3]))
    # One pixel more on each side, which linear filtering blends with.
    narrow = math.floor(left) - 1, math.floor(top) - 1, math.ceil(right) + 1, math.ceil(bottom) + 1
    whole = _bounds(triangles, command)
    return whole and cut(narrow, whole)


def cut(rect: Rect, by: Rect) -> Rect | None:
    """The intersection of two rectangles; None if it is empty."""
    x0, y0, x1, y1 = max(rect[0], by[0]), max(rect[1], by[1]), min(rect[2], by[2]), min(rect[3], by[3])
    return (x0, y0, x1, y1) if x0 < x1 and y0 < y1 else None


def _joined(rects: list[Rect]) -> list[Rect]:
    """The rectangles, those merged whose bounding box is no larger than they are together."""
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
    """By how many pixels the bounding box of both is larger than they are together."""
    return _area(_around(list(pair))) - sum(map(_area, pair))


def _area(rect: Rect) -> int:
    return (rect[2] - rect[0]) * (rect[3] - rect[1])
