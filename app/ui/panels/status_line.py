"""The bottom line: what runs, messages that stay, and how long the last result took."""

from __future__ import annotations

from pathlib import Path

from imgui_bundle import imgui

from app.ui import theme, widgets
from app.ui.news import put_message_away
from app.ui.panels.plan_panel import duration
from app.ui.state import EditorState
from app.ui.viewport.probe import reading
from relight_core.pipeline.cache import computed_ms

_APART_EM = 1.2


def _ask_for_keys(state: EditorState) -> None:
    state.look.help = True


def _keep_timings(state: EditorState) -> None:
    state.look.switch("timings")


def draw(state: EditorState) -> None:
    """The line's contents, inside its window."""
    # Words to click at the line's end: label, tooltip, what is done.
    links = [("? for all keys", "Shows all keys.", _ask_for_keys)]
    if timing := _timing(state):
        links.insert(0, (timing, f"{_stages(state)}\nClick to keep this in sight.", _keep_timings))
    apart = _APART_EM * imgui.get_font_size()
    room, left = imgui.get_content_region_avail().x, imgui.get_cursor_pos_x()
    widths = [imgui.calc_text_size(label).x for label, _, _ in links]
    x = left + room - sum(widths) - apart * (len(widths) - 1)
    _words(state, x - left - apart)
    for (label, tooltip, act), width in zip(links, widths, strict=True):
        imgui.same_line()
        imgui.set_cursor_pos_x(x)
        if _link(label, tooltip):
            act(state)
        x += width + apart


def _link(label: str, tooltip: str) -> bool:
    """Words that light up under the mouse; whether they were clicked."""
    corner = imgui.get_cursor_screen_pos()
    size = imgui.calc_text_size(label)
    clicked = imgui.invisible_button(label, size)
    hovered = imgui.is_item_hovered()
    imgui.set_item_tooltip(tooltip)
    if hovered:
        imgui.set_mouse_cursor(imgui.MouseCursor_.hand)
    colour = theme.TEXT if hovered else theme.DIM
    imgui.get_window_draw_list().add_text(corner, theme.packed(colour), label)
    return clicked


def _words(state: EditorState, width: float) -> None:
    message = state.message()
    if message is not None:
        colour = theme.ERROR if message.is_error else theme.TEXT
        imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*colour))
        imgui.text(widgets.shortened(brief(message.text), width))
        imgui.pop_style_color()
        imgui.set_item_tooltip(f"{message.text}\nClick to put this message away.")
        if imgui.is_item_clicked():
            put_message_away(state)
        return
    activity, opened = state.snapshot.activity, state.snapshot.opened
    if activity:
        imgui.text_disabled(widgets.shortened(f"{activity}…", width))
    elif opened:
        height_px, width_px = opened.photo.linear.shape[:2]
        # What is under the mouse is looked for here; the name is known, and told in full at rest on it.
        facts = f"   {width_px} × {height_px}{_under_the_mouse(state)}"
        name = widgets.shortened(opened.source.name, width - imgui.calc_text_size(facts).x)
        imgui.text_disabled(name + facts)
        if name != opened.source.name:
            imgui.set_item_tooltip(opened.source.name)
    else:
        imgui.text_disabled("Ready")


def brief(message: str) -> str:
    """The first line of a message; about a file with the file's name alone, so that what is wrong is in sight."""
    message = message.splitlines()[0] if message else message
    place, colon, rest = message.partition(": ")
    return f"{Path(place).name or place}{colon}{rest}" if colon and Path(place).is_absolute() else message


def _under_the_mouse(state: EditorState) -> str:
    """Where the mouse points at the photo and what the screen shows there."""
    if state.look.spot is None:
        return ""
    x, y = state.look.spot
    found = reading(state.snapshot, state.look.spot_in, state.edit.exposure_ev, x, y)
    codes = "  ".join(f"{name} {code}" for name, code in zip("RGB", found.codes, strict=False)) if found else ""
    return f"      {int(x)}, {int(y)}   {codes}"


def _timing(state: EditorState) -> str:
    picture = state.snapshot.picture
    if picture is None:
        return ""
    return f"Relit in {duration(computed_ms(picture.relit.stages))}"


def _stages(state: EditorState) -> str:
    stages = state.snapshot.picture.relit.stages
    lines = [
        f"{name}: {stage.ms:.0f} ms" if stage.state == "computed" else f"{name}: {stage.state}, {stage.why}"
        for name, stage in stages.items()
    ]
    return "The last picture\n" + "\n".join(lines)
