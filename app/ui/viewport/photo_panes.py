"""The panes that show the whole photo, over which tools draw and in which they follow the mouse."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from imgui_bundle import imgui

from app.ui.channels import WHOLE_PHOTO
from app.ui.layout import Rect
from app.ui.viewport.panes import Arrangement, Pane


def pane_under(arranged: Arrangement, at: tuple[float, float], began_in: int | None) -> Pane | None:
    """The pane that a tool works in with the mouse at a place of the viewport; None where it shows no whole photo.

    Args:
        began_in: index of the pane in which a drag began, to which it keeps; None while nothing is dragged.
    """
    if began_in is not None and began_in < len(arranged.panes):
        pane = arranged.panes[began_in]
    else:
        pane = arranged.pane_at(at[0]) or arranged.main
    return pane if pane is not None and pane.name in WHOLE_PHOTO else None


def drawn_over(arranged: Arrangement, rect: Rect, scale: float) -> Iterator[Pane]:
    """Each pane of the whole photo in turn; what is drawn meanwhile stays within it."""
    draw_list = imgui.get_window_draw_list()
    for pane in arranged.panes:
        if pane.name in WHOLE_PHOTO:
            left, right = (rect.x + edge / scale for edge in (pane.left, pane.right))
            draw_list.push_clip_rect(imgui.ImVec2(left, rect.y), imgui.ImVec2(right, rect.y + rect.height), True)
            yield pane
            draw_list.pop_clip_rect()


def in_the_window(
    points: Sequence[tuple[float, float]] | np.ndarray, pane: Pane, rect: Rect, scale: float
) -> list[imgui.ImVec2]:
    """Where points (n, 2) of the photo are in the window."""
    spot = pane.placement
    places = np.array([rect.x, rect.y]) + (np.array([spot.x, spot.y]) + np.asarray(points) * spot.zoom) / scale
    return [imgui.ImVec2(x, y) for x, y in places.tolist()]
