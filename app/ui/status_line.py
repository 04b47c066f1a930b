"""The bottom line: what runs, messages that stay, and how long the last result took."""

from __future__ import annotations

from imgui_bundle import imgui

from app.ui import theme, widgets
from app.ui.probe import reading
from app.ui.state import EditorState

_KEYS = "? for all keys"


def draw(state: EditorState) -> None:
    """The line's contents, inside its window."""
    timing = _timing(state)
    em = imgui.get_font_size()
    timing_width = imgui.calc_text_size(timing).x + em if timing else 0.0
    keys_width = imgui.calc_text_size(_KEYS).x
    room = imgui.get_content_region_avail().x
    left = imgui.get_cursor_pos_x()
    _words(state, room - timing_width - keys_width - 2 * em)
    if timing:
        imgui.same_line()
        imgui.set_cursor_pos_x(left + room - timing_width - keys_width)
        imgui.text_disabled(timing)
        imgui.set_item_tooltip(f"{_stages(state)}\nClick to keep this in sight.")
        if imgui.is_item_clicked():
            state.look.switch("timings")
    imgui.same_line()
    imgui.set_cursor_pos_x(left + room - keys_width)
    imgui.text_disabled(_KEYS)
    imgui.set_item_tooltip("Shows all keys.")
    if imgui.is_item_clicked():
        state.look.help = True


def _words(state: EditorState, width: float) -> None:
    message = state.message()
    if message is not None:
        colour = theme.ERROR if message.is_error else theme.TEXT
        imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*colour))
        imgui.text(widgets.shortened(message.text, width))
        imgui.pop_style_color()
        imgui.set_item_tooltip(f"{message.text}\nClick to put this message away.")
        if imgui.is_item_clicked():
            state.dismissed = message.number
        return
    activity, opened = state.snapshot.activity, state.snapshot.opened
    if activity:
        imgui.text_disabled(f"{activity}…")
    elif opened:
        height, width_px = opened.photo.linear.shape[:2]
        imgui.text_disabled(f"{opened.source.name}   {width_px} × {height}{_under_the_mouse(state)}")
    else:
        imgui.text_disabled("Ready")


def _under_the_mouse(state: EditorState) -> str:
    """Where the mouse points at the photo and what the screen shows there."""
    if state.look.spot is None:
        return ""
    x, y = state.look.spot
    found = reading(state.snapshot, state.shown_name(), state.edit.exposure_ev, x, y)
    codes = "  ".join(f"{name} {code}" for name, code in zip("RGB", found.codes, strict=False)) if found else ""
    return f"      {int(x)}, {int(y)}   {codes}"


def _timing(state: EditorState) -> str:
    picture = state.snapshot.picture
    if picture is None:
        return ""
    total = sum(stage.ms for stage in picture.relit.stages.values() if stage.state == "computed")
    return f"Relit in {total:.0f} ms" if total < 1000 else f"Relit in {total / 1000:.1f} s"


def _stages(state: EditorState) -> str:
    stages = state.snapshot.picture.relit.stages
    lines = [
        f"{name}: {stage.ms:.0f} ms" if stage.state == "computed" else f"{name}: {stage.state}, {stage.why}"
        for name, stage in stages.items()
    ]
    return "The last picture\n" + "\n".join(lines)
