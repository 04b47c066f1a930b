"""Reading a JSON file that anyone may have written: every value is checked, and nothing of it is ever run.

Wrong kinds, NaN and infinities are refused; numbers that are merely out of range are moved to the nearest end of it,
angles all the way round by whole turns, and noted; unknown settings are left out and noted.
"""

from __future__ import annotations

import json
import math
import os
import stat
from collections.abc import Mapping, Sequence
from pathlib import Path, PurePosixPath, PureWindowsPath

from relight_core.errors import InputError
from relight_core.imaging.files import file_bytes, file_head, whole_file
from relight_core.imaging.read import is_picture_head

LARGEST_BYTES = 4_000_000
"""More than a session has with as many strokes of the brush, as long as they may be."""

MARK = "relight"
_TURN_DEG = 360.0


class NotThereError(InputError):
    """A file that another names is not there."""


class Fields:
    """One object of the file.

    Args:
        values: what JSON gave.
        where: for messages, "photo.relight.json, light".
        notes: what was changed in reading, one line each; added to.

    Raises:
        InputError: not an object.
    """

    def __init__(self, values: object, where: str, notes: list[str]) -> None:
        if not isinstance(values, Mapping):
            raise InputError(f"{where}: is not a group of settings; the file is damaged")
        self._values, self._where, self._notes = dict(values), where, notes

    def number(self, key: str, low: float, high: float, default: float) -> float:
        """A finite number, moved into the range; one of whole turns about 0, as of degrees, is gone round in."""
        value = self._values.pop(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float) or not _is_finite(value):
            raise InputError(f"{self._where}: {key} is not a number; mend the file or delete that line")
        kept = min(max(float(value), low), high)
        if kept != value and (high - low) % _TURN_DEG == 0:
            kept = (float(value) + _TURN_DEG / 2) % _TURN_DEG - _TURN_DEG / 2
        if kept != value:
            self._notes.append(f"{key} {value:g} is out of range and became {kept:g}")
        return kept

    def flag(self, key: str) -> bool:
        """True or false; false where it is missing."""
        value = self._values.pop(key, False)
        if not isinstance(value, bool):
            raise InputError(f"{self._where}: {key} is neither true nor false; mend the file or delete that line")
        return value

    def index(self, key: str) -> int | None:
        """A whole number from 0 to 999, or None."""
        value = self._values.pop(key, None)
        if value is None:
            return None
        if type(value) is not int or not 0 <= value < 1000:
            raise InputError(f"{self._where}: {key} is not a count; mend the file or delete that line")
        return value

    def text(self, key: str, default: str | None = None) -> str:
        """A string of reasonable length; without a default it has to be there."""
        value = self._values.pop(key, default)
        if not isinstance(value, str) or len(value) > 4096 or "\0" in value:
            raise InputError(f"{self._where}: {key} is missing or not text; the file is damaged")
        return value

    def word(self, key: str, known: Sequence[str], default: str) -> str:
        """One of the known words; the default, and a note, for another."""
        value = self.text(key, default)
        if value in known:
            return value
        self._notes.append(f"unknown {key} {value[:40]} became {default}")
        return default

    def is_nothing(self, key: str) -> bool:
        """Whether a setting is missing or null; it is then read."""
        missing = self._values.get(key) is None
        if missing:
            self._values.pop(key, None)
        return missing

    def group(self, key: str) -> Fields:
        """An object inside; an empty one where it is missing."""
        return Fields(self._values.pop(key, {}), f"{self._where}, {key}", self._notes)

    def groups(self, key: str, most: int) -> list[Fields]:
        """A list of objects, of which at most `most` are read."""
        values = self._values.pop(key, [])
        if not isinstance(values, list):
            raise InputError(f"{self._where}: {key} is not a list; the file is damaged")
        if len(values) > most:
            self._notes.append(f"only the first {most} of {len(values)} {key} were read")
        return [
            Fields(value, f"{self._where}, {key} {index}", self._notes) for index, value in enumerate(values[:most], 1)
        ]

    def triple(self, key: str) -> tuple[float, float, float] | None:
        """Three numbers from 0 to 10000, or None."""
        values = self._values.pop(key, None)
        if values is None:
            return None
        if not isinstance(values, list) or len(values) != 3:
            raise InputError(f"{self._where}: {key} is not three numbers; the file is damaged")
        parts = Fields({f"{key} {index}": value for index, value in enumerate(values)}, self._where, self._notes)
        red, green, blue = (parts.number(f"{key} {index}", 0.0, 1e4, 0.0) for index in range(3))
        return red, green, blue

    def words(self, key: str, known: Sequence[str]) -> frozenset[str]:
        """A list of words of which only the known ones are kept."""
        values = self._values.pop(key, [])
        if not isinstance(values, list) or not all(isinstance(value, str) for value in values):
            raise InputError(f"{self._where}: {key} is not a list of words; the file is damaged")
        for value in sorted(set(values) - set(known)):
            self._notes.append(f"unknown {key} {value[:40]} was left out")
        return frozenset(values) & frozenset(known)

    def note(self, line: str) -> None:
        """Tell what was changed in reading."""
        self._notes.append(line)

    def finish(self) -> None:
        """Note what nobody asked for."""
        for key in sorted(str(key) for key in self._values):
            self._notes.append(f"unknown setting {key[:40]} was left out")


def read_json(path: Path, kind: str, version: int, notes: list[str]) -> Fields:
    """The top of a file that says it is of this kind and of a version that is known.

    Raises:
        InputError: unreadable, no JSON, of another kind or of a newer version.
    """
    if _is_odd(path):
        raise InputError(f"{path}: not a {kind} file, or too large for one; choose another")
    data = file_bytes(path)
    try:
        content = json.loads(data.decode("utf-8-sig"), parse_constant=_no_constant)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not a readable {kind} file ({_first_line(error)})") from None
    fields = Fields(content, str(path), notes)
    if fields.text(MARK, "") != kind:
        raise InputError(f"{path}: not a relight {kind} file; choose another")
    found = fields.index("version")
    if found is None or found > version:
        raise InputError(f"{path}: not of a version this relight knows (version {found}); update relight to open it")
    return fields


def write_json(path: Path, kind: str, version: int, content: dict) -> None:
    """Write a file of this kind, whole or not at all.

    Raises:
        InputError: a place that can't be written.
    """
    with whole_file(path) as part:
        part.write_text(_text(kind, version, content), encoding="ascii")


def holds_json(path: Path, kind: str, version: int, content: dict) -> bool:
    """Whether a file is as `write_json` would write it; False where it can't be read."""
    try:
        return not _is_odd(path) and path.read_text(encoding="ascii") == _text(kind, version, content)
    except (OSError, ValueError):
        return False


def _text(kind: str, version: int, content: dict) -> str:
    # In ASCII, which can also hold the names of files that are no text in any encoding.
    return json.dumps({MARK: kind, "version": version, **content}, indent=1, allow_nan=False, ensure_ascii=True) + "\n"


def kind_of(path: Path) -> str | None:
    """Which kind of file it says it is; None where it isn't one of ours."""
    if _is_odd(path):
        return None
    try:
        content = json.loads(path.read_text(encoding="utf-8-sig"), parse_constant=_no_constant)
    except (OSError, ValueError, RecursionError):
        return None
    kind = content.get(MARK) if isinstance(content, dict) else None
    return kind if isinstance(kind, str) else None


def is_place_for(path: Path, kind: str) -> bool:
    """Whether a file of this kind may be written there: nothing is there yet, or one of its kind."""
    return not os.path.lexists(path) or kind_of(path) == kind


def path_for_file(target: Path, folder: Path | None) -> str:
    """How a file names another: relative to its folder, with slashes; in full where that can't be, or for None."""
    target = Path(os.path.abspath(target))
    if folder is None:
        return str(target)
    try:
        text = Path(os.path.relpath(target, os.path.abspath(folder))).as_posix()
    except ValueError:
        # Another drive.
        return str(target)
    # A name such as "~me.jpg" or "a:b.jpg" could be read as something else than one beside it.
    return f"./{text}" if _leads_elsewhere(text) or _is_foreign(text) else text


def path_from_file(text: str, folder: Path, suffixes: tuple[str, ...], where: str) -> Path:
    """The file that another names. It has to be an ordinary file that is a picture by its name or its first bytes.

    Raises:
        NotThereError: no such file.
        InputError: a place on the network, a device, or no picture.
    """
    if _leads_elsewhere(text):
        raise InputError(f"{where}: {text:.200} is not a file beside it; mend the file's paths")
    if _is_foreign(text):
        raise InputError(f"{where}: {text:.200} is a path of another system; mend the file's paths")
    path = Path(os.path.abspath(folder / PurePosixPath(text)))
    try:
        regular = stat.S_ISREG(os.stat(path).st_mode)
    except (OSError, ValueError):
        raise NotThereError(f"{where}: {path} is not there; move it back, or mend the file's paths") from None
    if not regular:
        raise InputError(f"{where}: {path} is not a regular file; mend the file's paths")
    if path.suffix.lower() not in suffixes and not is_picture_head(file_head(path)):
        raise InputError(f"{where}: {path.name} is not a kind of picture relight opens; mend the file's paths")
    return path


def _leads_elsewhere(text: str) -> bool:
    """Whether it names a place on the network or somebody's own folder."""
    return text.startswith(("//", "\\\\", "~")) or "://" in text


def _is_foreign(text: str) -> bool:
    return os.sep == "/" and bool(PureWindowsPath(text).drive)


def is_too_large(path: Path) -> bool:
    """Whether it is a file larger than any of ours, so that nobody has looked into it."""
    found = _found(path)
    return found is not None and stat.S_ISREG(found.st_mode) and found.st_size > LARGEST_BYTES


def _is_odd(path: Path) -> bool:
    """Whether it is there, but as a device, a pipe or a file far too large."""
    found = _found(path)
    return found is not None and (not stat.S_ISREG(found.st_mode) or found.st_size > LARGEST_BYTES)


def _found(path: Path) -> os.stat_result | None:
    try:
        return os.stat(path)
    except (OSError, ValueError):
        return None


def _is_finite(value: float) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:
        return False


def _no_constant(name: str) -> None:
    raise ValueError(f"{name} is no number")


def _first_line(error: Exception) -> str:
    return (str(error) or type(error).__name__).splitlines()[0][:120]
