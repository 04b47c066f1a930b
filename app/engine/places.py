"""Where the files go that are made of a photo, unless the user says otherwise."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

from relight_core.imaging.files import is_same_file

_EXPORTED = re.compile(r"(.+)-relit(?:-[0-9]+)?")


def current_folder() -> Path:
    """The current folder; the user's own where that has been deleted or its drive is gone, as happens to a window."""
    try:
        return Path.cwd()
    except OSError:
        return Path.home()


def folder_for_outputs(photo: Path) -> Path:
    """The photo's own folder; the current one where that is no place for it: not writable, or part of the program."""
    folder = photo.absolute().parent
    installed = folder.is_relative_to(Path(sys.prefix).absolute())
    return current_folder() if installed or not os.access(folder, os.W_OK | os.X_OK) else folder


def from_home(path: Path) -> Path:
    """The path with the user's own folder for a `~` that leads it; `~name` is a name like any other."""
    return Path(os.path.expanduser(path)) if path.parts[:1] == ("~",) else path


def full_path(path: Path) -> Path:
    """The path in full, as sessions name their photos: without any `..`, unless that leads out of a linked folder."""
    full = Path(os.path.abspath(path))
    return full if is_same_file(full, path) else path.absolute()


def exported_stem(path: Path) -> str | None:
    """The name, without suffix, of the photo that a file is an export of, as `exporting` names them.

    None where its name is no such one.
    """
    export = _EXPORTED.fullmatch(path.stem)
    return export and export[1]
