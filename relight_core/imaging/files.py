"""Whole files or none: reading one into memory, and writing one that appears complete or not at all."""

from __future__ import annotations

import hashlib
import os
import re
import secrets
import stat
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from relight_core.errors import InputError, without_controls

LARGEST_FILE = 8 << 30
"""Bytes; what is larger is no photo, no light and no weights."""

_NO_TEXT = re.compile("[\ud800-\udfff]")
"""What stands for the bytes of a file's name that are no text."""

_LONGEST_STEM, _TOKEN_BYTES, _PART = 100, 6, ".part"


def legible(name: str) -> str:
    """A path or a file's name with a replacement character for all of it that can't be shown in a line of text."""
    return _NO_TEXT.sub("\N{REPLACEMENT CHARACTER}", without_controls(name))


def is_legible(name: str) -> bool:
    """Whether a path or a file's name is all text, which not every library takes for granted."""
    return not _NO_TEXT.search(name)


def file_bytes(path: Path) -> bytes:
    """The content of a file.

    Raises:
        InputError: missing, a folder, no regular file (a pipe or a device would never end), larger than
            8 GiB, empty or unreadable.
    """
    return _bytes(path, -1)


def file_digest(path: Path) -> str:
    """SHA-256 of a file's content, in hex; raises as `file_bytes`."""
    return hashlib.sha256(file_bytes(path)).hexdigest()


def file_head(path: Path) -> bytes:
    """The first bytes of a file, by which its kind is known; raises as `file_bytes`."""
    return _bytes(path, 32)


def _bytes(path: Path, count: int) -> bytes:
    try:
        check_regular(path)
        with open(path, "rb") as file:
            data = file.read(count)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; check the path") from None
    except IsADirectoryError:
        raise InputError(f"{path}: this is a folder; name a file in it") from None
    except PermissionError:
        raise InputError(f"{path}: no permission to read it; change the file's permissions") from None
    except InputError:
        raise
    except MemoryError:
        raise InputError(f"{path}: not enough memory is free for it; make it smaller or close other programs") from None
    except (OSError, ValueError) as error:
        raise InputError(f"{path!s:.200}: can't be read ({_reason(error)}); check the path") from None
    if not data:
        raise InputError(f"{path}: the file is empty; fetch or export it again")
    return data


def is_same_file(one: Path, other: Path) -> bool:
    """Whether two paths, of which either may lead nowhere yet, are one file, by whatever links and letters."""
    try:
        return os.path.samefile(one, other)
    except OSError:
        return os.path.realpath(one) == os.path.realpath(other)


class KnownFiles:
    """Files that are to be recognised under any name, however many they are; see `is_same_file`."""

    def __init__(self, paths: Iterable[Path]) -> None:
        """Look at each of them once; some may be missing."""
        self._by_node: dict[tuple[int, int], Path] = {}
        self._by_place: dict[str, Path] = {}
        for path in paths:
            self._by_place.setdefault(os.path.realpath(path), path)
            with suppress(OSError):
                found = os.stat(path)
                self._by_node.setdefault((found.st_dev, found.st_ino), path)

    def named(self, path: Path) -> Path | None:
        """The known file that a path, which may lead nowhere yet, is; None for none of them."""
        try:
            found = os.stat(path)
        except OSError:
            return self._by_place.get(os.path.realpath(path))
        return self._by_node.get((found.st_dev, found.st_ino))


def check_regular(path: Path) -> None:
    """Say early that a path leads to no file that can be read to its end.

    Raises:
        InputError: neither a regular file nor a folder, or larger than 8 GiB.
        OSError: missing, or behind a folder that may not be entered.
    """
    found = path.stat()
    if not stat.S_ISREG(found.st_mode) and not stat.S_ISDIR(found.st_mode):
        raise InputError(f"{path}: not a regular file; name a file")
    if found.st_size > LARGEST_FILE:
        raise InputError(f"{path}: {found.st_size / 2**30:.0f} GiB is too large; make it smaller")


@contextmanager
def whole_file(path: Path, suffix: str = _PART) -> Iterator[Path]:
    """A new file that takes its name only once it is complete and on disk.

    Yields the path of an empty file beside `path`. When the block ends, that file is flushed to disk and
    renamed; when the block raises, it is removed and `path` keeps its former content.

    Args:
        suffix: of the file beside it, for writers that go by it.

    Raises:
        InputError: the folder is missing, not writable or full, or `path` is a folder.
    """
    path = Path(os.path.realpath(path))
    if os.path.isdir(path):
        raise InputError(f"{path}: this is a folder; name a file in it")
    if not os.path.isdir(path.parent):
        raise InputError(f"{path}: there is no folder {path.parent}; create it or choose another")
    beside = path.parent / f"{_unfinished(path)}{secrets.token_hex(_TOKEN_BYTES)}{suffix}"
    try:
        os.close(os.open(beside, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        yield beside
        _flush(beside)
        os.replace(beside, path)
    except OSError as error:
        raise InputError(f"{path}: can't be written ({_reason(error)}); choose another place") from error
    finally:
        with suppress(OSError):
            beside.unlink(missing_ok=True)


def remove_unfinished(path: Path) -> None:
    """Remove what programs that were killed amid a `whole_file` of this path have left beside it.

    It can't be told from what another program is writing now: only for who knows that there is none.
    """
    path = Path(os.path.realpath(path))
    left = re.compile(f"{re.escape(_unfinished(path))}[0-9a-f]{{{2 * _TOKEN_BYTES}}}{re.escape(_PART)}")
    with suppress(OSError):
        for beside in path.parent.iterdir():
            if left.fullmatch(beside.name):
                beside.unlink()


def _unfinished(path: Path) -> str:
    """How the names of a file that is not complete begin."""
    # Not every library that writes there takes a name that is no text, and names have a longest length in bytes.
    stem = legible(path.name).encode()[:_LONGEST_STEM].decode(errors="ignore")
    return f".{stem}-"


def _flush(path: Path) -> None:
    descriptor = os.open(path, os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _reason(error: Exception) -> str:
    return (getattr(error, "strerror", None) or str(error) or type(error).__name__).lower()
