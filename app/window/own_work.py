"""The work of its own that a photo of a batch has: of this run, else the newest session that was saved of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from app.document.document import Document
from app.document.session_file import read_session, saved_session
from app.ui.photo_works import is_worked_on, work_left
from app.ui.state import EditorState
from relight_core.errors import InputError


def own_work(state: EditorState, photo: Path) -> Document | Path | None:
    """A photo's work as it was left in this run, or the session file that holds it; None where there is neither.

    A photo that was only looked at, under the settings of another, goes by its session, too, unless that was put aside.
    """
    if not is_worked_on(state, photo) and photo.absolute() not in state.started_afresh:
        saved = saved_session(photo)
        if saved is not None:
            return saved
    return work_left(state, photo)


def document_of(work: Document | Path, photo: Path) -> Document:
    """The document of a photo's own work.

    Raises:
        InputError: its session can't be used, or the light of that is gone.
    """
    if isinstance(work, Document):
        return work
    session = read_session(work)
    if session.lost_light is not None:
        raise InputError(f"{work}: {session.lost_light}; open it and choose a light")
    return replace(session.document, photo=replace(session.document.photo, path=photo))
