"""Where results go: names worked out and checked before anything is computed, files that appear whole."""

from __future__ import annotations

import contextlib
import json
import os
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from app.engine.batch import is_done, name_beside_a_namesake, names_apart
from relight_core.errors import InputError, without_controls
from relight_core.imaging.files import KnownFiles, whole_file

OPAQUE_SUFFIXES = (".jpg", ".jpeg")
NAME_FIELD = "{name}"


def plan_outputs(photos: Sequence[Path], out: str) -> list[Path]:
    """The file each photo's result goes to.

    OUT is a file (for one photo), a folder (it exists, or ends in a slash: then it is made, and results
    are PNG), or a pattern in which {name} stands for the photo's name, as of app.engine.batch.names_apart.

    Raises:
        InputError: several photos and one file.
    """
    pattern = _pattern(out)
    if NAME_FIELD not in pattern and len(photos) > 1:
        raise InputError(f"{out}: several photos need a folder/ or a pattern like {NAME_FIELD}.png after -o")
    return [Path(pattern.replace(NAME_FIELD, name)) for name in names_apart(photos)]


def results_among(photos: Sequence[Path], out: str) -> list[Path]:
    """Those of the photos that by their names are results of others: what an earlier run has left beside its photos.

    Of a.jpg that is the file that OUT makes of the name a, or of a-jpg or a-jpg-2 if one of these is there: then a run
    had another photo called a, and where OUT's own name would be a.png, that file is the other photo.
    """
    pattern, given = _pattern(out), {_place(photo) for photo in photos}
    namesakes = Counter(name_beside_a_namesake(photo).lower() for photo in photos)
    results, doubtful, told_apart = set(), set(), set()

    def place_of(name: str) -> str:
        return _place(Path(pattern.replace(NAME_FIELD, name)))

    for photo in photos:
        own, name = _place(photo), name_beside_a_namesake(photo)
        names = (name, *(f"{name}-{number}" for number in range(2, namesakes[name.lower()] + 1)))
        if apart := ({place_of(name) for name in names} & given) - {own}:
            results |= apart
            told_apart.add(photo.stem.lower())
        elif (plain := place_of(photo.stem)) in given and plain != own:
            doubtful.add(plain)
    return [
        photo
        for photo in photos
        if (place := _place(photo)) in results or (place in doubtful and photo.stem.lower() not in told_apart)
    ]


def unclaimed_results(photos: Sequence[Path], outputs: Sequence[Path], results: Sequence[Path]) -> list[Path]:
    """Those of the results that are no photo's output in this run.

    Args:
        photos, outputs: each photo and where its result goes.
        results: files that were given as photos and taken for results; see `results_among`.

    Raises:
        InputError: one would have to be made anew, and may as well be a photo.
    """
    unclaimed = {_place(result): result for result in results}
    for photo, output in zip(photos, outputs, strict=True):
        if unclaimed.pop(_place(output), None) is not None and not is_done(photo, output):
            raise InputError(
                f"{output}: has the name of {photo}'s result but is older, so it may be a photo of its own; "
                "move it away, or choose another name after -o"
            )
    return list(unclaimed.values())


def _pattern(out: str) -> str:
    """OUT with {name} in it, unless it is one file."""
    if out.endswith(("/", os.sep)) or os.path.isdir(out):
        return os.path.join(out, f"{NAME_FIELD}.png")
    return out


def _place(path: Path) -> str:
    """A file's path, the same by whichever way to its folder."""
    return os.path.join(os.path.realpath(path.parent), path.name)


def check_place(path: Path, inputs: KnownFiles, *, folder_is_made: bool = False) -> None:
    """Raise InputError if a file can't be written there, or if it is an input under any name.

    Args:
        path: the file to write.
        inputs: files that must stay as they are.
        folder_is_made: the command will make the file's folder if it is missing.
    """
    if (given := inputs.named(path)) is not None:
        raise InputError(f"{path}: that is the input {given}; choose another name after -o")
    if os.path.isdir(path):
        raise InputError(f"{path}: is a folder; give a file's name")
    if os.path.exists(path) and not os.path.isfile(path):
        raise InputError(f"{path}: is not a regular file; choose another name")
    check_folder(path.parent, is_made=folder_is_made)


def check_folder(folder: Path, *, is_made: bool = False) -> None:
    """Raise InputError unless files can be made in the folder, or the folder itself where it `is_made`."""
    if is_made:
        folder = next((f for f in (folder, *folder.absolute().parents) if os.path.lexists(f)), folder)
    if not os.path.exists(folder):
        raise InputError(f"{folder}: no such folder; make it first")
    if not os.path.isdir(folder):
        raise InputError(f"{folder}: is not a folder; choose another place")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"{folder}: no permission to write there; choose another folder")


def make_folder(folder: Path) -> None:
    """Make the folder, and those above it, unless it is there.

    Raises:
        InputError: it can't be made or written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: can't be made ({error.strerror}); choose another folder") from error
    check_folder(folder)


@contextlib.contextmanager
def folder_filled_at_once(folder: Path) -> Iterator[Path]:
    """A scratch folder whose files move into `folder` together at the end, or vanish if anything fails.

    Raises:
        InputError: the folder can't be made or written to.
    """
    make_folder(folder)
    with tempfile.TemporaryDirectory(prefix=".relight-", dir=folder) as scratch:
        try:
            yield Path(scratch)
        except InputError as error:
            # Nobody can look at, or mend, a scratch folder that is gone.
            raise InputError(str(error).replace(without_controls(scratch), str(folder))) from error
        made = sorted(Path(scratch).iterdir())
        for path in made:
            if (folder / path.name).is_dir():
                raise InputError(f"{folder / path.name}: is a folder; move it or choose another place")
        for path in made:
            os.replace(path, folder / path.name)


def check_report(place: Path, inputs: KnownFiles) -> None:
    """Raise InputError if one of the files of a report, PLACE.md, PLACE.json and maybe PLACE.png, is an input."""
    for path in map(place.with_suffix, (".md", ".json", ".png")):
        if (given := inputs.named(path)) is not None:
            raise InputError(f"{path}: that is the input {given}; choose another folder after -o")


def write_report(place: Path, page: str, record: dict) -> None:
    """What was measured, as PLACE.md for people and as PLACE.json for programs."""
    write_text(place.with_suffix(".md"), page)
    write_text(place.with_suffix(".json"), json.dumps(record, indent=1))


def write_text(path: Path, text: str) -> None:
    """A file of text, UTF-8, whole or not at all."""
    with whole_file(path) as beside:
        beside.write_text(text, encoding="utf-8")
