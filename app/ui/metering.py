"""The exposure: set by hand, or following the light, so that each light that is chosen is metered."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from app.engine.snapshot import Picture

if TYPE_CHECKING:
    from app.ui.state import EditorState

_SAME_EV = 0.005
"""Exposures nearer than this read the same."""


@dataclass(frozen=True)
class Metering:
    """Who sets the exposure.

    Attributes:
        follows: the light does, each time another is chosen; else the hand has.
        due: the light that was asked for has still to be metered, once it is there.
    """

    follows: bool = True
    due: bool = False


def metered_ev(state: EditorState) -> float:
    """What the meter says of the light in force: the exposure at which the slider rests."""
    return state.snapshot.light.metered_ev if state.snapshot.light else 0.0


def expose(state: EditorState, exposure_ev: float) -> None:
    """Set the exposure by hand; put back to where it rests, it follows the light again."""
    rest_ev = metered_ev(state)
    if abs(exposure_ev - rest_ev) < _SAME_EV:
        follow_light(state, True)
    elif exposure_ev != state.edit.exposure_ev:
        state.metering = Metering(False)
        state.change(exposure_ev=exposure_ev)


def follow_light(state: EditorState, follows: bool) -> None:
    """Let the exposure follow the light from now on, or stay as it is."""
    state.metering = Metering(follows, due=follows)
    meter(state)


def begin(state: EditorState) -> None:
    """Another light was asked for."""
    state.metering = Metering(state.metering.follows, due=state.metering.follows)


def meter(state: EditorState) -> None:
    """Expose for the light that was asked for if that is due, and it is there.

    Its level, colour, blur and soft boxes are meant to be seen, and not metered away.
    """
    light = state.snapshot.light
    if not state.metering.due or light is None or not state.light.same_as(light.source):
        return
    is_kept = state.document() == state.kept
    state.metering = Metering()
    state.change(exposure_ev=light.metered_ev)
    if is_kept:
        # Nobody's work, such as for the light that the window was opened with.
        state.kept = state.document()


def exposure_in_sight(state: EditorState) -> float:
    """The exposure of the picture on the screen: one that follows the light changes only with the picture."""
    picture = state.snapshot.picture
    if state.metering.follows and picture is not None and not state.light.same_as(picture.light.source):
        return picture.light.metered_ev
    return state.edit.exposure_ev


def exposure_when_finished(state: EditorState) -> Callable[[Picture], float]:
    """The exposure of the picture that is wanted now, to be asked once that picture is there."""
    is_due, exposure_ev = state.metering.due, state.edit.exposure_ev
    return lambda picture: picture.light.metered_ev if is_due else exposure_ev


def metering_note(state: EditorState) -> str:
    """What was metered, for the status line; empty where nothing was."""
    light = state.snapshot.light
    if not state.metering.follows or state.metering.due or light is None or light.source.kind != "panorama":
        return ""
    stops = f"{state.edit.exposure_ev:+.1f}".replace("-", "\N{MINUS SIGN}")
    return f"Exposure {stops} EV, metered for {light.source.title}"
