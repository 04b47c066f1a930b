"""The centre: the picture, zoomed and panned, compared with the photo, and what is drawn over it."""

from __future__ import annotations

from imgui_bundle import imgui

from app.ui import theme, widgets
from app.ui.layout import Rect
from app.ui.panels import timings
from app.ui.pictures import Paint, Pictures
from app.ui.state import EditorState
from app.ui.viewport import brush_tool, face_tool, light_ball, placing, probe_card, viewport_notes, wipe
from app.ui.viewport.panes import LIGHTS, Arrangement, arrange_panes
from app.ui.viewport.view import View, actual_size, pan, zoom_about

DEGREES_PER_STEP = 5.0
ZOOM_PER_STEP = 1.2
_STRIPE_EM, _CHECK_EM = 0.3, 0.8


def draw(state: EditorState, fonts: theme.Fonts, pictures: Pictures, rect: Rect) -> None:
    """The viewport, inside a window of the same rectangle."""
    scale = imgui.get_io().display_framebuffer_scale.x
    size = (max(1, round(rect.width * scale)), max(1, round(rect.height * scale)))
    _forget_the_last_photo(state)
    imgui.set_cursor_screen_pos(imgui.ImVec2(rect.x, rect.y))
    imgui.set_next_item_allow_overlap()
    clicked = imgui.invisible_button("viewport", imgui.ImVec2(rect.width, rect.height))
    mouse = imgui.get_io().mouse_pos
    at = (mouse.x - rect.x) * scale, (mouse.y - rect.y) * scale
    state.look.viewport_px = size
    state.look.pointer_px = at if imgui.is_item_hovered() else None
    arranged = arrange_panes(state, size)
    is_open = state.snapshot.opened is not None
    if is_open and arranged.main:
        _move_by_the_wheel_button(state, arranged, scale)
    if (
        is_open
        and arranged.main
        and not face_tool.drag(state, arranged, at, scale)
        and not brush_tool.drag(state, arranged, at, scale)
        and not placing.drag(state, arranged, at)
        and not wipe.drag(state, arranged, at, scale)
    ):
        _navigate(state, arranged, scale)
    arranged = arrange_panes(state, size)
    shown = pictures.viewport(arranged.panes, size, _paint(state, scale))
    widgets.draw_image(shown, rect.x, rect.y, rect.width, rect.height)
    if arranged.main is None:
        if viewport_notes.invitation(state, fonts, rect) and clicked:
            state.asking.wish("open_file")
        return
    if is_open:
        _over_the_picture(state, pictures, arranged, rect, scale)
    else:
        viewport_notes.progress(state, rect)


def _paint(state: EditorState, scale: float) -> Paint:
    look, em_px = state.look, imgui.get_font_size() * scale
    stripe_px, check_px = max(2.0, round(_STRIPE_EM * em_px)), round(_CHECK_EM * em_px)
    return Paint(look.clipping, look.false_colour, look.difference, stripe_px, check_px)


def zoom_by(state: EditorState, factor: float) -> None:
    """Zoom about the mouse, or about the middle while it is not over the picture."""
    arranged = arrange_panes(state, state.look.viewport_px)
    if arranged.main and arranged.main.name not in LIGHTS:
        at = _in_pane(arranged, state.look.pointer_px)
        state.view = zoom_about(state.view, factor, at, arranged.main.frame, arranged.pane_px)


def fit(state: EditorState) -> None:
    """The whole picture, as large as the viewport allows."""
    state.view = View()


def toggle_actual_size(state: EditorState) -> None:
    """One screen pixel for each of the photo's at the mouse; from there, fit again."""
    arranged = arrange_panes(state, state.look.viewport_px)
    if arranged.main and arranged.main.name not in LIGHTS:
        at = _in_pane(arranged, state.look.pointer_px)
        state.view = actual_size(state.view, at, arranged.main.frame, arranged.pane_px)


def _forget_the_last_photo(state: EditorState) -> None:
    """Fit a new photo; another face of the same photo keeps the view."""
    opened = state.snapshot.opened
    if opened is not None and state.view_of is not opened.photo:
        state.view, state.view_of = View(), opened.photo


def _in_pane(arranged: Arrangement, at: tuple[float, float] | None) -> tuple[float, float]:
    """A position in the viewport as one in the pane it is in; the pane's middle for None."""
    if at is None:
        return arranged.pane_px[0] / 2, arranged.pane_px[1] / 2
    if arranged.wipe_x is not None or len(arranged.panes) == 1:
        return at
    pane = arranged.pane_at(at[0]) or arranged.panes[0]
    return at[0] - pane.left, at[1]


def _move_by_the_wheel_button(state: EditorState, arranged: Arrangement, scale: float) -> None:
    """Pressing the wheel and dragging moves the picture, whatever the left button does."""
    delta = imgui.get_io().mouse_delta
    if imgui.is_item_hovered() and imgui.is_mouse_down(2) and arranged.main.name not in LIGHTS:
        state.view = pan(state.view, delta.x * scale, delta.y * scale, arranged.main.frame, arranged.pane_px)


def _navigate(state: EditorState, arranged: Arrangement, scale: float) -> None:
    io = imgui.get_io()
    frame, pane_px = arranged.main.frame, arranged.pane_px
    fixed = arranged.main.name in LIGHTS
    if imgui.is_item_active() and (io.mouse_delta.x or io.mouse_delta.y) and not fixed:
        state.view = pan(state.view, io.mouse_delta.x * scale, io.mouse_delta.y * scale, frame, pane_px)
    if not imgui.is_item_hovered():
        return
    if imgui.is_mouse_double_clicked(0):
        if state.view.fit:
            toggle_actual_size(state)
        else:
            fit(state)
    if io.mouse_wheel and io.key_ctrl:
        zoom_by(state, ZOOM_PER_STEP**io.mouse_wheel)
    elif io.mouse_wheel:
        state.turn(io.mouse_wheel * (1.0 if io.key_shift else DEGREES_PER_STEP))


def _over_the_picture(state: EditorState, pictures: Pictures, arranged: Arrangement, rect: Rect, scale: float) -> None:
    face_tool.draw(state, arranged, rect, scale)
    brush_tool.draw(state, arranged, rect, scale)
    wipe.draw(state, arranged, rect, scale)
    viewport_notes.legend(state, pictures, arranged.main, rect)
    viewport_notes.progress(state, rect)
    viewport_notes.corner_note(state, arranged, rect)
    light_ball.draw(state, pictures, rect, scale)
    covered = min(state.look.covered, rect.height)
    below = Rect(rect.x, rect.y + covered, rect.width, rect.height - covered)
    timings.draw(state, below)
    probe_card.draw(state, arranged, below)
    placing.hint(state, arranged, below)
    viewport_notes.pane_titles(state, arranged, below, scale)
