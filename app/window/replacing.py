"""Writing where something may be already: the user is asked, and what was not agreed to replaces nothing."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from app.document.json_fields import is_place_for
from app.engine.exporting import free_path
from app.ui.asking import Asking, Question
from relight_core.errors import InputError


def write_or_ask(
    asking: Asking, path: Path, write: Callable[[Path, bool], None], free: Callable[[Path], Path] = free_path
) -> None:
    """Write to a path, after asking where something is there already.

    Args:
        write: given the path, and whether the user agreed to replace what is there. Without that it writes under a
            free name where one was taken since.
        free: the name beside one that is taken.
    """
    if not os.path.lexists(path):
        tried(asking, lambda: write(path, False))
        return
    choices = (
        ("Keep both", lambda: tried(asking, lambda: write(free(path), False))),
        ("Replace", lambda: tried(asking, lambda: write(path, True))),
        ("Cancel", lambda: None),
    )
    text = f"{path.name} is already there, in {path.absolute().parent}."
    asking.ask(Question(f"replace {path}", text, choices, calling_off="Cancel"))


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
