"""Where a picture lies in the viewport: fit, zoom about a point, pan. All in framebuffer pixels, y down."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

SMALLEST_ZOOM, LARGEST_ZOOM = 0.02, 64.0
MARGIN_PX = 16


@dataclass(frozen=True)
class Frame:
    """Where a picture lies in the photo, in the photo's pixels: the photo itself at 0, 0, a channel at its crop.

    Attributes:
        x, y, width, height: its rectangle before the turn.
        roll_deg: how far it is turned about its middle, counterclockwise as one looks at the photo.
    """

    x: float
    y: float
    width: float
    height: float
    roll_deg: float = 0.0


@dataclass(frozen=True)
class View:
    """How a picture is looked at.

    Attributes:
        fit: the whole picture, as large as it goes; the other fields are then unused.
        zoom: screen pixels per photo pixel.
        centre_x, centre_y: the point of the photo, in its pixels, at the viewport's centre.
    """

    fit: bool = True
    zoom: float = 1.0
    centre_x: float = 0.0
    centre_y: float = 0.0


@dataclass(frozen=True)
class Placement:
    """A picture's rectangle in the viewport.

    Attributes:
        x, y: its top left corner.
        zoom: screen pixels per photo pixel.
        width, height: of the picture on the screen, before its turn.
        roll_deg: how far it is turned about its middle, counterclockwise.
    """

    x: float
    y: float
    zoom: float
    width: float
    height: float
    roll_deg: float = 0.0


def place(view: View, frame: Frame, viewport: tuple[int, int]) -> Placement:
    """The rectangle of a picture in a viewport (width, height).

    The corner lies on a whole pixel, so that pixels stay crisp where the zoom is a whole number.
    """
    view = settled(view, frame, viewport)
    x = viewport[0] / 2 + (frame.x - view.centre_x) * view.zoom
    y = viewport[1] / 2 + (frame.y - view.centre_y) * view.zoom
    corner_x, corner_y = math.floor(x + 0.5), math.floor(y + 0.5)
    width, height = frame.width * view.zoom, frame.height * view.zoom
    return Placement(corner_x, corner_y, view.zoom, width, height, frame.roll_deg)


def settled(view: View, frame: Frame, viewport: tuple[int, int]) -> View:
    """The same view with its zoom and centre worked out, no longer bound to fit."""
    if not view.fit:
        return view
    room = (max(1, viewport[0] - 2 * MARGIN_PX), max(1, viewport[1] - 2 * MARGIN_PX))
    zoom = min(room[0] / frame.width, room[1] / frame.height)
    return View(False, zoom, frame.x + frame.width / 2, frame.y + frame.height / 2)


def zoom_about(view: View, factor: float, at: tuple[float, float], frame: Frame, viewport: tuple[int, int]) -> View:
    """Zoom by a factor while the point of the picture at the viewport's position `at` stays there.

    Beside the picture there is no such point, and zooming in moves the picture no further out of sight.
    """
    view = settled(view, frame, viewport)
    zoom = min(max(view.zoom * factor, SMALLEST_ZOOM), LARGEST_ZOOM)
    away_x, away_y = at[0] - viewport[0] / 2, at[1] - viewport[1] / 2
    centre_x = view.centre_x + away_x / view.zoom - away_x / zoom
    centre_y = view.centre_y + away_y / view.zoom - away_y / zoom
    if zoom > view.zoom:
        centre_x = _within(centre_x, frame.x, frame.x + frame.width, view.centre_x)
        centre_y = _within(centre_y, frame.y, frame.y + frame.height, view.centre_y)
    return View(False, zoom, centre_x, centre_y)


def actual_size(view: View, at: tuple[float, float], frame: Frame, viewport: tuple[int, int]) -> View:
    """One screen pixel for each of the photo's, the point at `at` staying there; fit again where it is so already."""
    if not view.fit and view.zoom == 1.0:
        return View()
    return replace(zoom_about(view, 1.0 / settled(view, frame, viewport).zoom, at, frame, viewport), zoom=1.0)


def pan(view: View, dx: float, dy: float, frame: Frame, viewport: tuple[int, int]) -> View:
    """Move the picture by screen pixels, no further out of sight than with its edge in the middle."""
    view = settled(view, frame, viewport)
    centre_x = _within(view.centre_x - dx / view.zoom, frame.x, frame.x + frame.width, view.centre_x)
    centre_y = _within(view.centre_y - dy / view.zoom, frame.y, frame.y + frame.height, view.centre_y)
    return replace(view, centre_x=centre_x, centre_y=centre_y)


def photo_point(placement: Placement, frame: Frame, at: tuple[float, float]) -> tuple[float, float]:
    """The point of the photo, in its pixels, at the viewport's position `at`."""
    return frame.x + (at[0] - placement.x) / placement.zoom, frame.y + (at[1] - placement.y) / placement.zoom


def _within(centre: float, low: float, high: float, before: float) -> float:
    """The centre on the picture; where zooming out has left it beside that, it need not jump, and goes no further."""
    return min(max(centre, min(low, before)), max(high, before))
