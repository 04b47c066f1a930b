"""The filmstrip: a thumbnail of every channel, which brings it into the viewport."""

from __future__ import annotations

import math

from imgui_bundle import imgui

from app.ui import theme, widgets
from app.ui.channels import Channel, in_filmstrip
from app.ui.pictures import Pictures, Shown
from app.ui.state import EditorState


def draw(state: EditorState, pictures: Pictures) -> None:
    """The strip's contents, inside its window."""
    em = imgui.get_font_size()
    room = imgui.get_content_region_avail()
    picture = state.snapshot.picture_in_sight
    channels = in_filmstrip(picture.channels if picture else ())
    spacing = 0.4 * em
    width = min(1.35 * (room.y - 1.4 * em), (room.x - spacing * (len(channels) - 1)) / len(channels))
    indent = (room.x - len(channels) * width - spacing * (len(channels) - 1)) / 2
    imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + max(0.0, indent))
    side_px = max(1, math.ceil(max(width, room.y) * imgui.get_io().display_framebuffer_scale.x))
    for index, channel in enumerate(channels):
        if index:
            imgui.same_line(0.0, spacing)
        _frame(state, pictures.thumbnail(channel.name, side_px), channel, width, room.y)
        # The title too, which a narrow window cuts short.
        imgui.set_item_tooltip(f"{channel.title}   {channel.key}\n{channel.explanation}")


def _frame(state: EditorState, shown: Shown | None, channel: Channel, width: float, height: float) -> None:
    em = imgui.get_font_size()
    corner = imgui.get_cursor_screen_pos()
    imgui.begin_disabled(shown is None)
    if imgui.invisible_button(channel.name, imgui.ImVec2(width, height)):
        state.shown = channel.name
    imgui.end_disabled()
    chosen = shown is not None and state.shown == channel.name
    image_height = height - 1.4 * em
    draw_list = imgui.get_window_draw_list()
    end = imgui.ImVec2(corner.x + width, corner.y + image_height)
    draw_list.add_rect_filled(corner, end, theme.packed(theme.CANVAS), 4.0)
    if shown is not None:
        _centred(shown, corner, width, image_height)
    if chosen or (shown is not None and imgui.is_item_hovered()):
        outline = theme.ACCENT if chosen else theme.FAINT
        draw_list.add_rect(corner, end, theme.packed(outline), 4.0, (0.13 if chosen else 0.07) * em)
    _label(channel, chosen, shown is not None, corner, width, image_height)


def _centred(shown: Shown, corner: imgui.ImVec2, width: float, height: float) -> None:
    scale = min((width - 6.0) / shown.width, (height - 6.0) / shown.height)
    image_width, image_height = shown.width * scale, shown.height * scale
    x, y = corner.x + (width - image_width) / 2, corner.y + (height - image_height) / 2
    widgets.draw_image(shown, x, y, image_width, image_height, 2.0)


def _label(
    channel: Channel, chosen: bool, there: bool, corner: imgui.ImVec2, width: float, image_height: float
) -> None:
    imgui.push_font(None, 0.86 * theme.FONT_PX)
    em = imgui.get_font_size()
    text = widgets.shortened(channel.title, width - 1.2 * em)
    total = imgui.calc_text_size(text).x + 0.9 * em
    x, y = corner.x + max(0.0, (width - total) / 2), corner.y + image_height + 0.25 * em
    colour = theme.ACCENT if chosen else theme.TEXT if there else theme.FAINT
    draw_list = imgui.get_window_draw_list()
    draw_list.add_text(imgui.ImVec2(x, y), theme.packed(theme.FAINT), channel.key)
    draw_list.add_text(imgui.ImVec2(x + 0.9 * em, y), theme.packed(colour), text)
    imgui.pop_font()
