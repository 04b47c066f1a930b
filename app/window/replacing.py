"""Asking before a file or unsaved work is replaced."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from app.document.document import Document
from app.document.json_fields import is_place_for
from app.engine.exporting import free_path
from app.ui.asking import Asking, Question
from app.ui.photo_works import unsaved_work
from app.ui.state import EditorState
from relight_core.errors import InputError
from relight_core.imaging.files import legible


def write_or_ask(
    asking: Asking,
    path: Path,
    write: Callable[[Path, bool], None],
    free: Callable[[Path], Path] = free_path,
    there: str = "",
) -> None:
    """Write to a path, after asking if something is there already.

    Args:
        write: gets the path, and whether the user agreed to replace what is there. If not, it chooses a free name in
            case the path has been taken meanwhile.
        free: gives a free name beside one that is taken.
        there: the question's text; by default that the file is there already.
    """
    if not os.path.lexists(path):
        tried(asking, lambda: write(path, False))
        return
    choices = (
        ("Keep both", lambda: tried(asking, lambda: write(free(path), False))),
        ("Replace", lambda: tried(asking, lambda: write(path, True))),
        ("Cancel", lambda: None),
    )
    text = there or f"{path.name} is already there, in {path.absolute().parent}."
    asking.ask(Question(f"replace {path}", text, choices, calling_off="Cancel"))


def put_or_ask(
    state: EditorState, document: Document, source: str, put: Callable[[], None], keep: Callable[[], None]
) -> None:
    """Replace the work on a photo by a document, after asking if there is other work on it that is not saved.

    Args:
        source: name of what the document comes from; another question about the same source replaces this one.
        put: replaces the work.
        keep: called if the user keeps the work that is there.
    """
    path = document.photo.path
    work = unsaved_work(state, path)
    if work is None or replace(work, photo=replace(work.photo, path=path)) == document:
        put()
        return
    text = f"The work on {legible(path.name)} is not saved, and this would take its place."
    choices = (("Keep the work", keep), ("Replace it", lambda: tried(state.asking, put)))
    state.asking.ask(Question(f"replace work by {source}", text, choices, calling_off="Keep the work"))


def check_place(path: Path, kind: str) -> None:
    """Refuse to replace anything but a file of the same kind, "session" or "light".

    Raises:
        InputError: something else is there.
    """
    if not is_place_for(path, kind):
        raise InputError(f"{path}: is not a {kind}; relight replaces only its own files, choose another name")


def tried(asking: Asking, act: Callable[[], None]) -> None:
    """Do something; an InputError becomes a message."""
    try:
        act()
    except InputError as error:
        asking.tell(str(error), True)
