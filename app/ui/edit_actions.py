"""The actions that change the picture or save it."""

from __future__ import annotations

from app.ui.actions import Action, Gesture
from app.ui.state import EditorState

_LIGHT, _EDIT, _FILE = "Light and effects", "Edit", "File"


def _turn(degrees: float):
    return lambda state: state.turn(degrees)


def _save(suffix: str):
    def run(state: EditorState) -> None:
        state.export_wanted = suffix

    return run


def _relit(state: EditorState) -> bool:
    return state.snapshot.picture is not None


LIGHT = (
    Action("Turn the light left", _LIGHT, ("Left",), "Turn it by 5°", _turn(-5.0), repeats=True),
    Action("Turn the light right", _LIGHT, ("Right",), "Turn it by 5°", _turn(5.0), repeats=True),
    Action("Nudge the light left", _LIGHT, ("Shift+Left",), "Turn it by 1°", _turn(-1.0), repeats=True),
    Action("Nudge the light right", _LIGHT, ("Shift+Right",), "Turn it by 1°", _turn(1.0), repeats=True),
    Action("Reset all", _LIGHT, ("Ctrl+R",), "Put every slider and the light back", EditorState.reset),
)

HISTORY = (
    Action(
        "Undo",
        _EDIT,
        ("Ctrl+Z",),
        "Take the last step back",
        lambda state: state.restore(state.history.undo()),
        available=lambda state: state.history.can_undo,
        repeats=True,
    ),
    Action(
        "Redo",
        _EDIT,
        ("Ctrl+Shift+Z", "Ctrl+Y"),
        "Do again what was taken back",
        lambda state: state.restore(state.history.redo()),
        available=lambda state: state.history.can_redo,
        repeats=True,
    ),
)

FILE = (
    Action("Save a PNG", _FILE, ("E",), "The picture as you see it, 8 bits", _save(".png"), available=_relit),
    Action(
        "Save an EXR",
        _FILE,
        ("Shift+E",),
        "Linear radiance for compositing, the channels in a second file",
        _save(".exr"),
        available=_relit,
    ),
)

GESTURES = (
    Gesture("Wheel over the picture", _LIGHT, "Turn the light; with Shift in small steps"),
    Gesture("Drag the panorama", _LIGHT, "Turn the light"),
    Gesture("Double-click a slider", _LIGHT, "Reset it"),
    Gesture("Ctrl-click a slider", _LIGHT, "Type a number"),
    Gesture("Drop a file", _FILE, "A portrait opens; an .hdr or .exr becomes the light"),
    Gesture("Drop on the light panel", _FILE, "A portrait lends its light"),
)
