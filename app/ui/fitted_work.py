"""Work on a photo whose file has come to have another size: fitted to that when the photo opens."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from app.document.document import Document
from app.engine.resized import Size, at_size, loses_corrections, size_note, size_of
from app.ui.open_work import KeptWork
from relight_core.imaging.files import legible

if TYPE_CHECKING:
    from app.ui.state import EditorState


def fit_work(state: EditorState) -> None:
    """Fit everything that is kept of the photo that has just been opened to the size it has, and tell what changed.

    A session's file keeps what it holds. Saving asks before that loses what was left out.
    """
    opened = state.snapshot.opened
    path, size = opened.source.path, size_of(opened.photo)
    wish = state.photo if state.is_at_work() else None
    if path is not None:
        place = path.absolute()
        fit = partial(_fitted, place, size)
        state.history.refit(fit)
        if place in state.works:
            state.works[place] = _fitted_work(state.works[place], fit, size)
        if place == state.work_on and state.kept is not None:
            _fit_open_work(state, fit, size)
    note = wish and size_note(wish, size)
    if note:
        _replace_wish(state, size)
        state.asking.tell(legible(f"{wish.name}: {note}"), True)


def _fit_open_work(state: EditorState, fit: Callable[[Document], Document], size: Size) -> None:
    """The photo was open already, and has been read again."""
    work = _fitted_work(KeptWork(state.session_path, state.kept, state.kept), fit, size)
    state.session_path, state.kept = work.session_path, work.document
    state.waiting = state.waiting and _fitted_work(state.waiting, fit, size)


def _replace_wish(state: EditorState, size: Size) -> None:
    """Wish for the photo with its corrections where they belong now; what waits for it waits for that wish."""
    wish, photo = state.photo, state.snapshot.opened.photo
    state.photo = wish.on(photo)
    opening, undoing = state.opening, state.undoing
    if opening is not None and opening.wish is wish:
        path = None if loses_corrections(wish, size) else opening.path
        state.opening = replace(opening, wish=state.photo, path=path)
    if undoing is not None and undoing.photo is wish:
        state.undoing = replace(undoing, photo=state.photo)


def _fitted_work(work: KeptWork, fit: Callable[[Document], Document], size: Size) -> KeptWork:
    lost = any(one.photo is not None and loses_corrections(one.photo, size) for one in (work.left, work.document))
    document = work.document if work.session_path is not None else fit(work.document)
    return replace(work, session_path=None if lost else work.session_path, document=document, left=fit(work.left))


def _fitted(place: Path, size: Size, document: Document) -> Document:
    photo = document.photo
    if photo is None or photo.path.absolute() != place:
        return document
    return replace(document, photo=at_size(photo, size))
