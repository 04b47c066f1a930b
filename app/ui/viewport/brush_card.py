"""The card over the picture while the brush corrects the people's outline."""

from __future__ import annotations

from app.ui import brush_edits
from app.ui.layout import Rect
from app.ui.state import EditorState
from app.ui.viewport import tool_card
from app.ui.viewport.tool_card import Button

_ADDS = "Paint over what belongs to the person and was missed."
_TAKES = "Paint over what is no part of the person."


_TO_TAKE = Button("Take away", "Let the brush take away.  X, or Alt while you paint", brush_edits.turn_over)
_TO_ADD = Button("Add", "Let the brush add.  X, or Alt while you paint", brush_edits.turn_over)
_OTHERS = (
    Button("\N{MINUS SIGN}", "A smaller brush.  Comma", lambda state: brush_edits.resize(state, -1)),
    Button("+", "A larger brush.  Period", lambda state: brush_edits.resize(state, 1)),
    Button("As found", "Forget all strokes.", brush_edits.forget, brush_edits.is_painted),
    Button("Done", "Enter.  Esc puts the outline back as it was", brush_edits.done, is_main=True),
)


def draw(state: EditorState, viewport: Rect) -> None:
    """The card, while the brush is up and does not paint."""
    tool = state.brush
    if not tool.is_open or state.snapshot.opened is None or state.picking is not None or tool.painting is not None:
        return
    buttons = (_TO_TAKE if tool.adds else _TO_ADD, *_OTHERS)
    # Heads and hats are at the top; at the foot it is in the brush's way least.
    head = viewport.x, viewport.y, viewport.x + viewport.width, viewport.y + viewport.height / 2
    tool_card.draw(state, "brush", _ADDS if tool.adds else _TAKES, buttons, viewport, [head])
