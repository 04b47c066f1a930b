"""Strokes of the brush as a session's JSON holds them: their points as SVG has those of a polyline, "x,y x,y"."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from app.document.json_fields import Fields
from relight_core.errors import InputError
from relight_core.pipeline.per_photo.brush import (
    FARTHEST_PX,
    MOST_POINTS,
    MOST_STROKES,
    THINNEST_PX,
    WIDEST_PX,
    BrushStroke,
)

_KEY = "brush_strokes"


def brush_strokes_content(strokes: Sequence[BrushStroke]) -> list[dict]:
    """Strokes as JSON holds them."""
    return [
        {
            "adds": stroke.adds,
            "radius_px": stroke.radius_px,
            "points": " ".join(f"{x:.10g},{y:.10g}" for x, y in stroke.points),
        }
        for stroke in strokes
    ]


def read_brush_strokes(fields: Fields, path: Path) -> tuple[BrushStroke, ...]:
    """The strokes in a session.

    Args:
        path: of the session, for messages.

    Raises:
        InputError: a stroke that is none.
    """
    if fields.is_nothing(_KEY):
        return ()
    return tuple(_stroke(group, path) for group in fields.groups(_KEY, MOST_STROKES))


def _stroke(fields: Fields, path: Path) -> BrushStroke:
    adds, radius_px = fields.flag("adds"), fields.number("radius_px", THINNEST_PX, WIDEST_PX, 0.0)
    places = fields.text("points").split()
    fields.finish()
    if not 0 < len(places) <= MOST_POINTS:
        raise InputError(
            f"{path}: a stroke of the brush has no points, or too many; mend the file or delete its {_KEY}"
        )
    return BrushStroke(tuple(_point(place, path) for place in places), radius_px, adds)


def _point(text: str, path: Path) -> tuple[float, float]:
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        x = y = math.nan
    if not (abs(x) <= FARTHEST_PX and abs(y) <= FARTHEST_PX):
        raise InputError(f"{path}: a stroke's point {text:.40} is no place; mend the file or delete its {_KEY}")
    return x, y
