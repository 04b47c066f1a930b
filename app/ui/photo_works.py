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
    """Who in a photo is relit and where its faces are: as it is wished for now, else as it was left in this run."""
    if _is_wanted(state, path):
        return PhotoRef.of(state.photo, path)
    work = state.works.get(path.absolute())
    if work is None or work.is_refused:
        return PhotoRef(path)
    return replace(work.left.photo, path=path)


def wish_of(state: EditorState, path: Path) -> PhotoSource:
    """A wish to read a photo's file, with its faces as of `portrait_of`."""
    return portrait_of(state, path).wish()


def work_left(state: EditorState, path: Path) -> Document | None:
    """The work on a photo as it is set now, else as it was left in this run; None where it was not opened.

    Of a photo that came back with the settings of another it is the work of its own that waits for the user.
    """
    work, is_wanted = state.works.get(path.absolute()), _is_wanted(state, path)
    if is_wanted and state.is_at_work():
        left = state.waiting.left if is_waiting(state) else state.document()
    elif is_wanted and (_is_put_back(state) or work is None or not work.is_work):
        left = state.document()
    else:
        left = work and work.left
    return left and replace(left, photo=portrait_of(state, path))


def is_worked_on(state: EditorState, path: Path) -> bool:
    """Whether a photo has work of its own in this run: it was more than looked at under the settings of another."""
    work, is_wanted = state.works.get(path.absolute()), _is_wanted(state, path)
    if is_wanted and state.is_at_work():
        return is_waiting(state) or state.session_path is not None or state.is_unsaved()
    return (is_wanted and _is_put_back(state)) or (work is not None and work.is_work)


def unsaved_work(state: EditorState, path: Path) -> Document | None:
    """The work on a photo, be it open or left for another, that no session file holds; None where there is none."""
    if not (_is_wanted(state, path) and state.is_at_work()):
        work = state.works.get(path.absolute())
    else:
        work = state.waiting if is_waiting(state) else KeptWork(state.session_path, state.kept, state.document())
    return work.left if work is not None and work.left != work.document else None


def note_left(state: EditorState) -> None:
    """Remember the open photo and the work on it as they are; before anything else is wished for."""
    if state.is_at_work():
        state.left = state.photo
    if state.kept is None or not state.is_at_work() or state.photo.path is None:
        return
    work = KeptWork(state.session_path, state.kept, state.document())
    state.works[state.photo.path.absolute()] = state.waiting if is_waiting(state) else work


def is_waiting(state: EditorState) -> bool:
    """Whether the open photo has work of its own that was not gone on with, and none since."""
    return state.waiting is not None and not state.is_unsaved()


def begin_work(state: EditorState) -> None:
    """A photo has been opened: from here on, changes are work on it.

    The light and the sliders may be those of the photo before. Where the photo has work of its own that was left with
    others, that work waits for the user, and its session file is not the one to save to.
    """
    source = state.snapshot.opened.source
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
    """Keep the work on the photo that was open, where that one is wanted again: an undo came while this one was read.

    It will be read anew, and what was set on it until then is its own.
    """
    wanted = state.photo and state.photo.path
    if wanted is None or wanted.absolute() != before or state.kept is None or state.undoing or is_waiting(state):
        return
    state.works[before] = KeptWork(state.session_path, state.kept, state.document())
    state.undoing = Undoing(state.history.at, state.photo, state.light)


def resume(state: EditorState, work: KeptWork) -> None:
    """Go on with the work on a photo as it was left."""
    give_up_what_is_on_its_way(state)
    state.put_back(work.left)
    if state.is_at_work():
        state.session_path, state.kept, state.waiting = work.session_path, work.document, None


def session_of_photo(state: EditorState) -> tuple[Path, Document] | None:
    """The session file of the photo that is wanted, be it open yet or not, and the work as that file was left.

    None where this run knows of none, or where that file holds other work than what is set now.
    """
    if state.is_at_work():
        return (state.session_path, state.kept) if state.session_path is not None else None
    work = _work_on(state, state.photo)
    goes_on = work is not None and (_is_undone(state, state.photo) or work.left == state.document())
    return (work.session_path, work.document) if goes_on and work.session_path is not None else None


def note_saved(state: EditorState, path: Path, document: Document) -> None:
    """A session file holds this document now, whichever photo is open meanwhile."""
    photo = document.photo.path.absolute()
    known = state.works.get(photo)
    left = document if known is None or _is_wanted(state, photo) else known.left
    state.works[photo] = KeptWork(path, document, left)
    if photo == state.work_on:
        state.session_path, state.kept, state.waiting = path, document, None


def _is_wanted(state: EditorState, path: Path) -> bool:
    wanted = state.photo and state.photo.path
    return wanted is not None and wanted.absolute() == path.absolute()


def _is_put_back(state: EditorState) -> bool:
    """Whether the photo that is wanted comes with what was set on it: of a session or of the history."""
    comes_with_session = state.opening is not None and state.opening.wish is state.photo
    return comes_with_session or _is_undone(state, state.photo)


def _work_on(state: EditorState, photo: PhotoSource | None) -> KeptWork | None:
    if photo is None or photo.path is None:
        return None
    work = state.works.get(photo.path.absolute())
    return work and work.named(photo.path)


def _is_undone(state: EditorState, photo: PhotoSource) -> bool:
    """Whether a wish came of the history, which puts back what was set on that photo itself."""
    return state.undoing is not None and state.undoing.photo is photo


def _as_opened(state: EditorState, source: PhotoSource) -> Document:
    """The document of a photo that has been opened, though another may be wished for by now."""
    photo = PhotoRef.of(source, source.path) if source.path else None
    return replace(state.document(), photo=photo)
