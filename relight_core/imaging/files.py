"""Whole files or none: reading one into memory, and writing one that appears complete or not at all."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from relight_core.errors import InputError


def file_bytes(path: Path) -> bytes:
    """The content of a file.

    Raises:
        InputError: missing, a folder, empty or unreadable.
    """
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; check the path") from None
    except IsADirectoryError:
        raise InputError(f"{path}: this is a folder; name a file in it") from None
    except PermissionError:
        raise InputError(f"{path}: no permission to read it; change the file's permissions") from None
    except (OSError, ValueError) as error:
        raise InputError(f"{path!s:.200}: can't be read ({_reason(error)}); check the path") from None
    if not data:
        raise InputError(f"{path}: the file is empty; fetch or export it again")
    return data


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A new file that takes its name only once it is complete and on disk.

    Yields the path of an empty file beside `path`. When the block ends, that file is flushed to disk and
    renamed; when the block raises, it is removed and `path` keeps its former content.

    Raises:
        InputError: the folder is missing, not writable or full, or `path` is a folder.
    """
    path = Path(os.path.realpath(path))
    if path.is_dir():
        raise InputError(f"{path}: this is a folder; name a file in it")
    if not path.parent.is_dir():
        raise InputError(f"{path}: there is no folder {path.parent}; create it or choose another")
    beside = path.parent / f".{path.name[:100]}-{secrets.token_hex(6)}.part"
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


def _flush(path: Path) -> None:
    descriptor = os.open(path, os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _reason(error: Exception) -> str:
    return (getattr(error, "strerror", None) or str(error) or type(error).__name__).lower()
