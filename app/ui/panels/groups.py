"""The groups of a panel, which fold away under their titles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from imgui_bundle import imgui

from app.ui import theme, widgets
from app.ui.state import EditorState

_ARROW_EM, _HEIGHT_EM, SPACING_EM, _GAP_EM = 0.95, 1.45, 0.3, 0.1

_TOOL_FONT, _TOOL_PADDING_EM = 0.9, 0.9
"""How large a tool's words are, as a share of the others, and what is left and right of them together."""


@dataclass(frozen=True)
class Tool:
    """A small button beside a group's title."""

    label: str
    tooltip: str
    enabled: bool = True


def group(
    state: EditorState, fonts: theme.Fonts, name: str, title: str, summary: str = "", tools: Sequence[Tool] = ()
) -> tuple[bool, str | None]:
    """The title of a group; a click on it opens or folds the group.

    Args:
        name: of a field of `app.ui.layout.OpenGroups`.
        summary: stands on the right while the group is folded.
        tools: stand on the right while it is open.

    Returns:
        Whether the group is open, and the label of the tool that was clicked.
    """
    is_open, em = getattr(state.groups, name), imgui.get_font_size()
    if imgui.get_cursor_pos_y() > em:
        widgets.gap(_GAP_EM)
    corner, width = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail().x
    room = width - sum(tool_width(tool) for tool in tools)
    if not is_open or room < _title_width(fonts, title):
        # In a narrow panel they would lie over the title.
        room, tools = width, ()
    if imgui.invisible_button(f"group {name}", imgui.ImVec2(max(1.0, room), _HEIGHT_EM * em)):
        state.groups = replace(state.groups, **{name: not is_open})
    lit = imgui.is_item_hovered()
    if not is_open:
        # Of an open one it would lie over the first control, where the mouse rests after the click.
        imgui.set_item_tooltip("Click to open this.")
    _title(fonts, title, "" if is_open else summary, corner, width, is_open, lit)
    pressed = None
    for tool in tools:
        imgui.same_line(0.0, SPACING_EM * em)
        if tool_button(tool):
            pressed = tool.label
    return is_open, pressed


def type_in(state: EditorState, label: str, panel: str, group: str | None) -> None:
    """Open a panel, and the group in it, and let what is there under this label be typed, as `widgets.begin_typing`."""
    state.panels = replace(state.panels, **{panel: True})
    if group is not None:
        state.groups = replace(state.groups, **{group: True})
    widgets.begin_typing(state, label)


def _title_width(fonts: theme.Fonts, title: str) -> float:
    """With the arrow before it."""
    imgui.push_font(fonts.bold, 0.0)
    width = _ARROW_EM * imgui.get_font_size() + imgui.calc_text_size(title).x
    imgui.pop_font()
    return width


def _title(
    fonts: theme.Fonts, title: str, summary: str, corner: imgui.ImVec2, width: float, is_open: bool, lit: bool
) -> None:
    em, draw = imgui.get_font_size(), imgui.get_window_draw_list()
    arrow(draw, corner.x + 0.3 * em, corner.y + _HEIGHT_EM * em / 2, 0.26 * em, is_open, lit)
    y = corner.y + (_HEIGHT_EM - 1.0) * em / 2 - 0.08 * em
    imgui.push_font(fonts.bold, 0.0)
    draw.add_text(imgui.ImVec2(corner.x + _ARROW_EM * em, y), theme.packed(theme.TEXT), title)
    taken = _ARROW_EM * em + imgui.calc_text_size(title).x + em
    imgui.pop_font()
    if summary:
        words = widgets.shortened(summary, width - taken)
        x = corner.x + width - imgui.calc_text_size(words).x
        draw.add_text(imgui.ImVec2(x, y), theme.packed(theme.DIM), words)


def arrow(draw: imgui.ImDrawList, x: float, y: float, reach: float, is_open: bool, lit: bool = False) -> None:
    """Downward over what is open, to the right before what is folded."""
    if is_open:
        points = ((x - reach, y - 0.5 * reach), (x + reach, y - 0.5 * reach), (x, y + 0.8 * reach))
    else:
        points = ((x - 0.5 * reach, y - reach), (x + 0.8 * reach, y), (x - 0.5 * reach, y + reach))
    draw.add_triangle_filled(
        *(imgui.ImVec2(*point) for point in points), theme.packed(theme.TEXT if lit else theme.DIM)
    )


def tool_width(tool: Tool) -> float:
    """Of its button, with the space before it."""
    imgui.push_font(None, _TOOL_FONT * theme.FONT_PX)
    # Letters are as wide as whole pixels, so that those of a smaller font are not narrower in proportion.
    words = imgui.calc_text_size(tool.label).x
    imgui.pop_font()
    return words + (_TOOL_PADDING_EM + SPACING_EM) * imgui.get_font_size()


def tool_button(tool: Tool, down: bool = False) -> bool:
    """The button, which looks pressed while `down`; True when it is clicked."""
    em = imgui.get_font_size()
    width = tool_width(tool) - SPACING_EM * em
    if down:
        imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(*theme.PRESSED))
    imgui.push_font(None, _TOOL_FONT * theme.FONT_PX)
    imgui.push_style_var(imgui.StyleVar_.frame_padding, imgui.ImVec2(0.0, 0.12 * em))
    imgui.begin_disabled(not tool.enabled)
    clicked = imgui.button(tool.label, imgui.ImVec2(width, 0.0))
    imgui.end_disabled()
    imgui.pop_style_var()
    imgui.pop_font()
    if down:
        imgui.pop_style_color()
    imgui.set_item_tooltip(tool.tooltip)
    return clicked


def tools_beside(label: str, *tools: tuple[Tool, bool]) -> str | None:
    """Buttons beside the name of the slider that is drawn next, each with whether it is pressed down.

    Returns:
        the label of the one that is clicked, if any.
    """
    corner, em = imgui.get_cursor_screen_pos(), imgui.get_font_size()
    x, clicked = corner.x + imgui.calc_text_size(label).x + 0.6 * em, None
    for tool, down in tools:
        imgui.set_cursor_screen_pos(imgui.ImVec2(x, corner.y - 0.1 * em))
        if tool_button(tool, down):
            clicked = tool.label
        x += tool_width(tool)
    imgui.set_cursor_screen_pos(corner)
    return clicked
