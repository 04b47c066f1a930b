"""Work that survives a crash: the document is written into the user's own folder while it changes.

Each photo with unsaved work has one file of the running editor, `<run>-<number>.json`, and a lock is held on
`<run>.lock`, one for all of them: open files are few. The system lets go of the lock when the program ends, however it
ends; so a file whose lock is free belongs to nobody and is offered.
"""

from __future__ import annotations

import contextlib
import itertools
import logging
import secrets
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import BinaryIO

from app.document.document import Document
from app.document.json_fields import is_too_large, kind_of
from app.document.session_file import KIND, read_session, write_session
from relight_core.errors import InputError
from relight_core.imaging.file_lock import NoLocks, let_go, locked

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
        notes: what of the work can't be had, a line each.
    """

    path: Path
    document: Document
    saved_s: float
    notes: tuple[str, ...] = ()

    def forget(self) -> None:
        """Delete the file."""
        _forget(self.path)


class Autosave:
    """This editor's files, one for each photo with unsaved work.

    Args:
        folder: made if it is missing.
        write: runs the writing, on another thread if it likes; called in order.

    Attributes:
        problem: why the newest document could not be written, one line; None where it could.
    """

    def __init__(self, folder: Path, write: Callable[[Callable[[], None]], object]) -> None:
        self._write = write
        self._run = RunLock(folder)
        self._files: dict[Path, KeptFile] = {}
        self._photo: Path | None = None
        self._pending: Document | None = None
        self.problem: str | None = None
        self._changed_s = self._pending_since_s = 0.0

    def update(self, document: Document, unsaved: bool, now_s: float) -> None:
        """Look at the document, as often as one likes. What waits of another photo is written at once.

        Args:
            unsaved: there is work in it that no session file holds.
            now_s: a clock that never goes back.
        """
        photo = document.photo.path.absolute() if document.photo else None
        if photo != self._photo:
            self.flush()
            self._photo = photo
        if photo is None:
            return
        if not unsaved:
            self._discard(photo)
            return
        if document == self._given(photo):
            self._pending = None
            if self._files[photo].failed and now_s - self._changed_s >= PATIENCE_S:
                # The disk that was full may have room by now.
                self._changed_s = now_s
                self._write(partial(self._save_again, self._files[photo]))
            return
        if document != self._pending:
            if self._pending is None:
                self._pending_since_s = now_s
            self._pending, self._changed_s = document, now_s
        quiet = now_s - self._changed_s >= QUIET_S
        if quiet or now_s - self._pending_since_s >= PATIENCE_S:
            self.flush()

    @property
    def due(self) -> bool:
        """Whether something still waits to be written."""
        return self._pending is not None

    @property
    def keeps(self) -> bool:
        """Whether the newest document is in its file."""
        return self._pending is None and self._photo is not None and self.holds(self._photo)

    def is_given(self, photo: Path) -> bool:
        """Whether the work on a photo was given to be written."""
        return self._given(photo.absolute()) is not None

    def holds(self, photo: Path) -> bool:
        """Whether the newest that was given of the work on a photo is in its file."""
        file = self._files.get(photo.absolute())
        return file is not None and file.on_disk is not None and file.on_disk is file.given

    def flush(self) -> None:
        """Write at once what waits."""
        document, self._pending = self._pending, None
        if document is not None:
            if self._photo not in self._files:
                self._files[self._photo] = KeptFile(self._run)
            file = self._files[self._photo]
            file.given = document
            self._write(lambda: self._save(file, document))

    def try_again(self) -> None:
        """Write at once what waits, and what could not be written before."""
        self.flush()
        for file in self._files.values():
            self._write(partial(self._save_again, file))

    @property
    def fails(self) -> bool:
        """Whether there is work that could not be written."""
        return any(file.failed for file in self._files.values())

    def note_saved(self, document: Document) -> None:
        """A session file holds this document: remove the photo's file if it holds no other."""
        photo = document.photo.path.absolute()
        if self._given(photo) == document:
            self._discard(photo)

    def close(self) -> None:
        """Let go of the files; what is unsaved stays in them, for the next start to offer."""
        self.try_again()
        for file in self._files.values():
            self._write(file.unlock)

    def _given(self, photo: Path) -> Document | None:
        file = self._files.get(photo)
        return file.given if file else None

    def _discard(self, photo: Path) -> None:
        if photo == self._photo:
            self._pending = None
        file = self._files.pop(photo, None)
        if file is not None:
            self._write(partial(self._remove, file))

    def _remove(self, file: KeptFile) -> None:
        file.remove()
        if file.failed:
            # Work that comes later and can't be written for the same reason has to be told of again.
            self.problem = None

    def _save_again(self, file: KeptFile) -> None:
        if file.failed:
            self._save(file, file.given)

    def _save(self, file: KeptFile, document: Document) -> None:
        try:
            file.save(document)
        except Exception as error:
            # Nobody looks at what becomes of the writing, so whatever goes wrong has to be told from here.
            file.failed = True
            self.problem = _in_words(error)
            _log.warning("work is not kept for recovery: %s", error)
        else:
            file.failed = False
            self.problem = None


def _in_words(error: Exception) -> str:
    if isinstance(error, OSError) and error.filename is not None and error.strerror:
        return f"{error.filename}: {error.strerror.lower()}"
    return str(error) or type(error).__name__


class RunLock:
    """The lock on this editor's files; held while there is any. Used by the thread that writes.

    Args:
        folder: made if it is missing.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / f"{secrets.token_hex(8)}.lock"
        self._files: set[Path] = set()
        self._file: BinaryIO | None = None
        self._numbers = itertools.count()

    def new_path(self) -> Path:
        """A name for another file."""
        return self._path.with_name(f"{self._path.stem}-{next(self._numbers)}.json")

    def hold(self, path: Path) -> None:
        """A file is about to be written.

        Raises:
            OSError: a place that can't be written.
        """
        self._path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        self._files.add(path)
        if self._file is None:
            # Work without a lock is not offered, but can be opened.
            with contextlib.suppress(NoLocks):
                self._file = locked(self._path)

    def let_go(self, path: Path) -> None:
        """A file is gone, or is no longer this editor's."""
        self._files.discard(path)
        if self._file is not None and not self._files:
            let_go(self._file, self._path)
            self._file = None


class KeptFile:
    """The file of one photo's work.

    Attributes:
        given: the newest document that was given to be written.
        on_disk: the document the file holds.
        failed: whether the writing that was tried last came to nothing.
    """

    def __init__(self, run: RunLock) -> None:
        self._run, self.path = run, run.new_path()
        self.given: Document | None = None
        self.on_disk: Document | None = None
        self.failed = False

    def save(self, document: Document) -> None:
        """Write the file.

        Raises:
            OSError, InputError: a place that can't be written.
        """
        self._run.hold(self.path)
        write_session(self.path, document, relative=False)
        self.on_disk = document

    def remove(self) -> None:
        """Nothing in it is unsaved any more."""
        with contextlib.suppress(OSError):
            self.path.unlink(missing_ok=True)
        self.unlock()

    def unlock(self) -> None:
        """Let go of it."""
        self._run.let_go(self.path)


def leftovers(folder: Path, tell: Callable[[str], None] = _log.warning) -> list[Leftover]:
    """What editors that no longer run have left, newest first; damaged files are removed.

    Args:
        tell: told a line of each file that is left out but may be of use later, or of which not all can be had.
    """
    found = []
    for path in sorted(folder.glob("*.json")) if folder.is_dir() else []:
        try:
            lock = locked(_lock_path(path))
        except NoLocks as error:
            tell(f"Unsaved work may be in {path}: its disk has no locks ({error}); open it if no other relight does")
            continue
        except OSError as error:
            tell(f"Unsaved work can't be restored yet: {error.filename}: can't be opened ({error.strerror}); remove it")
            continue
        if lock is None:
            continue
        lock.close()
        try:
            session, saved_s = read_session(path), path.stat().st_mtime
        except (InputError, OSError) as error:
            # A photo that is only out of reach for now is no reason to forget the work.
            if _may_hold_work(path):
                tell(f"Unsaved work can't be restored yet: {error}")
            else:
                _log.warning("unsaved work can't be recovered: %s", error)
                _forget(path)
            continue
        found.append(Leftover(path, session.document, saved_s, session.notes))
        if session.notes:
            tell(f"Unsaved work on {session.document.photo.path.name}: {'; '.join(session.notes)}")
    return sorted(found, key=lambda leftover: -leftover.saved_s)


def _may_hold_work(path: Path) -> bool:
    """Whether a file that can't be restored says that it is a session, or can't be looked into for now."""
    if is_too_large(path):
        return True
    try:
        path.read_bytes()
    except FileNotFoundError:
        return False
    except OSError:
        return True
    return kind_of(path) == KIND


def _forget(path: Path) -> None:
    for gone in (path, _lock_path(path)):
        with contextlib.suppress(OSError):
            gone.unlink(missing_ok=True)


def _lock_path(path: Path) -> Path:
    """Of a file; older relights held one for each, of the same name."""
    return path.with_name(f"{path.stem.partition('-')[0]}.lock")
