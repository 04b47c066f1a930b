"""The centre: the picture, zoomed and panned, and what to do when there is none."""

from __future__ import annotations

from imgui_bundle import imgui

from app.ui import theme, widgets
from app.ui.effects_panel import MOST_FACES
from app.ui.layout import Rect
from app.ui.pictures import Pictures
from app.ui.state import CHANNELS, PHOTO, RESULT, EditorState
from app.ui.view import Placement, View, pan, place, zoom_about

DEGREES_PER_STEP = 5.0
ZOOM_PER_STEP = 1.2
_TITLES = {name: title for name, title, _ in CHANNELS}


def draw(state: EditorState, fonts: theme.Fonts, pictures: Pictures, rect: Rect) -> None:
    """The viewport, inside a window of the same rectangle."""
    scale = imgui.get_io().display_framebuffer_scale
    size = (max(1, round(rect.width * scale.x)), max(1, round(rect.height * scale.y)))
    name = state.shown_name() if state.snapshot.opened else None
    picture = pictures.size(name) if name else None
    if picture and picture != state.view_of:
        state.view, state.view_of = View(), picture
    imgui.set_cursor_screen_pos(imgui.ImVec2(rect.x, rect.y))
    imgui.invisible_button("viewport", imgui.ImVec2(rect.width, rect.height))
    mouse = imgui.get_io().mouse_pos
    at = (mouse.x - rect.x) * scale.x, (mouse.y - rect.y) * scale.y
    state.look.viewport_px = size
    state.look.pointer_px = at if imgui.is_item_hovered() else None
    if picture:
        _navigate(state, rect, scale, picture, size)
    placement = place(state.view, picture, size) if picture else None
    shown = pictures.viewport(name if picture else None, placement, size)
    widgets.draw_image(shown, rect.x, rect.y, rect.width, rect.height)
    if picture is None:
        _empty(state, fonts, rect)
    else:
        _corner_note(state, name, placement.zoom, rect)
        if state.pointing_at_faces and name in (PHOTO, RESULT):
            _faces(state, placement, rect, scale)
        _progress_note(state, rect)


def zoom_by(state: EditorState, factor: float) -> None:
    """Zoom about the mouse, or about the middle while it is not over the picture."""
    if state.view_of != (0, 0):
        width, height = size = state.look.viewport_px
        at = state.look.pointer_px or (width / 2, height / 2)
        state.view = zoom_about(state.view, factor, at, state.view_of, size)


def _navigate(
    state: EditorState, rect: Rect, scale: imgui.ImVec2, picture: tuple[int, int], size: tuple[int, int]
) -> None:
    io = imgui.get_io()
    if imgui.is_item_active() and (io.mouse_delta.x or io.mouse_delta.y):
        dx, dy = io.mouse_delta.x * scale.x, io.mouse_delta.y * scale.y
        state.view = pan(state.view, dx, dy, picture, size)
    if imgui.is_item_hovered() and imgui.is_mouse_double_clicked(0):
        state.view = View()
    if imgui.is_item_hovered() and io.mouse_wheel:
        if io.key_ctrl:
            at = ((io.mouse_pos.x - rect.x) * scale.x, (io.mouse_pos.y - rect.y) * scale.y)
            state.view = zoom_about(state.view, ZOOM_PER_STEP**io.mouse_wheel, at, picture, size)
        else:
            state.turn(io.mouse_wheel * (1.0 if io.key_shift else DEGREES_PER_STEP))


def _corner_note(state: EditorState, name: str, zoom: float, rect: Rect) -> None:
    words = f"{zoom * 100:.0f} %"
    if name != RESULT:
        label = "Before" if name == PHOTO and state.before else _TITLES[name]
        words = f"{label}   {words}"
    width = imgui.calc_text_size(words).x
    em = imgui.get_font_size()
    _note(words, rect.x + rect.width - width - 1.4 * em, rect.y + rect.height - 2.2 * em)


def _faces(state: EditorState, placement: Placement, rect: Rect, scale: imgui.ImVec2) -> None:
    """A numbered frame around every face."""
    photo_width = state.snapshot.opened.photo.linear.shape[1]
    grown = placement.width / photo_width
    draw_list = imgui.get_window_draw_list()
    for index, box in enumerate(state.snapshot.faces[:MOST_FACES]):
        x0, x1 = (rect.x + (placement.x + edge * grown) / scale.x for edge in (box.x0, box.x1))
        y0, y1 = (rect.y + (placement.y + edge * grown) / scale.y for edge in (box.y0, box.y1))
        draw_list.add_rect(imgui.ImVec2(x0, y0), imgui.ImVec2(x1, y1), theme.packed(theme.ACCENT), 4.0, 2.0)
        _note(str(index + 1), x0 + 4.0, y0 + 4.0)


def _progress_note(state: EditorState, rect: Rect) -> None:
    """What runs, over the photo, as long as there is nothing newer of it to look at."""
    snapshot = state.snapshot
    if snapshot.activity is None or (snapshot.picture and snapshot.picture.opened is snapshot.opened):
        return
    words = f"{snapshot.activity}…"
    em = imgui.get_font_size()
    width = imgui.calc_text_size(words).x
    _note(words, rect.x + (rect.width - width - em) / 2, rect.y + rect.height - 2.2 * em)


def _note(words: str, x: float, y: float) -> None:
    """Words on a dark pill, their rectangle's top left corner at x, y."""
    em = imgui.get_font_size()
    corner = imgui.ImVec2(x, y)
    end = imgui.ImVec2(x + imgui.calc_text_size(words).x + em, y + 1.5 * em)
    draw_list = imgui.get_window_draw_list()
    draw_list.add_rect_filled(corner, end, theme.packed((0.05, 0.05, 0.05, 1.0), 0.72), 4.0)
    text_at = imgui.ImVec2(corner.x + 0.5 * em, corner.y + 0.22 * em)
    draw_list.add_text(text_at, theme.packed(theme.TEXT), words)


def _empty(state: EditorState, fonts: theme.Fonts, rect: Rect) -> None:
    busy = state.snapshot.activity
    title = f"{busy}…" if busy and state.photo else "Drop a portrait here"
    em = imgui.get_font_size()
    middle_x, middle_y = rect.x + rect.width / 2, rect.y + rect.height / 2
    if title == "Drop a portrait here":
        reach_x, reach_y = min(15 * em, 0.42 * rect.width), min(8 * em, 0.36 * rect.height)
        corner = imgui.ImVec2(middle_x - reach_x, middle_y - reach_y)
        end = imgui.ImVec2(middle_x + reach_x, middle_y + reach_y)
        imgui.get_window_draw_list().add_rect(corner, end, theme.packed(theme.PRESSED), 10.0, 1.5)
    imgui.push_font(fonts.regular, 1.5 * theme.FONT_PX)
    _centred_text(title, middle_x, middle_y - 1.6 * em, theme.TEXT)
    imgui.pop_font()
    if title == "Drop a portrait here":
        _centred_text("JPEG, PNG, TIFF, WebP or EXR", middle_x, middle_y + 0.4 * em, theme.DIM)
        _centred_text("An .hdr or .exr panorama becomes the light", middle_x, middle_y + 1.9 * em, theme.DIM)


def _centred_text(text: str, x: float, y: float, colour: theme.Colour) -> None:
    width = imgui.calc_text_size(text).x
    imgui.get_window_draw_list().add_text(imgui.ImVec2(x - width / 2, y), theme.packed(colour), text)
