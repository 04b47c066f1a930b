"""The quality tiers with what each costs on this machine, and the frame budget of "auto"."""

from __future__ import annotations

from imgui_bundle import imgui

from app.ui import theme, widgets
from app.ui.panels import plan_panel
from app.ui.panels.groups import group
from app.ui.state import EditorState
from relight_core.pipeline.auto_quality import AUTO, QualityChoice, TierCost

TIERS = (
    (AUTO, "Auto", "The finest picture at rest; while something moves, the finest that keeps up with the hand."),
    ("draft", "Draft", "No network looks at a new light: shadows from the shape of the face alone."),
    ("live", "Live", "Small networks look at every new light."),
    ("final", "Final", "The photo is read four times, and large networks look at every new light."),
)
BUDGET = widgets.Slider(
    "Frame budget",
    8.0,
    120.0,
    33.0,
    "%.0f ms",
    "How long a picture may take while something moves; Auto chooses its quality by it.",
)


def draw(state: EditorState, fonts: theme.Fonts) -> None:
    """The heading, the tiers, and their costs below them, inside a panel."""
    choice, costs = state.quality, state.snapshot.tier_costs
    if not group(state, fonts, "quality", "Quality", _summary(choice, costs))[0]:
        return
    corner = imgui.get_cursor_screen_pos()
    width = imgui.get_content_region_avail().x
    # In one row, however narrow, since the costs stand below it.
    wish = widgets.segmented(TIERS, choice.wish, most_in_row=len(TIERS))
    _costs(costs, corner.x, width, choice.moving(costs))
    budget_ms = choice.budget_ms
    if wish == AUTO:
        budget_ms = _budget(state, budget_ms)
    state.quality = QualityChoice(wish, budget_ms)
    plan_panel.draw(state)


def _summary(choice: QualityChoice, costs: dict[str, TierCost]) -> str:
    """The choice, and what it means while something moves."""
    title = next(title for name, title, _ in TIERS if name == choice.wish)
    return f"{title}: {choice.moving(costs)} in motion" if choice.wish == AUTO and costs else title


def _budget(state: EditorState, budget_ms: float) -> float:
    """The slider; it changes no picture, so the engine need not hurry while it is dragged."""
    hand = state.hand_on_control
    budget_ms = widgets.slider(state, BUDGET, budget_ms)
    state.hand_on_control = hand
    return budget_ms


def _costs(costs: dict[str, TierCost], left: float, width: float, in_use: str) -> None:
    """Milliseconds and error of each tier, centred below its button; the tier in use while moving is lit."""
    if not costs:
        imgui.text_disabled("Measured when at rest")
        return
    imgui.push_font(None, 0.85 * theme.FONT_PX)
    line = imgui.get_text_line_height()
    top = imgui.get_cursor_screen_pos().y
    column = width / len(TIERS)
    for index, (name, _, _) in enumerate(TIERS):
        colour = theme.TEXT if name == in_use else theme.DIM
        for row, text in enumerate(cost_lines(name, costs)):
            x = left + (index + 0.5) * column - imgui.calc_text_size(text).x / 2
            place = imgui.ImVec2(x, top + row * line)
            imgui.get_window_draw_list().add_text(place, theme.packed(colour), text)
    imgui.dummy(imgui.ImVec2(width, 2 * line))
    imgui.set_item_tooltip(
        "On this machine, as Auto uses them in motion: how long a picture takes after the light has turned,\n"
        "and how far it is from the final one, of 255. Draft and Live chosen by themselves are further off,\n"
        "as they read the photo once, where Auto has read it as Final does."
    )
    imgui.pop_font()


def cost_lines(name: str, costs: dict[str, TierCost]) -> tuple[str, ...]:
    """What stands below a tier: its milliseconds, and its error of 255."""
    cost = costs.get(name)
    if cost is None:
        return ()
    error = "best" if cost.error == 0 else f"±{255 * cost.error:.1f}"
    return f"{cost.ms:.0f} ms", error
