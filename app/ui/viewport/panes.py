"""Which pictures the viewport shows and where: one, two divided by a wipe, or two side by side.

All positions are in framebuffer pixels from the viewport's top left corner.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from app.ui.channels import PHOTO, RESULT, WHOLE_PHOTO
from app.ui.state import EditorState
from app.ui.viewport.view import Frame, Placement, View, place

LIGHTS = ("source_light",)
"""Channels that are panoramas: they have no place in the photo, and are always seen whole."""

GAP_PX = 2
_EDGE_SHARE = 0.03
"""How near the wipe's line comes to the viewport's edge, so that its handle stays within reach."""


@dataclass(frozen=True)
class Pane:
    """A picture in a vertical strip of the viewport.

    Attributes:
        name: of app.ui.channels.CHANNELS.
        frame: where the picture lies in the photo.
        placement: where it lies in the viewport.
        left, right: the columns it is seen in.
    """

    name: str
    frame: Frame
    placement: Placement
    left: int
    right: int


@dataclass(frozen=True)
class Arrangement:
    """The viewport's panes, the photo first where there are two.

    Attributes:
        panes: one or two; none without a picture.
        pane_px: width and height of what the view is fitted to.
        wipe_x: where the wipe's line is, or None.
    """

    panes: tuple[Pane, ...]
    pane_px: tuple[int, int]
    wipe_x: float | None = None

    @property
    def main(self) -> Pane | None:
        """The pane of the picture that was chosen."""
        return self.panes[-1] if self.panes else None

    def pane_at(self, x: float) -> Pane | None:
        """The pane at a column."""
        return next((pane for pane in self.panes if pane.left <= x < pane.right), None)


def frame_of(state: EditorState, name: str) -> Frame:
    """Where a picture lies in the open photo."""
    height, width = state.snapshot.opened.photo.linear.shape[:2]
    picture = state.snapshot.picture
    if name in WHOLE_PHOTO or picture is None or picture.relit.window is None:
        return Frame(0.0, 0.0, width, height)
    if name in LIGHTS:
        return Frame(0.0, 0.0, 2.0, 1.0)
    x0, y0, x1, y1 = picture.relit.window
    return Frame(x0, y0, x1 - x0, y1 - y0, picture.relit.roll_deg)


def arrange_panes(state: EditorState, size: tuple[int, int]) -> Arrangement:
    """The panes of a viewport of `size` pixels."""
    if state.snapshot.opened is None:
        return _arrange_the_coming(state, size)
    name = state.shown_name()
    compare = state.look.compare if _has_partner(state, name) else "off"
    if name == PHOTO and compare != "off":
        name = RESULT
    frame = frame_of(state, name)
    if compare == "side":
        return _side_by_side(state, name, frame, size)
    view = View() if name in LIGHTS else state.view
    placement = place(view, frame, size)
    if compare == "off":
        return Arrangement((Pane(name, frame, placement, 0, size[0]),), size)
    return _wiped(state, name, frame, placement, size)


def can_compare(state: EditorState) -> bool:
    """Whether the photo can be seen beside what is chosen: every picture but a light, once there is one."""
    picture = state.snapshot.picture
    return picture is not None and not (state.shown in LIGHTS and state.shown in picture.channels)


def _arrange_the_coming(state: EditorState, size: tuple[int, int]) -> Arrangement:
    """The photo that is being read, all of it, if there is one."""
    coming = state.snapshot.coming
    if coming is None:
        return Arrangement((), size)
    height, width = coming.photo.linear.shape[:2]
    frame = Frame(0.0, 0.0, width, height)
    return Arrangement((Pane(PHOTO, frame, place(View(), frame, size), 0, size[0]),), size)


def _has_partner(state: EditorState, name: str) -> bool:
    return state.snapshot.picture_in_sight is not None and not state.before and name not in LIGHTS


def _side_by_side(state: EditorState, name: str, frame: Frame, size: tuple[int, int]) -> Arrangement:
    half = max(1, (size[0] - GAP_PX) // 2)
    placement = place(state.view, frame, (half, size[1]))
    right = replace(placement, x=placement.x + size[0] - half)
    before = Pane(PHOTO, frame_of(state, PHOTO), _photo_placement(state, frame, placement), 0, half)
    return Arrangement((before, Pane(name, frame, right, size[0] - half, size[0])), (half, size[1]))


def _wiped(state: EditorState, name: str, frame: Frame, placement: Placement, size: tuple[int, int]) -> Arrangement:
    line = placement.x + state.look.wipe_at * placement.width
    line = round(min(max(line, _EDGE_SHARE * size[0]), (1.0 - _EDGE_SHARE) * size[0]))
    before = Pane(PHOTO, frame_of(state, PHOTO), _photo_placement(state, frame, placement), 0, line)
    return Arrangement((before, Pane(name, frame, placement, line, size[0])), size, float(line))


def _photo_placement(state: EditorState, frame: Frame, placement: Placement) -> Placement:
    """The whole photo, such that the part of it at `frame` falls on `placement`."""
    whole, zoom = frame_of(state, PHOTO), placement.zoom
    x, y = placement.x - frame.x * zoom, placement.y - frame.y * zoom
    return Placement(x, y, zoom, whole.width * zoom, whole.height * zoom)
