"""Correcting who is person in the photo: what the brush over the picture and the commands do to the state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from app.engine.sources import PhotoSource
from relight_core.pipeline.per_photo.brush import (
    FARTHEST_PX,
    MOST_POINTS,
    MOST_STROKES,
    THINNEST_PX,
    WIDEST_PX,
    BrushStroke,
)

if TYPE_CHECKING:
    from app.ui.state import EditorState

SMALLEST_EM, LARGEST_EM = 0.2, 12.0
_SIZE_STEP = 1.25
_NO_POINT_WITHIN = 0.15
_DIGITS = 1

Point = tuple[float, float]


@dataclass
class BrushTool:
    """The brush over the picture.

    Attributes:
        is_open: it paints, and the outline is in sight.
        before: the photo as it was wished for when it was taken up.
        adds: it adds to the person; else it takes away.
        radius_em: half its width on the screen, in heights of the panels' text: zooming in makes it finer in the photo.
        painting: the stroke that the mouse is painting, if any.
        pane: in which of the viewport's panes it does so.
        shown: the strokes in the picture in sight.
        outline: the one that was in sight last.
    """

    is_open: bool = False
    before: PhotoSource | None = None
    adds: bool = True
    radius_em: float = 1.2
    painting: BrushStroke | None = None
    pane: int = 0
    shown: tuple[BrushStroke, ...] = ()
    outline: list = field(default_factory=list)

    def put_away(self) -> BrushTool:
        """The same out of use; what is being painted is forgotten."""
        return replace(self, is_open=False, before=None, painting=None)


def is_painted(state: EditorState) -> bool:
    """Whether the photo that is wanted has strokes of the brush."""
    return state.photo is not None and bool(state.photo.strokes)


def switch(state: EditorState) -> None:
    """Take the brush up, or put it away with what was painted."""
    if state.brush.is_open:
        done(state)
    else:
        show(state)


def show(state: EditorState) -> None:
    """Take the brush up, where there is an outline to correct."""
    opened = state.snapshot.opened
    if not state.is_at_work() or state.snapshot.picture is None:
        return
    if opened.photo.is_cut_out:
        state.asking.tell("This photo is cut out already: its own transparency is the outline", True)
        return
    state.make_room_for_a_tool()
    state.brush = replace(state.brush, is_open=True, before=state.photo, adds=True, outline=[])


def done(state: EditorState) -> None:
    """Put the brush away; what was painted stays."""
    state.brush = state.brush.put_away()


def cancel(state: EditorState) -> None:
    """Forget the stroke being painted; where there is none, all since the brush was taken up, and put it away."""
    if state.brush.painting is not None:
        state.brush.painting = None
        return
    before = state.brush.before
    done(state)
    if before is not None and state.photo is not None and before.strokes != state.photo.strokes:
        _wish(state, before.strokes)


def turn_over(state: EditorState) -> None:
    """Let the brush take away instead of adding, or the other way round."""
    state.brush.adds = not state.brush.adds


def resize(state: EditorState, steps: int) -> None:
    """A larger or smaller brush."""
    state.brush.radius_em = min(max(state.brush.radius_em * _SIZE_STEP**steps, SMALLEST_EM), LARGEST_EM)


def begin(state: EditorState, point: Point, radius_px: float, adds: bool) -> None:
    """Put the brush down on the photo.

    Args:
        point: in photo pixels.
        radius_px: of the brush, in photo pixels.
    """
    radius_px = round(min(max(radius_px, THINNEST_PX), WIDEST_PX), _DIGITS)
    state.brush.painting = BrushStroke((_rounded(point),), radius_px, adds)


def move(state: EditorState, point: Point) -> None:
    """Move the brush that is down. What is too near to the last point to be seen is left out."""
    stroke, point = state.brush.painting, _rounded(point)
    x, y = stroke.points[-1]
    if abs(point[0] - x) + abs(point[1] - y) > _NO_POINT_WITHIN * stroke.radius_px:
        state.brush.painting = replace(stroke, points=(*stroke.points, point))


def lift(state: EditorState) -> None:
    """The stroke that was painted counts from now on."""
    stroke, state.brush.painting = state.brush.painting, None
    strokes = (*state.photo.strokes, *_in_parts(stroke))
    if len(strokes) > MOST_STROKES:
        state.asking.tell(f"A photo has at most {MOST_STROKES} strokes of the brush; undo some first", True)
        return
    _wish(state, strokes)


def forget(state: EditorState) -> None:
    """The outline as the networks found it."""
    state.brush.painting = None
    _wish(state, ())


def _in_parts(stroke: BrushStroke) -> list[BrushStroke]:
    """A stroke as several that hang together, where it has too many points for one."""
    points, step = stroke.points, MOST_POINTS - 1
    starts = range(0, max(len(points) - 1, 1), step)
    return [replace(stroke, points=points[start : start + MOST_POINTS]) for start in starts]


def _rounded(point: Sequence[float]) -> Point:
    """As fine as a session keeps it."""
    x, y = (round(min(max(part, -FARTHEST_PX), FARTHEST_PX), _DIGITS) for part in point)
    return x, y


def _wish(state: EditorState, strokes: tuple[BrushStroke, ...]) -> None:
    if not state.is_at_work():
        # Another photo is on its way, which is none of these strokes' business.
        return
    state.photo = replace(state.photo.on(state.snapshot.opened.photo), strokes=strokes)
