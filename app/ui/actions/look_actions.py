"""The actions for looking at the picture."""

from __future__ import annotations

from collections.abc import Callable

from app.ui.actions.action import Action, Gesture, has_photo, has_picture
from app.ui.channels import CHANNELS, PHOTO, RESULT, Channel
from app.ui.layout import Panels
from app.ui.state import EditorState
from app.ui.viewport.panes import can_compare
from app.ui.viewport.viewport_panel import ZOOM_PER_STEP, fit, toggle_actual_size, zoom_by

_LOOK, _PICTURES, _READ, _PANELS = "Look", "Pictures", "Read", "Panels"


def _set_before(down: bool) -> Callable[[EditorState], None]:
    def run(state: EditorState) -> None:
        state.before = down

    return run


LOOKING = (
    Action("Fit the picture", _LOOK, ("F",), "The whole picture, as large as the window allows", fit),
    Action(
        "Zoom in",
        _LOOK,
        ("=", "Shift+="),
        "Larger, about the mouse",
        lambda state: zoom_by(state, ZOOM_PER_STEP),
        available=has_photo,
        repeats=True,
    ),
    Action(
        "Zoom out",
        _LOOK,
        ("-",),
        "Smaller, about the mouse",
        lambda state: zoom_by(state, 1.0 / ZOOM_PER_STEP),
        available=has_photo,
        repeats=True,
    ),
    Action(
        "Actual size",
        _LOOK,
        ("Z",),
        "One photo pixel on one screen pixel, where the mouse is; once more fits the picture",
        toggle_actual_size,
        available=has_photo,
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


def _switch(name: str, key: str, title: str, help_text: str, tells_of: tuple[str, ...] = ()) -> Action:
    """A switch; what tells of certain pictures only brings the first of them into sight where none is."""

    def run(state: EditorState) -> None:
        state.look.switch(name)
        if tells_of and getattr(state.look, name) and state.shown not in tells_of:
            state.shown = tells_of[0]

    return Action(title, _READ, (key,), help_text, run, is_on=lambda state: getattr(state.look, name))


def _choose(
    field: str,
    value: str,
    key: str,
    title: str,
    group: str,
    help_text: str,
    available: Callable[[EditorState], bool] = lambda state: True,
) -> Action:
    return Action(
        title,
        group,
        (key,),
        help_text,
        lambda state: state.look.choose(field, value),
        available=available,
        is_on=lambda state: getattr(state.look, field) == value,
    )


COMPARING = (
    _choose(
        "compare",
        "wipe",
        "W",
        "Wipe",
        _LOOK,
        "The photo left of a line that you drag, the picture right of it",
        can_compare,
    ),
    _choose(
        "compare",
        "side",
        "Y",
        "Side by side",
        _LOOK,
        "The photo beside the picture; they move together",
        can_compare,
    ),
)

READING = (
    _switch("probe", "I", "Pixel values", "The values of every channel under the mouse"),
    _choose("scope", "histogram", "H", "Histogram", _READ, "How much of the picture is dark and how much bright"),
    _choose("scope", "waveform", "V", "Waveform", _READ, "How bright each column of the picture is"),
    _switch(
        "clipping",
        "J",
        "Clipping warning",
        "Stripes where a channel is as bright as the screen gets (red) or all are black (blue)",
    ),
    _switch("false_colour", "C", "False colour", "Specular and shadow as a scale of colours", ("specular", "shadow")),
    _switch(
        "difference",
        "D",
        "Difference to the photo",
        "Where the result is darker (blue) or brighter (orange)",
        (RESULT,),
    ),
    _switch("light_ball", "L", "Lit ball and compass", "Where the light comes from, in the picture's corner"),
    _switch("timings", "T", "Timings", "What each step of the last update took, and why it ran"),
)


def _show(channel: Channel) -> Action:
    def run(state: EditorState) -> None:
        state.shown = channel.name

    return Action(
        f"Show {channel.title.lower()}",
        _PICTURES,
        (channel.key,),
        channel.explanation.rstrip("."),
        run,
        available=_there_is(channel),
        is_on=lambda state: state.shown == channel.name,
    )


def _there_is(channel: Channel) -> Callable[[EditorState], bool]:
    if channel.name == PHOTO:
        return has_photo
    if not channel.is_rare:
        return has_picture

    def is_there(state: EditorState) -> bool:
        picture = state.snapshot.picture_in_sight
        return picture is not None and channel.name in picture.channels

    return is_there


SHOWING = tuple(_show(channel) for channel in sorted(CHANNELS, key=lambda channel: (channel.is_rare, channel.key)))


def _switch_panel(name: str, key: str, title: str) -> Action:
    def run(state: EditorState) -> None:
        state.panels = state.panels.switched(name)

    return Action(title, _PANELS, (key,), "Shows or hides it", run, is_on=_panel_shown(name))


def _panel_shown(name: str) -> Callable[[EditorState], bool]:
    return lambda state: getattr(state.panels, name)


def _switch_panels(state: EditorState) -> None:
    if state.panels.any_shown:
        state.panels_before, state.panels = state.panels, state.panels.all_shown(False)
    else:
        # None, where they were hidden one by one or in an earlier run.
        state.panels = state.panels.shown_like(state.panels_before or Panels())
        state.panels_before = None


def _move_panel(name: str, key: str, title: str) -> Action:
    def run(state: EditorState) -> None:
        state.panels = state.panels.across(name)

    return Action(title, _PANELS, (key,), "To the opposite edge of the window", run, available=_panel_shown(name))


def _reset_layout(state: EditorState) -> None:
    state.panels = Panels()


PANELS = (
    Action(
        "Only the picture",
        _PANELS,
        ("Tab",),
        "Hides every panel; once more brings them back",
        _switch_panels,
        is_on=lambda state: not state.panels.any_shown,
    ),
    _switch_panel("filmstrip", "F6", "Filmstrip"),
    _switch_panel("light", "F7", "Light panel"),
    _switch_panel("effects", "F8", "Effects panel"),
)

ARRANGING = (
    _move_panel("filmstrip", "Shift+F6", "Move the filmstrip"),
    _move_panel("light", "Shift+F7", "Move the light panel"),
    _move_panel("effects", "Shift+F8", "Move the effects panel"),
    Action("Reset the layout", _PANELS, ("F9",), "Every panel in its first place and size", _reset_layout),
)

GESTURES = (
    Gesture("Ctrl + wheel", _LOOK, "Zoom about the mouse"),
    Gesture("Drag the picture", _LOOK, "Move it; with the wheel pressed, whatever else is going on"),
    Gesture("Double-click the picture", _LOOK, "Actual size there, or fit again"),
    Gesture("Drag a panel's grip", _PANELS, "Move it to the other edge of the window; a double click does so too"),
    Gesture("Drag a panel's edge", _PANELS, "Resize it; a double click puts it back"),
)
