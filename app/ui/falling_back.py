"""What the editor returns to when a photo or a light that was asked for is refused."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from app.document.document import Document, LightRef
from app.ui.light_wish import light_that_stays, with_added

if TYPE_CHECKING:
    from app.ui.state import EditorState


def fall_back(state: EditorState) -> None:
    """Replace refused wishes by what is in force; an undo or redo that led to one is reverted as a whole."""
    snapshot, undoing = state.snapshot, state.undoing
    if snapshot.coming is not None and snapshot.coming.source is state.photo:
        state.opened_queue = state.queue
    if undoing is not None and undoing.is_refused(state.photo, state.light, snapshot.refused):
        _take_undoing_back(state)
    if state.photo in snapshot.refused:
        _note_refused(state)
        give_up_what_is_on_its_way(state)
        # The first photo may still be on its way, and then it is what remains.
        remaining = snapshot.opened or snapshot.coming
        state.queue = state.queue.refused(state.opened_queue, remaining and remaining.source.path)
        state.photo = remaining.source if remaining else None
        if state.photo_left is not None and snapshot.opened is not None and snapshot.opened.shows(state.photo_left):
            # The open photo's source lacks strokes and boxes that were made just before and are in no picture yet.
            state.photo = state.photo_left
    if state.light in snapshot.refused:
        lost = LightRef.of(state.light)
        _take_light_back(state)
        if state.document().light != lost:
            _let_session_keep(state, lost)
    if snapshot.light is not None and snapshot.light.source is state.light:
        state.light_wish = None


def _take_light_back(state: EditorState) -> None:
    stays, light = light_that_stays(state), state.snapshot.light
    if stays.light not in state.snapshot.refused:
        state.light = stays.light
        state.take_light_edit(stays.edit)
        state.change(yaw_deg=stays.yaw_deg)
        return
    state.light = light.source if light else Document().light.source()
    state.take_light_edit(
        with_added(light.edit, state.light_edit) if light else state.light.opened_around(state.light_edit)
    )


def _let_session_keep(state: EditorState, lost: LightRef) -> None:
    """Stop saving to the session's file, so that saving asks before the file loses the name of the refused light."""
    if state.opening is not None and state.opening.document.light == lost:
        state.opening = replace(state.opening, path=None)
    elif state.kept is not None and state.kept.light == lost:
        state.session_path = None


def give_up_what_is_on_its_way(state: EditorState) -> None:
    """Undo what a session or a step of the history that isn't there yet has set: it is no work on the open photo."""
    undoing, is_there = state.undoing, (state.is_at_work(), state.is_in_force())
    if state.opening and state.opening.wish is state.photo:
        state.put_back(replace(state.opening.before, photo=None))
    elif undoing and undoing.is_coming(state.photo, state.light, *is_there):
        _take_undoing_back(state)
    state.opening = state.undoing = None


def _note_refused(state: EditorState) -> None:
    """Note that a photo can't be opened as it was left; next time its faces are found again."""
    path = state.photo.path
    if path is not None and path.absolute() in state.works and not state.is_at_work():
        state.works[path.absolute()] = replace(state.works[path.absolute()], is_refused=True)


def _take_undoing_back(state: EditorState) -> None:
    step, state.undoing = state.undoing.step, None
    if 0 <= step < len(state.history.steps):
        state.put_step_back(state.history.go(step))
