"""Arrays from an .npz file, whatever has become of it."""

from __future__ import annotations

import lzma
import struct
import zlib
from pathlib import Path
from tokenize import TokenError
from zipfile import BadZipFile, is_zipfile

import numpy as np

from relight_core.errors import InputError

DAMAGE = (
    OSError,
    ValueError,
    KeyError,
    TypeError,
    EOFError,
    RuntimeError,
    MemoryError,
    SyntaxError,
    OverflowError,
    struct.error,
    TokenError,
    BadZipFile,
    zlib.error,
    lzma.LZMAError,
)
"""What NumPy raises where an archive is damaged."""


def read_arrays(path: Path, names: tuple[str, ...], kind: str, mend: str) -> dict[str, np.ndarray]:
    """The named arrays of an archive; the zip's checksums are compared, nothing is unpickled.

    Args:
        kind, mend: what the file should be and what to do if it isn't, for the message.

    Raises:
        InputError: missing, damaged, or without one of the names.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such file; {mend}")
    try:
        with open(path, "rb") as file:
            # Of anything else NumPy says how to unpickle it.
            if not is_zipfile(file):
                raise BadZipFile("no .npz archive")
        with np.load(path, allow_pickle=False) as data:
            return {name: data[name] for name in names}
    except DAMAGE as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"{path}: not {kind}, or damaged ({reason}); {mend}") from error
