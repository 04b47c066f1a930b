"""Files that one program at a time may hold: the system lets go of them when it ends, however it ends."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import BinaryIO

_HELD_ELSEWHERE = {errno.EAGAIN, errno.EWOULDBLOCK, errno.EACCES, errno.EDEADLK}
"""What systems say of a lock that another program holds."""


class NoLocks(OSError):
    """A disk on which no file can be locked."""


def locked(path: Path) -> BinaryIO | None:
    """The open and locked file, or None where another program holds it.

    Raises:
        NoLocks: the disk has none, as some network drives.
        OSError: a place where no file can be opened.
    """
    file = open(path, "a+b")  # noqa: SIM115 -- closed by whoever holds it
    try:
        if os.name == "nt":
            import msvcrt

            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        file.close()
        if error.errno not in _HELD_ELSEWHERE:
            raise NoLocks(error.strerror) from error
        return None
    return file
