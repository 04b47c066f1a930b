"""The system's own file dialogs, or a small one of ours where it has none. Never waits."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from imgui_bundle import portable_file_dialogs as native

from app.ui.asking import FileRequest
from relight_core.errors import InputError
from relight_core.imaging.files import is_legible

_NO_TEXT = "A file that was chosen has a name that is no text; rename it, or drop the folder it is in"
_LINUX_HELPERS = ("zenity", "kdialog", "matedialog", "qarma")


class Candidates(NamedTuple):
    """What our own dialog lists.

    Attributes:
        folders: in the order of their names.
        files: those of use, likewise.
    """

    folders: tuple[Path, ...] = ()
    files: tuple[Path, ...] = ()


class FileDialogs:
    """At most one dialog at a time; a second wish while one is open is ignored.

    Args:
        has_native: whether the system's dialogs may be used; None finds out.
    """

    def __init__(self, has_native: bool | None = None) -> None:
        self._has_native = has_native_dialogs() if has_native is None else has_native
        self._dialog: object | None = None
        self._request: FileRequest | None = None

    @property
    def waiting(self) -> bool:
        """Whether a dialog of the system is open, so that `poll` has to be called now and then."""
        return self._dialog is not None

    def ask(self, request: FileRequest) -> FileRequest | None:
        """Open a dialog; returns the request back where ours is to be drawn instead."""
        if self._dialog is not None:
            return None
        # The system's are only told text.
        is_text = all(is_legible(text) for text in (request.text, str(request.start)))
        if not self._has_native or not is_text:
            return request
        self._request, self._dialog = request, _opened(request)
        return None

    def poll(self) -> None:
        """Take over what the user has chosen, if he has.

        Raises:
            InputError: the name of a chosen file is no text.
        """
        if self._dialog is None or not self._dialog.ready(0):
            return
        dialog, request = self._dialog, self._request
        self._dialog = self._request = None
        try:
            chosen = dialog.result()
        except UnicodeDecodeError:
            raise InputError(_NO_TEXT) from None
        paths = [Path(text) for text in ([chosen] if isinstance(chosen, str) else chosen) if text]
        if paths:
            request.then(paths)

    def close(self) -> None:
        """Put an open dialog away."""
        if self._dialog is not None:
            self._dialog.kill()
            self._dialog = None


def has_native_dialogs() -> bool:
    """Whether this system can show its own dialogs; elsewhere than on Linux it always can."""
    if sys.platform in ("darwin", "win32"):
        return True
    return any(shutil.which(helper) for helper in _LINUX_HELPERS)


def candidates(text: str, suffixes: Sequence[str]) -> Candidates:
    """What our own dialog lists for a typed path: what its folder holds whose name begins as typed.

    Hidden ones are left out unless the typed name begins with a dot. The folder is read again once it has changed.
    """
    typed = Path(os.path.expanduser(text or "."))
    is_folder = text.endswith((os.sep, "/")) or not text
    folder, begins = (typed, "") if is_folder else (typed.parent, typed.name.lower())
    try:
        return _beginning_with(begins, tuple(suffixes), folder.absolute(), os.stat(folder).st_mtime_ns)
    except OSError:
        return Candidates()


@lru_cache(maxsize=1)
def _beginning_with(begins: str, suffixes: tuple[str, ...], folder: Path, changed_ns: int) -> Candidates:
    shows_hidden = begins.startswith(".")
    meant = [
        entry
        for entry in _inside(folder, changed_ns)
        if entry[0].startswith(begins) and (shows_hidden or not entry[0].startswith("."))
    ]
    folders = tuple(path for _, path, is_folder in meant if is_folder)
    files = (path for name, path, is_folder in meant if not is_folder and (not suffixes or name.endswith(suffixes)))
    return Candidates(folders, tuple(files))


@lru_cache(maxsize=1)
def _inside(folder: Path, _changed_ns: int) -> list[tuple[str, Path, bool]]:
    """What a folder holds: the name in small letters, by which it is in order, the path, and whether it's a folder."""
    entries = ((path.name.lower(), path, os.path.isdir(path)) for path in folder.iterdir())
    return sorted(entries, key=lambda entry: entry[0])


def _filters(suffixes: Sequence[str]) -> list[str] | None:
    """The choices of which files are listed: words and patterns, by turns."""
    if not suffixes:
        return None
    # On Linux the patterns tell large letters from small ones, and cameras write DSC_0001.JPG.
    spellings = dict.fromkeys(spelling for suffix in suffixes for spelling in (suffix, suffix.upper()))
    return ["Files relight opens", " ".join(f"*{spelling}" for spelling in spellings), "All files", "*"]


def _opened(request: FileRequest) -> object:
    start, filters = str(request.start), _filters(request.suffixes)
    if request.kind == "folder":
        return native.select_folder(request.title, start)
    if request.kind == "save":
        # relight asks itself before it replaces anything.
        return native.save_file(request.title, start, filters, native.opt.force_overwrite)
    return native.open_file(request.title, start, filters, native.opt.multiselect)
