"""The actions for looking at the picture."""

from __future__ import annotations

from app.ui.actions import Action, Gesture
from app.ui.state import CHANNELS, PHOTO, EditorState
from app.ui.view import View
from app.ui.viewport_panel import ZOOM_PER_STEP, zoom_by

_LOOK, _PICTURES, _PANELS = "Look", "Pictures", "Panels"


def _opened(state: EditorState) -> bool:
    return state.snapshot.opened is not None


def _relit(state: EditorState) -> bool:
    return state.snapshot.picture is not None


def _fit(state: EditorState) -> None:
    state.view = View()


def _set_before(down: bool):
    def run(state: EditorState) -> None:
        state.before = down

    return run


def _show(name: str):
    def run(state: EditorState) -> None:
        state.shown = name

    return run


def _showing(name: str):
    return lambda state: state.shown == name


LOOKING = (
    Action("Fit the picture", _LOOK, ("F",), "The whole picture, as large as the window allows", _fit),
    Action(
        "Zoom in",
        _LOOK,
        ("=", "Shift+="),
        "Larger, about the mouse",
        lambda state: zoom_by(state, ZOOM_PER_STEP),
        available=_opened,
        repeats=True,
    ),
    Action(
        "Zoom out",
        _LOOK,
        ("-",),
        "Smaller, about the mouse",
        lambda state: zoom_by(state, 1.0 / ZOOM_PER_STEP),
        available=_opened,
        repeats=True,
    ),
    Action(
        "See the photo",
        _LOOK,
        ("Space",),
        "The photo as it was, while the key is held",
        _set_before(True),
        let_go=_set_before(False),
    ),
)

SHOWING = tuple(
    Action(
        f"Show {title.lower()}",
        _PICTURES,
        (str(number),),
        explanation.rstrip("."),
        _show(name),
        available=_opened if name == PHOTO else _relit,
        is_on=_showing(name),
    )
    for number, (name, title, explanation) in enumerate(CHANNELS, 1)
)


def _switch_panel(name: str):
    def run(state: EditorState) -> None:
        state.panels = state.panels.switched(name)

    return run


def _panel_shown(name: str):
    return lambda state: getattr(state.panels, name)


def _switch_panels(state: EditorState) -> None:
    state.panels = state.panels.all_shown(not state.panels.any_shown)


PANELS = (
    Action(
        "Only the picture",
        _PANELS,
        ("Tab",),
        "Hides every panel; once more brings them back",
        _switch_panels,
        is_on=lambda state: not state.panels.any_shown,
    ),
    Action(
        "Filmstrip", _PANELS, ("F6",), "Shows or hides it", _switch_panel("filmstrip"), is_on=_panel_shown("filmstrip")
    ),
    Action("Light panel", _PANELS, ("F7",), "Shows or hides it", _switch_panel("light"), is_on=_panel_shown("light")),
    Action(
        "Effects panel", _PANELS, ("F8",), "Shows or hides it", _switch_panel("effects"), is_on=_panel_shown("effects")
    ),
)

GESTURES = (
    Gesture("Ctrl + wheel", _LOOK, "Zoom about the mouse"),
    Gesture("Drag the picture", _LOOK, "Move it"),
    Gesture("Double-click the picture", _LOOK, "Fit it to the window"),
    Gesture("Drag a panel's edge", _PANELS, "Resize it; a double click puts it back"),
)
