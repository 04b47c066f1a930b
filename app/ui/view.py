"""Where a picture lies in the viewport: fit, zoom about a point, pan. All in framebuffer pixels, y down."""

from __future__ import annotations

from dataclasses import dataclass, replace

SMALLEST_ZOOM, LARGEST_ZOOM = 0.02, 64.0
MARGIN_PX = 16


@dataclass(frozen=True)
class View:
    """How a picture is looked at.

    Attributes:
        fit: the whole picture, as large as it goes; the other fields are then unused.
        zoom: screen pixels per picture pixel.
        centre_x, centre_y: the point of the picture, in its pixels, at the viewport's centre.
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
        zoom: screen pixels per picture pixel.
        width, height: of the picture on the screen.
    """

    x: float
    y: float
    zoom: float
    width: float
    height: float


def place(view: View, picture: tuple[int, int], viewport: tuple[int, int]) -> Placement:
    """The rectangle of a picture (width, height) in a viewport (width, height).

    Where the zoom is a whole number the corner lies on a whole pixel, so that pixels stay crisp.
    """
    view = settled(view, picture, viewport)
    x = viewport[0] / 2 - view.centre_x * view.zoom
    y = viewport[1] / 2 - view.centre_y * view.zoom
    return Placement(round(x), round(y), view.zoom, picture[0] * view.zoom, picture[1] * view.zoom)


def settled(view: View, picture: tuple[int, int], viewport: tuple[int, int]) -> View:
    """The same view with its zoom and centre worked out, no longer bound to fit."""
    if not view.fit:
        return view
    room = (max(1, viewport[0] - 2 * MARGIN_PX), max(1, viewport[1] - 2 * MARGIN_PX))
    zoom = min(room[0] / picture[0], room[1] / picture[1])
    return View(False, zoom, picture[0] / 2, picture[1] / 2)


def zoom_about(
    view: View, factor: float, at: tuple[float, float], picture: tuple[int, int], viewport: tuple[int, int]
) -> View:
    """Zoom by a factor while the point of the picture at the viewport's position `at` stays there."""
    view = settled(view, picture, viewport)
    zoom = min(max(view.zoom * factor, SMALLEST_ZOOM), LARGEST_ZOOM)
    away_x, away_y = at[0] - viewport[0] / 2, at[1] - viewport[1] / 2
    return View(
        False,
        zoom,
        view.centre_x + away_x / view.zoom - away_x / zoom,
        view.centre_y + away_y / view.zoom - away_y / zoom,
    )


def pan(view: View, dx: float, dy: float, picture: tuple[int, int], viewport: tuple[int, int]) -> View:
    """Move the picture by screen pixels; some of it always stays in sight."""
    view = settled(view, picture, viewport)
    centre_x = min(max(view.centre_x - dx / view.zoom, 0.0), float(picture[0]))
    centre_y = min(max(view.centre_y - dy / view.zoom, 0.0), float(picture[1]))
    return replace(view, centre_x=centre_x, centre_y=centre_y)
