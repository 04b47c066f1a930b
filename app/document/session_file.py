"""A session: the photo, its light and every slider, as JSON beside the photo."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from app.document.brush_strokes import brush_strokes_content, read_brush_strokes
from app.document.document import Document, LightRef, PhotoRef
from app.document.face_boxes import face_boxes_content, read_face_boxes
from app.document.json_fields import (
    Fields,
    holds_json,
    kind_of,
    path_for_file,
    path_from_file,
    read_json,
    write_json,
)
from app.document.light_file import SavedLight, light_content, read_light, read_light_content
from app.document.photo_size import photo_size_content, read_photo_size
from app.engine.batch import name_beside_a_namesake
from app.engine.places import folder_for_outputs
from app.engine.sources import PICTURE_SUFFIXES
from relight_core.errors import InputError
from relight_core.imaging.files import is_same_file
from relight_core.pipeline.auto_quality import AUTO
from relight_core.pipeline.edit import EDIT_RANGES, EFFECTS, Edit, check_background
from relight_core.pipeline.quality import TIERS

KIND, VERSION = "session", 6
"""Version 1 knew no boxes of faces, version 2 no strokes of the brush, version 3 no lamps of the light's own, version 4
no strength, version 5 no size of the photo."""

SESSION_SUFFIX = ".relight.json"
NARROWEST_BACKGROUND_DEG = 5.0
"""The least of a light that is seen behind a person in the editor, across the longer side."""
_EDIT_RANGES = {
    "yaw_deg": (-180.0, 180.0),
    "exposure_ev": (-16.0, 16.0),
    **{name: EDIT_RANGES[name] for name in ("specular", "shadow", "specular_tint", "shadow_softness", "strength")},
    "background_fov_deg": (NARROWEST_BACKGROUND_DEG, EDIT_RANGES["background_fov_deg"][1]),
    "background_blur_deg": EDIT_RANGES["background_blur_deg"],
}
_FORCED = ("forced_on", "forced_off")


@dataclass(frozen=True)
class Session:
    """What a session file holds.

    Attributes:
        document: the work.
        notes: what was mended in reading, a line each.
        lost_light: the note that another light stands in for the file's; the document is not what the file holds then.
    """

    document: Document
    notes: tuple[str, ...] = ()
    lost_light: str | None = None

    def told(self, light_follows: bool) -> list[str]:
        """The notes that matter where another light takes the place of the session's, or where it doesn't."""
        return [note for note in self.notes if not light_follows or note != self.lost_light]


@dataclass(frozen=True)
class LentLight:
    """A light from a file of ours, to be used on any photo.

    Attributes:
        saved: the light; never of kind "own".
        photo: of the session it comes from; None where that is not there, or it comes from a light file.
    """

    saved: SavedLight
    photo: PhotoRef | None = None


def session_path(photo: Path) -> Path:
    """Where a photo's session is saved: beside it, or where its exports go if that is no place for them."""
    return folder_for_outputs(photo) / (photo.stem + SESSION_SUFFIX)


def saved_session(photo: Path) -> Path | None:
    """The newest session that was saved of just this photo: beside it, or where its exports go.

    Where its name was taken, it is called as of `free_session_path`.
    """
    folders = dict.fromkeys((photo.absolute().parent, folder_for_outputs(photo)))
    places = [place for folder in folders for place in _places_in(folder, photo)]
    saved = {path: saved_s for path in places if (saved_s := _saved_s(path, photo)) is not None}
    return max(saved, key=saved.get, default=None)


def free_session_path(path: Path, photo: Path) -> Path:
    """Where a photo's session goes when its name is taken: of a.png's a.relight.json that is a-png.relight.json.

    Other names, and that one too where it is taken, get the first number that is free.
    """
    ending = SESSION_SUFFIX if path.name.lower().endswith(SESSION_SUFFIX) else path.suffix
    name = path.name[: len(path.name) - len(ending)]
    if name == photo.stem:
        name = name_beside_a_namesake(photo)
    return next(place for place in _numbered(path.parent, name, ending) if not os.path.lexists(place))


def _numbered(folder: Path, name: str, ending: str) -> Iterator[Path]:
    yield folder / (name + ending)
    for number in itertools.count(2):
        yield folder / f"{name}-{number}{ending}"


def _places_in(folder: Path, photo: Path) -> list[Path]:
    """Where a photo's sessions may be in a folder: under its name, and as `free_session_path` has named them there."""
    numbered = _numbered(folder, name_beside_a_namesake(photo), SESSION_SUFFIX)
    return [folder / (photo.stem + SESSION_SUFFIX), *itertools.takewhile(os.path.lexists, numbered)]


def _saved_s(path: Path, photo: Path) -> float | None:
    """When a session that names this photo was saved, be the rest of it of use or not; None where there is none."""
    try:
        fields = read_json(path, KIND, VERSION, [])
        named = path_from_file(fields.text("photo"), path.parent, PICTURE_SUFFIXES, str(path))
        return os.path.getmtime(path) if is_same_file(photo, named) else None
    except (InputError, OSError):
        return None


def write_session(path: Path, document: Document, *, relative: bool = True) -> None:
    """Write a session file, whole or not at all; replaces an earlier one.

    Args:
        relative: name files relative to the session, so that a folder can be moved as a whole.

    Raises:
        InputError: a place that can't be written, or a document without a photo.
    """
    if document.photo is None:
        raise InputError("There is no photo to save a session of; open one first")
    write_json(path, KIND, VERSION, _content(document, path.parent if relative else None))


def holds_work(path: Path, document: Document) -> bool:
    """Whether a session file holds just this, as it was opened from there or saved there.

    It does, too, where that photo or that light is not there any more.
    """
    content = _content(document, path.parent)
    try:
        return holds_json(path, KIND, VERSION, content) or _content(read_session(path).document, path.parent) == content
    except InputError:
        return False


def _content(document: Document, folder: Path | None) -> dict:
    edit = document.edit
    return {
        "photo": path_for_file(document.photo.path, folder),
        "photo_size": photo_size_content(document.photo.size),
        "face": document.photo.face_index,
        "face_boxes": face_boxes_content(document.photo.boxes),
        "brush_strokes": brush_strokes_content(document.photo.strokes),
        "light": light_content(document.light, document.light_edit, folder),
        "quality": document.quality,
        "edit": {key: getattr(edit, key) for key in _EDIT_RANGES}
        | {"background": edit.background}
        | {key: sorted(getattr(edit, key)) for key in _FORCED},
    }


def read_session(path: Path) -> Session:
    """Read a session file and check every value in it.

    A light that is gone is no reason to keep sliders and boxes from the user: that of a new document takes the place of
    one whose file can't be had, and is noted.

    Raises:
        InputError: not a session, or one that can't be used; the line says why.
    """
    notes: list[str] = []
    fields = read_json(path, KIND, VERSION, notes)
    photo = _photo(fields, path)
    stand_in, already = Document().light, len(notes)
    light, light_edit = read_light_content(fields.group("light"), path, stand_in)
    edit = _edit(fields.group("edit"), path)
    quality = fields.word("quality", (AUTO, *TIERS), AUTO)
    fields.finish()
    lost_light = notes[already] if light is stand_in else None
    return Session(Document(photo, light, light_edit, edit, quality), tuple(notes), lost_light)


def read_lent_light(path: Path) -> LentLight:
    """The light of a light file, or of a session, for whichever photo.

    Nothing else in a session has to be of use. Where its light is that of its own photo, a portrait lends it.

    Raises:
        InputError: neither of them, or the light can't be had; the line says why.
    """
    if kind_of(path) != KIND:
        return LentLight(read_light(path))
    notes: list[str] = []
    fields = read_json(path, KIND, VERSION, notes)
    light, light_edit = read_light_content(fields.group("light"), path)
    yaw_deg = fields.group("edit").number("yaw_deg", *_EDIT_RANGES["yaw_deg"], 0.0)
    saved = SavedLight(light, light_edit, yaw_deg, tuple(notes))
    if light.kind == "own":
        photo = _photo(fields, path)
        return LentLight(replace(saved, light=LightRef("portrait", str(photo.path))), photo)
    try:
        return LentLight(saved, _photo(fields, path))
    except InputError:
        return LentLight(saved)


def _photo(fields: Fields, path: Path) -> PhotoRef:
    photo = path_from_file(fields.text("photo"), path.parent, PICTURE_SUFFIXES, str(path))
    boxes, strokes = read_face_boxes(fields, path), read_brush_strokes(fields, path)
    return PhotoRef(photo, fields.index("face"), boxes, strokes=strokes, size=read_photo_size(fields, path))


def _edit(fields: Fields, path: Path) -> Edit:
    defaults = Edit(quality="final")
    values = {key: fields.number(key, *_EDIT_RANGES[key], getattr(defaults, key)) for key in _EDIT_RANGES}
    background = fields.text("background", defaults.background)
    try:
        check_background(background)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    forced = {key: fields.words(key, EFFECTS) for key in _FORCED}
    fields.finish()
    return Edit(**values, **forced, background=background, quality="final")
