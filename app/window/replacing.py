"""Where something is there already, a file or unsaved work: what the user did not agree to replaces nothing."""

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
    """Write to a path, after asking where something is there already.

    Args:
        write: given the path, and whether the user agreed to replace what is there. Without that it writes under a
            free name where one was taken since.
        free: the name beside one that is taken.
        there: what is told of that one; empty is that it is there.
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
    """Put a document in the place of the work on its photo, after asking where that is other work and not saved.

    Args:
        source: names what the document comes from; asking about the same again replaces the question.
        put: puts it there.
        keep: called where the user keeps the work that is there.
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
    """Do something, and tell why where it can't be done."""
    try:
        act()
    except InputError as error:
        asking.tell(str(error), True)
