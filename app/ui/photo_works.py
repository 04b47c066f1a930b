"""The work on each photo of this run: kept aside while another photo is open, and found again when it comes back."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from app.document.document import Document, PhotoRef
from app.engine.sources import PhotoSource
from app.ui.falling_back import give_up_what_is_on_its_way
from app.ui.open_work import KeptWork, Undoing

if TYPE_CHECKING:
    from app.ui.state import EditorState


def portrait_of(state: EditorState, path: Path) -> PhotoRef:
    """A photo with its choice of face, boxes and strokes: as wanted now, else as it was left in this run."""
    if _is_wanted(state, path):
        return replace(state.document().photo, path=path)
    work = _work_at(state, path)
    if work is None or work.is_refused:
        return PhotoRef(path)
    return replace(work.left.photo, path=path)


def wish_of(state: EditorState, path: Path) -> PhotoSource:
    """A wish to read a photo's file, with its faces as of `portrait_of`."""
    return portrait_of(state, path).wish()


def work_left(state: EditorState, path: Path) -> Document | None:
    """The work on a photo as it is set now, else as it was left in this run; None if it was not opened.

    While a photo is shown with the settings of another, this is its own work, which waits for the user's answer.
    """
    work, is_wanted = _work_at(state, path), _is_wanted(state, path)
    if is_wanted and state.is_at_work():
        left = state.waiting.left if is_waiting(state) else state.document()
    elif is_wanted and (_is_put_back(state) or work is None or not work.is_work):
        left = state.document()
    else:
        left = work and work.left
    return left and replace(left, photo=portrait_of(state, path))


def is_worked_on(state: EditorState, path: Path) -> bool:
    """Whether a photo has work of its own in this run, and was not just looked at with the settings of another."""
    work, is_wanted = _work_at(state, path), _is_wanted(state, path)
    if is_wanted and state.is_at_work():
        return is_waiting(state) or state.session_path is not None or state.is_unsaved()
    return (is_wanted and _is_put_back(state)) or (work is not None and work.is_work)


def unsaved_work(state: EditorState, path: Path) -> Document | None:
    """The work on a photo, whether it is open or not, that no session file holds; None if there is none."""
    if not (_is_wanted(state, path) and state.is_at_work()):
        work = _work_at(state, path)
    else:
        work = state.waiting if is_waiting(state) else KeptWork(state.session_path, state.kept, state.document())
    return work.left if work is not None and work.left != work.document else None


def note_left(state: EditorState) -> None:
    """Remember the open photo and the work on it; to be called before another photo is asked for."""
    if state.is_at_work():
        state.photo_left = state.photo
    if state.kept is None or not state.is_at_work() or state.photo.path is None:
        return
    work = KeptWork(state.session_path, state.kept, state.document())
    state.works[state.photo.path.absolute()] = state.waiting if is_waiting(state) else work


def is_waiting(state: EditorState) -> bool:
    """Whether the open photo's own work waits for the user's answer, and nothing was changed since."""
    return state.waiting is not None and not state.is_unsaved()


def begin_work(state: EditorState) -> None:
    """A photo has been opened: from now on, changes are work on it.

    The light and the sliders may be those of the photo before. If the photo has work of its own with other settings,
    that work is put into `waiting`, and saving does not go to its session file.
    """
    source = state.photo if state.is_at_work() else state.snapshot.opened.source
    before, state.work_on = state.work_on, source.path and source.path.absolute()
    if state.opening and state.opening.wish is source:
        kept, state.opening = state.opening.kept, None
        state.session_path, state.kept, state.waiting = kept.session_path, kept.document, None
        return
    if state.work_on is not None and state.work_on == before:
        return
    _keep_what_comes_back(state, before)
    as_opened, work = _as_opened(state, source), _work_on(state, source)
    state.session_path, state.kept, state.waiting = None, as_opened, None
    if work is None or not work.is_work:
        return
    if _is_undone(state, source) or work.left == as_opened:
        state.session_path, state.kept = work.session_path, work.document
    else:
        state.waiting = work


def _keep_what_comes_back(state: EditorState, before: Path | None) -> None:
    """Keep the work on the photo that was open, if that photo is wanted again: the user undid while this one was read.

    It will be read again, and what was set on it until then is its own work.
    """
    wanted = state.photo and state.photo.path
    if wanted is None or wanted.absolute() != before or state.kept is None or state.undoing or is_waiting(state):
        return
    state.works[before] = KeptWork(state.session_path, state.kept, state.document())
    state.undoing = Undoing(state.history.at, state.photo, state.light)


def resume(state: EditorState, work: KeptWork) -> None:
    """Continue the work on a photo as it was left."""
    give_up_what_is_on_its_way(state)
    state.put_back(work.left)
    if state.is_at_work():
        state.session_path, state.kept, state.waiting = work.session_path, work.document, None


def session_of_photo(state: EditorState) -> tuple[Path, Document] | None:
    """The session file of the wanted photo, whether that is open yet or not, and the document that the file holds.

    None if this run knows of no such file, or if the file holds other work than what is set now.
    """
    if state.is_at_work():
        return (state.session_path, state.kept) if state.session_path is not None else None
    work = _work_on(state, state.photo)
    goes_on = work is not None and (_is_undone(state, state.photo) or work.left == state.document())
    return (work.session_path, work.document) if goes_on and work.session_path is not None else None


def note_saved(state: EditorState, path: Path, document: Document) -> None:
    """Note that a session file holds this document now, whichever photo is open meanwhile."""
    photo = document.photo.path.absolute()
    known = state.works.get(photo)
    left = document if known is None or _is_wanted(state, photo) else known.left
    state.works[photo] = KeptWork(path, document, left)
    if photo == state.work_on:
        state.session_path, state.kept, state.waiting = path, document, None


def _work_at(state: EditorState, path: Path) -> KeptWork | None:
    return state.works.get(path.absolute())


def _is_wanted(state: EditorState, path: Path) -> bool:
    wanted = state.photo and state.photo.path
    return wanted is not None and wanted.absolute() == path.absolute()


def _is_put_back(state: EditorState) -> bool:
    """Whether the wanted photo comes with settings of its own, from a session or from the history."""
    comes_with_session = state.opening is not None and state.opening.wish is state.photo
    return comes_with_session or _is_undone(state, state.photo)


def _work_on(state: EditorState, photo: PhotoSource | None) -> KeptWork | None:
    if photo is None or photo.path is None:
        return None
    work = _work_at(state, photo.path)
    return work and work.named(photo.path)


def _is_undone(state: EditorState, photo: PhotoSource) -> bool:
    """Whether a wish came from the history, which restores the settings of that photo itself."""
    return state.undoing is not None and state.undoing.photo is photo


def _as_opened(state: EditorState, source: PhotoSource) -> Document:
    """The document of a photo that has just been opened, even if another is wanted by now."""
    photo = PhotoRef.of(source, source.path) if source.path else None
    return replace(state.document(), photo=photo)
