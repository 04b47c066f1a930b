"""The actions that change the picture or save it."""

from __future__ import annotations

from collections.abc import Callable

from app.ui import face_edits, light_edits
from app.ui.actions.action import Action, Gesture, has_photo, has_picture
from app.ui.panels.panorama import add_next_box
from app.ui.state import EditorState

_LIGHT, _EDIT, _FILE = "Light and effects", "Edit", "File"


def _turn(degrees: float) -> Callable[[EditorState], None]:
    return lambda state: state.turn(degrees)


def _export(state: EditorState, suffix: str | None = None) -> None:
    state.export_wanted = suffix or state.export.form


def _aim(aim: str) -> Callable[[EditorState], None]:
    return lambda state: light_edits.switch_aim(state, aim)


def _delete(state: EditorState) -> None:
    """What is worked on: a face's box, else a soft box."""
    if state.faces.is_open:
        face_edits.remove(state)
    else:
        light_edits.delete_box(state)


def _can_delete(state: EditorState) -> bool:
    if state.faces.is_open:
        return state.faces.selected >= 0
    return light_edits.has_box(state)


def _raise(name: str, key: str, degrees: float) -> Action:
    return Action(
        name,
        _LIGHT,
        (key,),
        f"The soft box that is selected, by {abs(degrees):.0f}°",
        lambda state: light_edits.raise_box(state, degrees),
        available=light_edits.has_box,
        repeats=True,
    )


def _step(name: str, key: str, by: int) -> Action:
    return Action(
        name,
        _FILE,
        (key,),
        "Of those that were opened together",
        lambda state: state.step_photo(by),
        available=lambda state: state.queue.step(by) is not None,
    )


def _wish(kind: str) -> Callable[[EditorState], None]:
    return lambda state: state.asking.wish(kind)


LIGHT = (
    Action(
        "Play the rotation",
        _LIGHT,
        ("P",),
        "The light turns by itself until you stop it",
        lambda state: setattr(state, "playing", not state.playing),
        available=lambda state: state.playing or has_picture(state),
        is_on=lambda state: state.playing,
    ),
    Action("Turn the panorama left", _LIGHT, ("Left",), "Turn it by 5°", _turn(-5.0), repeats=True),
    Action("Turn the panorama right", _LIGHT, ("Right",), "Turn it by 5°", _turn(5.0), repeats=True),
    Action("Nudge the panorama left", _LIGHT, ("Shift+Left",), "Turn it by 1°", _turn(-1.0), repeats=True),
    Action("Nudge the panorama right", _LIGHT, ("Shift+Right",), "Turn it by 1°", _turn(1.0), repeats=True),
    Action(
        "Meter the light",
        _LIGHT,
        ("A",),
        "A panorama as bright as a photo wants it, or at the level its file gives",
        light_edits.meter_light,
        available=lambda state: state.light.kind == "panorama",
        is_on=lambda state: state.light_edit.metered,
    ),
    Action(
        "Match the light to the face",
        _LIGHT,
        ("Shift+A",),
        "A level that leaves the face as bright as in the photo, where the light falls on it",
        _wish("match_face"),
        available=has_picture,
    ),
    Action("Reset all", _LIGHT, ("Ctrl+R",), "Put every slider and the light back", EditorState.reset),
)

BOXES = (
    Action(
        "Add a soft box",
        _LIGHT,
        ("N",),
        "A lamp of your own, on the panorama",
        add_next_box,
    ),
    Action(
        "Place the highlight",
        _LIGHT,
        ("K",),
        "Then click on the face where the shine should be",
        _aim("highlight"),
        available=has_picture,
        is_on=lambda state: state.aim.target == "highlight",
    ),
    Action(
        "Place the bright side",
        _LIGHT,
        ("B",),
        "Then click on the face where it should be brightest",
        _aim("bright"),
        available=has_picture,
        is_on=lambda state: state.aim.target == "bright",
    ),
    Action(
        "Move the light's own lamps",
        _LIGHT,
        ("M",),
        "As soft boxes; again puts them back where they were",
        light_edits.switch_lamps,
        available=light_edits.has_lamps,
        is_on=lambda state: state.light_edit.apart,
    ),
    Action(
        "Switch the soft box off or on",
        _LIGHT,
        ("Shift+M",),
        "The one that is selected, to see what it does",
        light_edits.switch_box,
        available=light_edits.has_box,
    ),
    _raise("Raise the soft box", "Up", 5.0),
    _raise("Lower the soft box", "Down", -5.0),
    _raise("Nudge the soft box up", "Shift+Up", 1.0),
    _raise("Nudge the soft box down", "Shift+Down", -1.0),
    Action(
        "Delete the box",
        _LIGHT,
        ("Delete",),
        "The soft box that is selected, or the face's while the face boxes are in sight",
        _delete,
        available=_can_delete,
    ),
    Action(
        "Remove all soft boxes",
        _LIGHT,
        ("Shift+Delete",),
        "Leaves the light without them",
        light_edits.delete_boxes,
        available=lambda state: bool(state.light_edit.boxes),
    ),
)

HISTORY = (
    Action(
        "Undo",
        _EDIT,
        ("Ctrl+Z",),
        "Take the last step back",
        light_edits.undo,
        available=light_edits.can_undo,
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
    Action(
        "Export as", _FILE, ("Ctrl+E",), "Choose where to save the picture", _wish("export_as"), available=has_picture
    ),
    Action(
        "Copy the picture", _FILE, ("Ctrl+C",), "To paste it elsewhere", _wish("copy_picture"), available=has_picture
    ),
    Action(
        "Export a film",
        _FILE,
        ("Ctrl+T",),
        "The light turning once around, as an MP4",
        _wish("turntable_film"),
        available=has_picture,
    ),
    Action(
        "Batch over many photos",
        _FILE,
        ("Ctrl+B",),
        "Relight and export all photos of a folder, or of those opened together, like this one",
        _wish("batch"),
        available=has_picture,
    ),
    Action(
        "Batch, each photo as it was left",
        _FILE,
        ("Ctrl+Shift+B",),
        "Relight and export those opened together, each with its own light and settings",
        _wish("batch_as_left"),
        available=lambda state: has_picture(state) and len(state.queue.paths) > 1,
    ),
    Action("Open a file", _FILE, ("Ctrl+O",), "A portrait, a panorama for the light, or a session", _wish("open_file")),
    Action(
        "Open a light",
        _FILE,
        ("Ctrl+L",),
        "A panorama, a light file, or a portrait to borrow it from",
        _wish("open_light"),
    ),
    Action(
        "Save the session",
        _FILE,
        ("Ctrl+S",),
        "Beside the photo, to go on later",
        _wish("save_session"),
        available=has_photo,
    ),
    Action(
        "Save the session as",
        _FILE,
        ("Ctrl+Shift+S",),
        "Under another name",
        _wish("save_session_as"),
        available=has_photo,
    ),
    Action("Save the light", _FILE, ("Ctrl+Shift+L",), "The light alone, for other photos", _wish("save_light")),
    _step("Next photo", "PageDown", 1),
    _step("Previous photo", "PageUp", -1),
    Action(
        "Export the picture", _FILE, ("E",), "At once, as set: PNG, JPEG, TIFF or EXR", _export, available=has_picture
    ),
    Action(
        "Export an EXR",
        _FILE,
        ("Shift+E",),
        "Linear radiance for compositing, the channels as layers",
        lambda state: _export(state, ".exr"),
        available=has_picture,
    ),
)

GESTURES = (
    Gesture("Wheel over the picture", _LIGHT, "Turn the light; with Shift in small steps"),
    Gesture("Drag the panorama", _LIGHT, "Turn the light; with Shift in small steps"),
    Gesture("Double-click the panorama", _LIGHT, "Add a soft box; drag it, or its corners"),
    Gesture("Double-click a slider", _LIGHT, "Reset it"),
    Gesture("Ctrl-click a slider", _LIGHT, "Type a number"),
    Gesture("Drop files", _FILE, "Portraits and sessions open; a panorama becomes the light"),
    Gesture("Drop on the light panel", _FILE, "A portrait lends its light; so with Shift anywhere"),
)
