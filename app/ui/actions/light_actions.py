"""The lights as commands, for the palette alone: which there are changes as the editor is used, and none has a key."""

from __future__ import annotations

from app.engine.sources import LightSource
from app.ui.actions.action import Action
from app.ui.light_list import Shelf, lights_to_choose
from app.ui.state import EditorState


def light_actions(state: EditorState, shelf: Shelf) -> tuple[Action, ...]:
    """One for each light that can be chosen now, in the order of the light panel."""
    return tuple(_use(light, words) for light, words in lights_to_choose(state, shelf))


def _use(light: LightSource, words: str) -> Action:
    return Action(
        f"Light: {light.title}",
        "Light",
        (),
        words.rstrip(".") or "A bundled light",
        lambda state: state.choose_light(light),
        is_on=lambda state: light.same_as(state.light),
    )
