"""One edit for many photos: goes on past bad ones, and where it was interrupted."""

from __future__ import annotations

import os
import traceback
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from app.engine.places import exported_stem
from app.engine.sources import PHOTO_SUFFIXES
from app.faults import confession
from relight_core.errors import InputError
from relight_core.imaging.files import KnownFiles
from relight_core.imaging.formats.raster import RAW_SUFFIXES
from relight_core.unwanted import UnwantedError

_NO_MEMORY = ("allocate memory", "out of memory", "insufficient memory")
"""What libraries say, whose exceptions are no MemoryError."""


@dataclass(frozen=True)
class Outcome:
    """What became of one photo.

    Attributes:
        photo, output: the files.
        state: "written", "kept" (it was there already and was left alone) or "failed".
        error: why it failed.
        result: what the work returned.
        fault: where it failed, as Python tells it, if that is a fault of ours and not of the photo; else empty.
    """

    photo: Path
    output: Path
    state: str
    error: str = ""
    result: object = None
    fault: str = ""


def relight_each(
    tasks: Sequence[tuple[Path, Path]],
    relight_one: Callable[[Path, Path], object],
    kept_if: Callable[[Path, Path], bool] | None = None,
) -> Iterator[Outcome]:
    """Do the work for photo after photo; what goes wrong with one doesn't stop the others.

    Args:
        tasks: photo and output of each.
        relight_one: writes one output from one photo.
        kept_if: whether to leave an output alone, asked when its photo's turn comes; None makes all of them.

    Raises:
        Exception: memory has run out, or nobody reads what is told, or wants it any more: no other photo would fare
            better.
    """
    for photo, output in tasks:
        if kept_if is not None and kept_if(photo, output):
            yield Outcome(photo, output, "kept")
            continue
        try:
            result = relight_one(photo, output)
        except InputError as error:
            yield Outcome(photo, output, "failed", str(error))
        except Exception as error:
            if isinstance(error, (BrokenPipeError, UnwantedError)) or _is_out_of_memory(error):
                raise
            # The text, not the exception: that would keep the photo's arrays until the batch has ended.
            yield Outcome(photo, output, "failed", f"{photo}: {confession(error)}", fault=traceback.format_exc())
        else:
            _keep_in_order(photo, output)
            yield Outcome(photo, output, "written", result=result)


def batch_tasks(photos: Sequence[Path], folder: Path, suffix: str) -> list[tuple[Path, Path]]:
    """Each photo with its own output in a folder, named as `names_apart` has it."""
    return [(photo, folder / f"{name}{suffix}") for photo, name in zip(photos, names_apart(photos), strict=True)]


def names_apart(photos: Sequence[Path]) -> list[str]:
    """A name for each photo's output, without suffix: the photo's own, and of a.jpg and a.png "a-jpg" and "a-png".

    No two are the same, nor on file systems that take large and small letters for the same. In whatever order the
    photos are given, each has the same name: else a run that is taken up would keep another's result.
    """
    counts = Counter(photo.stem.lower() for photo in photos)
    taken: set[str] = set()
    names = [""] * len(photos)
    for index in sorted(range(len(photos)), key=lambda index: _place_in_line(photos[index])):
        photo = photos[index]
        name = photo.stem if counts[photo.stem.lower()] == 1 else name_beside_a_namesake(photo)
        number, free = 1, name
        while free.lower() in taken:
            number += 1
            free = f"{name}-{number}"
        taken.add(free.lower())
        names[index] = free
    return names


def _place_in_line(photo: Path) -> tuple[str, int, str]:
    """What sorts photos by folder and name; a.jpg goes before a-jpg.png, which has a name like one made of it."""
    return os.path.abspath(photo.parent), len(photo.name), photo.name


def name_beside_a_namesake(photo: Path) -> str:
    """The name of a photo's output, without suffix, where another photo has the same: of a.jpg "a-jpg"."""
    return f"{photo.stem}-{photo.suffix[1:]}"


def photos_in(folder: Path, others: KnownFiles | None = None) -> list[Path]:
    """The photos right inside a folder, by name; hidden ones, panoramas (.hdr) and exports beside them are left out.

    Args:
        others: files that are no photos here, whatever their suffix says.

    Raises:
        InputError: the folder can't be read, or has no photo in it.
    """
    try:
        inside = sorted(folder.iterdir())
    except OSError as error:
        raise InputError(f"{folder}: can't be read ({error.strerror}); check its permissions") from error
    photos = [path for path in inside if path.suffix.lower() in PHOTO_SUFFIXES and not path.name.startswith(".")]
    photos = [path for path in photos if not path.is_dir() and (others is None or others.named(path) is None)]
    photos = _without_exports(photos, inside)
    if not photos:
        raise InputError(f"{folder}: no photos in this folder; choose one with JPEG, PNG, TIFF, HEIC or EXR files")
    return photos


def _without_exports(photos: list[Path], inside: list[Path]) -> list[Path]:
    """The photos without what was exported from one of them, or a raw one beside them, under an export's own name."""
    stems = {photo.stem for photo in photos} | {path.stem for path in inside if path.suffix.lower() in RAW_SUFFIXES}
    return [photo for photo in photos if exported_stem(photo) not in stems]


def summary(outcomes: Sequence[Outcome]) -> str:
    """One line for people."""
    counts = {state: sum(outcome.state == state for outcome in outcomes) for state in ("written", "kept", "failed")}
    words = [f"{counts['written']} photo{'s' * (counts['written'] != 1)} relit"]
    if counts["kept"]:
        words.append(f"{counts['kept']} {'was' if counts['kept'] == 1 else 'were'} done already")
    if counts["failed"]:
        names = ", ".join(outcome.photo.name for outcome in outcomes if outcome.state == "failed")
        words.append(f"{counts['failed']} could not be relit: {names}")
    return "; ".join(words)


def reasons(outcomes: Sequence[Outcome]) -> list[str]:
    """Why photos could not be relit, a line each."""
    return [outcome.error for outcome in outcomes if outcome.state == "failed"]


def is_done(photo: Path, output: Path) -> bool:
    """Whether a photo's output is there, not empty, and no older than the photo."""
    try:
        return os.path.getsize(output) > 0 and os.path.getmtime(output) >= os.path.getmtime(photo)
    except OSError:
        return False


def _keep_in_order(photo: Path, output: Path) -> None:
    """Date an output as its photo where that is of a later time, as cameras' clocks have it: it is no older than it."""
    with suppress(OSError):
        dated = os.stat(photo)
        if os.stat(output).st_mtime_ns < dated.st_mtime_ns:
            os.utime(output, ns=(dated.st_atime_ns, dated.st_mtime_ns))


def _is_out_of_memory(error: Exception) -> bool:
    return isinstance(error, MemoryError) or any(words in str(error).lower() for words in _NO_MEMORY)
