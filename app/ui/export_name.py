"""Where a picture goes: as named in the panel, in a line that may say anything while it is typed."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from app.engine.exporting import FORMS, default_export_path
from app.engine.places import from_home, full_path
from app.engine.sources import PhotoSource

if TYPE_CHECKING:
    from app.ui.state import EditorState

_OTHER_SPELLINGS = {".jpg": (".jpeg",), ".tif": (".tiff",)}
_SPELLINGS = tuple((form, *_OTHER_SPELLINGS.get(form, ())) for form in FORMS)
"""All suffixes of each kind of picture, the one of FORMS first."""

_SLASHES = ("/", os.sep)


def form_named(name: Path | str) -> str | None:
    """The kind of picture, one of FORMS, that a file's name says by its suffix; None where it says none."""
    suffix = os.path.splitext(name)[1].lower()
    return next((spellings[0] for spellings in _SPELLINGS if suffix in spellings), None)


def named_as(path: Path, suffix: str) -> Path:
    """The path with a suffix of a kind of file, such as ".png" or ".relight.json", whose kind is ".json".

    A path that has such a suffix stays as it is, in any spelling. The suffix of one kind of picture is replaced by that
    of another; otherwise the suffix is added to the name.
    """
    own, kind = path.suffix.lower(), Path("any" + suffix).suffix
    spellings = next((group for group in _SPELLINGS if kind in group), (kind,))
    if own in spellings:
        return path
    are_pictures = all(form_named(f"any{one}") is not None for one in (own, kind))
    return path.with_suffix(suffix) if are_pictures else path.with_name(path.name + suffix)


def named_place(typed: str, suggested: Path, suffix: str | None) -> Path:
    """The whole path of what was typed; what names no file, such as "/", means the suggested one.

    In a folder, said by a slash behind its name, the file lies under the suggested name.

    Args:
        suggested: the place beside the photo, in whose folder a name alone lies.
        suffix: the kind of file it becomes; None leaves it as it was typed.
    """
    path = suggested.parent / from_home(Path(typed))
    if _is_folder(typed):
        path /= suggested.name
    elif not _is_name(typed):
        path = suggested
    return path if suffix is None else named_as(path, suffix)


def _is_folder(typed: str) -> bool:
    return typed.endswith(_SLASHES) and bool(typed.strip("".join(_SLASHES)))


def _is_name(typed: str) -> bool:
    return Path(typed).name not in ("", "~", "..")


def suggested_place(state: EditorState) -> Path:
    """Where a picture of the open photo goes that is not named otherwise: beside it, as a PNG."""
    opened = state.snapshot.opened
    return default_export_path(opened.source.path if opened else None)


def suggested_name(state: EditorState) -> str:
    """What stands in the line unless something else is typed there."""
    return suggested_place(state).with_suffix(state.export.form).name


def export_place(state: EditorState, suffix: str | None = None) -> Path:
    """Where the next picture of the open photo goes, as a full path, without a number; as of `named_place`."""
    return full_path(named_place(state.export_path, suggested_place(state), suffix))


def choose_form(state: EditorState, suffix: str) -> None:
    """Export another kind of file from now on; the name in sight says so."""
    state.export = replace(state.export, form=suffix)
    if state.export_path:
        export_to(state, export_place(state, suffix))


def take_named_form(state: EditorState) -> None:
    """Once a name is typed: export the kind of file that it says. A space behind it is no part of it.

    Where what is typed names nothing, the name that the picture has then is in sight instead.
    """
    state.export_path = state.export_path.rstrip()
    if not _is_folder(state.export_path) and not _is_name(state.export_path):
        state.export_path = suggested_name(state)
    form = form_named(state.export_path)
    if form is not None and form != state.export.form:
        choose_form(state, form)


def export_to(state: EditorState, path: Path) -> None:
    """Let the next export go there, as the kind of file the name says; beside the photo a name alone is kept."""
    beside, full = suggested_place(state), full_path(path)
    folders = beside.parent, full_path(beside).parent
    state.export_path = path.name if path.parent in folders or full.parent in folders else str(full)
    take_named_form(state)


def place_for(state: EditorState, photo: PhotoSource | None, suffix: str | None = None) -> Path:
    """Where the next picture of a photo goes, as a whole path, without a number.

    Args:
        photo: the open one, which the line in the panel is about, or one that is on its way.
        suffix: as of `named_place`.
    """
    opened = state.snapshot.opened
    if opened is None or photo is None or photo.path == opened.source.path:
        return export_place(state, suffix)
    return named_place("", default_export_path(photo.path), suffix)
