"""Files that one program at a time may hold: the system lets go of them when it ends, however it ends."""

from __future__ import annotations

import errno
import os
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO

_HELD_ELSEWHERE = {errno.EAGAIN, errno.EWOULDBLOCK, errno.EACCES, errno.EDEADLK}
"""What systems say of a lock that another program holds."""

_MOST_TRIES = 100


class NoLocks(OSError):
    """A disk on which no file can be locked."""


def locked(path: Path) -> BinaryIO | None:
    """The open and locked file, or None where another program holds it; `let_go` gives it back.

    Raises:
        NoLocks: the disk has none, as some network drives.
        OSError: a place where no file can be opened.
    """
    for _ in range(_MOST_TRIES):
        file = open(path, "a+b")  # noqa: SIM115 -- closed by whoever holds it
        try:
            _lock(file)
        except OSError as error:
            file.close()
            if error.errno not in _HELD_ELSEWHERE:
                raise NoLocks(error.strerror) from error
            return None
        if _is_at(file, path):
            return file
        file.close()
    raise NoLocks("files there have another number whenever they are asked")


def let_go(file: BinaryIO, path: Path) -> None:
    """Give back what `locked` gave, and remove the file.

    It is removed while it is held, so that nobody takes it in between; who has opened it by then holds a file
    without a name, and `locked` opens the next. Windows removes no open file, nor one that the next has opened.
    """
    if os.name == "nt":
        file.close()
    with suppress(OSError):
        path.unlink(missing_ok=True)
    file.close()


def _lock(file: BinaryIO) -> None:
    if os.name == "nt":
        import msvcrt

        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
    else:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _is_at(file: BinaryIO, path: Path) -> bool:
    """Whether a file still has this name: it may have been removed, and made anew, since it was opened."""
    try:
        return os.path.samestat(os.fstat(file.fileno()), os.stat(path))
    except FileNotFoundError:
        return False
