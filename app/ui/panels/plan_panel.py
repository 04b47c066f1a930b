"""The plan: every effect with what was decided about it, why, what that saves, and the user's own say."""

from __future__ import annotations

from collections.abc import Sequence

from imgui_bundle import imgui

from app.ui import theme, widgets
from app.ui.state import EditorState
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.plan import Effect

_DOTS = {"computed": theme.ACCENT, "reused": theme.DIM, "skipped": theme.FAINT}
_NEXT = {None: True, True: False, False: None}
_WORDS = {None: "auto", True: "on", False: "off"}


def draw(state: EditorState) -> None:
    """One line in sum, and unfolded a row for each effect, inside a panel."""
    picture = state.snapshot.picture
    plan = getattr(picture.relit, "plan", ()) if picture else ()
    if not plan:
        return
    imgui.set_next_item_open(state.plan_open)
    flags = imgui.TreeNodeFlags_.no_tree_push_on_open | imgui.TreeNodeFlags_.span_avail_width
    state.plan_open = imgui.tree_node_ex(f"{summary(plan)}###plan", flags)
    imgui.set_item_tooltip("What the last picture called for, effect by effect, and why.")
    if state.plan_open:
        for effect in plan:
            _row(state, effect)


def summary(plan: Sequence[Effect]) -> str:
    """How many effects were computed, and the time that was saved by the others."""
    computed = sum(effect.state == "computed" for effect in plan)
    saved_ms = sum(effect.saved_ms or 0.0 for effect in plan)
    return f"{computed} of {len(plan)} run, {duration(saved_ms)} saved"


def duration(ms: float) -> str:
    """Milliseconds, or seconds from one up."""
    return f"{ms:.0f} ms" if ms < 1000 else f"{ms / 1000:.1f} s"


def title(effect: Effect) -> str:
    """The effect's name as it stands in the list."""
    return effect.name.replace("_", " ").capitalize()


def explanation(effect: Effect) -> str:
    """State, reason, what it may change, and the time saved, in words."""
    words = f"{effect.state}: {effect.why}"
    if effect.state == "skipped" and effect.bound == 0:
        words += "; no pixel changes"
    if effect.saved_ms:
        words += f"; {duration(effect.saved_ms)} saved"
    return words


def forced(edit: Edit, name: str, wish: bool | None) -> dict[str, frozenset[str]]:
    """The fields of an edit in which the user's say about an effect is this."""
    on, off = edit.forced_on - {name}, edit.forced_off - {name}
    return {"forced_on": on | {name} if wish else on, "forced_off": off | {name} if wish is False else off}


def _row(state: EditorState, effect: Effect) -> None:
    em = imgui.get_font_size()
    corner = imgui.get_cursor_screen_pos()
    width = imgui.get_content_region_avail().x
    middle = imgui.ImVec2(corner.x + 0.35 * em, corner.y + 0.55 * em)
    imgui.get_window_draw_list().add_circle_filled(middle, 0.22 * em, theme.packed(_DOTS[effect.state]), 16)
    imgui.dummy(imgui.ImVec2(0.7 * em, em))
    imgui.same_line()
    imgui.text(title(effect))
    wish = state.edit.forced(effect.name)
    button_width = 2.8 * em
    imgui.same_line(width - button_width)
    imgui.push_style_var(imgui.StyleVar_.frame_padding, imgui.ImVec2(2.0, 0.0))
    if widgets.toggle(f"{_WORDS[wish]}##{effect.name}", wish is not None, button_width):
        state.change(**forced(state.edit, effect.name, _NEXT[wish]))
    imgui.pop_style_var()
    imgui.set_item_tooltip("auto: the plan decides. on: computed in any case. off: left out. Click to change.")
    imgui.push_font(None, 0.85 * theme.FONT_PX)
    imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*theme.DIM))
    imgui.push_text_wrap_pos(0.0)
    imgui.indent(0.9 * em)
    imgui.text_wrapped(explanation(effect))
    imgui.unindent(0.9 * em)
    imgui.pop_text_wrap_pos()
    imgui.pop_style_color()
    imgui.pop_font()
