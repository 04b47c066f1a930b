"""Work that survives a crash: the document is written into the user's own folder while it changes.

Each running editor has one file, `<token>.json`, and holds a lock on `<token>.lock`. The system lets go of the lock
when the program ends, however it ends; so a file whose lock is free belongs to nobody and is offered.
"""

from __future__ import annotations

import contextlib
import logging
import os
import secrets
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from app.document.document import Document
from app.document.json_fields import kind_of
from app.document.session_file import KIND, read_session, write_session
from relight_core.errors import InputError

QUIET_S, PATIENCE_S = 1.5, 10.0
"""A change is written after this much quiet, and during constant change this often."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Leftover:
    """Unsaved work of an editor that no longer runs.

    Attributes:
        path: its file.
        document: the work.
        saved_s: when it was written, as of time.time.
    """

    path: Path
    document: Document
    saved_s: float

    def forget(self) -> None:
        """Delete the file."""
        for path in (self.path, self.path.with_suffix(".lock")):
            with contextlib.suppress(OSError):
                path.unlink(missing_ok=True)


class Autosave:
    """This editor's file.

    Args:
        folder: made if it is missing.
        write: runs the writing, on another thread if it likes; called in order.

    Attributes:
        problem: why the newest document could not be written, one line; None where it could.
    """

    def __init__(self, folder: Path, write: Callable[[Callable[[], None]], object]) -> None:
        self._folder, self._write = folder, write
        self._path = folder / f"{secrets.token_hex(8)}.json"
        self._lock: object | None = None
        self._written: Document | None = None
        self._pending: Document | None = None
        self._on_disk: Document | None = None
        self.problem: str | None = None
        self._changed_s = self._pending_since_s = 0.0

    def update(self, document: Document, unsaved: bool, now_s: float) -> None:
        """Look at the document, as often as one likes.

        Args:
            unsaved: there is work in it that no session file holds.
            now_s: a clock that never goes back.
        """
        if not unsaved or document.photo is None:
            self.discard()
            return
        if document == self._written:
            self._pending = None
            return
        if document != self._pending:
            if self._pending is None:
                self._pending_since_s = now_s
            self._pending, self._changed_s = document, now_s
        quiet = now_s - self._changed_s >= QUIET_S
        if quiet or now_s - self._pending_since_s >= PATIENCE_S:
            self._keep(document)

    @property
    def due(self) -> bool:
        """Whether something still waits to be written."""
        return self._pending is not None

    @property
    def handed_on(self) -> bool:
        """Whether the newest document was given to be written."""
        return self._written is not None and self._pending is None

    @property
    def keeps(self) -> bool:
        """Whether the newest document is in the file."""
        return self.handed_on and self._on_disk is self._written

    def flush(self) -> None:
        """Write at once what waits."""
        if self._pending is not None:
            self._keep(self._pending)

    def discard(self) -> None:
        """Nothing is unsaved: remove the file."""
        self._pending = None
        if self._written is not None:
            self._written = None
            self._write(lambda: self._path.unlink(missing_ok=True))

    def close(self) -> None:
        """Let go of the file; what is unsaved stays in it, for the next start to offer."""
        self.flush()
        self._write(self._unlock)

    def _keep(self, document: Document) -> None:
        self._written, self._pending = document, None
        self._write(lambda: self._save(document))

    def _save(self, document: Document) -> None:
        try:
            self._folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            if self._lock is None:
                self._lock = _locked(self._path.with_suffix(".lock"))
            write_session(self._path, document, relative=False)
        except (OSError, InputError) as error:
            self.problem = str(error)
            _log.warning("work is not kept for recovery: %s", error)
        else:
            self._on_disk, self.problem = document, None

    def _unlock(self) -> None:
        if self._lock is not None:
            self._lock.close()
            self._lock = None
            with contextlib.suppress(OSError):
                self._path.with_suffix(".lock").unlink(missing_ok=True)


def leftovers(folder: Path) -> list[Leftover]:
    """What editors that no longer run have left, newest first; damaged files are removed."""
    found = []
    for path in sorted(folder.glob("*.json")) if folder.is_dir() else []:
        lock = _locked(path.with_suffix(".lock"))
        if lock is None:
            continue
        lock.close()
        leftover = Leftover(path, Document(), 0.0)
        try:
            leftover = Leftover(path, read_session(path).document, path.stat().st_mtime)
        except (InputError, OSError) as error:
            # A photo that is only out of reach for now is no reason to forget the work.
            _log.warning("unsaved work can't be recovered: %s", error)
            if kind_of(path) != KIND:
                leftover.forget()
        else:
            found.append(leftover)
    return sorted(found, key=lambda leftover: -leftover.saved_s)


def _locked(path: Path) -> object | None:
    """The open and locked file, or None where another program holds it."""
    file = open(path, "a+b")  # noqa: SIM115 -- closed by whoever holds it
    try:
        if os.name == "nt":
            import msvcrt

            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        file.close()
        return None
    return file
