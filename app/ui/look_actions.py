"""The actions for looking at the picture."""

from __future__ import annotations

from app.ui.actions import Action, Gesture
from app.ui.state import CHANNELS, PHOTO, EditorState
from app.ui.view import View
from app.ui.viewport_panel import ZOOM_PER_STEP, zoom_by

_LOOK, _PICTURES = "Look", "Pictures"


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

GESTURES = (
    Gesture("Ctrl + wheel", _LOOK, "Zoom about the mouse"),
    Gesture("Drag the picture", _LOOK, "Move it"),
    Gesture("Double-click the picture", _LOOK, "Fit it to the window"),
)
