"""A light as the user made it, as JSON: the base it starts from, what was changed, and the soft boxes.

A light file carries one light and its turn; a session carries the same group under "light".
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from pathlib import Path, PurePath

from app.document.document import LightRef
from app.document.json_fields import (
    Fields,
    NotThereError,
    path_for_file,
    path_from_file,
    read_json,
    write_json,
)
from app.engine.sources import LIGHT_KINDS, LIGHTS_FROM_FILES, PICTURE_SUFFIXES
from relight_core.errors import InputError
from relight_core.lighting.light_edit import LIGHT_EDIT_RANGES, MOST_BOXES, LightEdit
from relight_core.lighting.rig_description import FORMS
from relight_core.lighting.rigs import rig_names
from relight_core.lighting.soft_box import SOFT_BOX_RANGES, SoftBox

KIND, VERSION = "light", 2
"""Version 1 knew square soft boxes only, and no lamps of the light's own."""

LIGHT_SUFFIX = ".light.json"
_LONGEST_NAME = 40


@dataclass(frozen=True)
class SavedLight:
    """What a light file holds.

    Attributes:
        light: the base.
        light_edit: what was changed about it.
        yaw_deg: its turn, [-180, 180].
        notes: what was mended in reading, a line each.
    """

    light: LightRef
    light_edit: LightEdit = field(default_factory=LightEdit)
    yaw_deg: float = 0.0
    notes: tuple[str, ...] = ()


def write_light(path: Path, saved: SavedLight) -> None:
    """Write a light file.

    Raises:
        InputError: a place that can't be written, or a light that only exists inside an open photo.
    """
    if saved.light.kind == "own":
        raise InputError("The photo's own light belongs to that photo; save the session instead")
    content = {"yaw_deg": saved.yaw_deg, "light": light_content(saved.light, saved.light_edit, path.parent)}
    write_json(path, KIND, VERSION, content)


def read_light(path: Path) -> SavedLight:
    """Read a light file.

    Raises:
        InputError: not a light file, or one that can't be used; the line says why.
    """
    notes: list[str] = []
    fields = read_json(path, KIND, VERSION, notes)
    yaw_deg = fields.number("yaw_deg", -180.0, 180.0, 0.0)
    light, light_edit = read_light_content(fields.group("light"), path)
    if light.kind == "own":
        raise InputError(f"{path}: its light is a photo's own, and it names no photo; open a session or the portrait")
    fields.finish()
    return SavedLight(light, light_edit, yaw_deg, tuple(notes))


def light_content(light: LightRef, edit: LightEdit, folder: Path | None) -> dict:
    """A light as JSON holds it; file names relative to `folder`, or in full for None."""
    name = light.name
    if light.kind in LIGHTS_FROM_FILES:
        name = path_for_file(Path(name), folder)
    return {"kind": light.kind, "name": name} | asdict(edit)


def read_light_content(fields: Fields, path: Path, stand_in: LightRef | None = None) -> tuple[LightRef, LightEdit]:
    """The light in a file's group.

    Args:
        path: of the file, which names in it are relative to.
        stand_in: takes the place of a light whose file can't be had, with the soft boxes; None refuses.

    Raises:
        InputError: a light that isn't there, or values that are none.
    """
    kind = fields.text("kind")
    name = fields.text("name", "")
    if kind not in LIGHT_KINDS:
        raise InputError(f"{path}: an unknown kind of light {kind[:40]!r}; update relight, or mend the file")
    if kind == "rig" and name not in rig_names():
        raise InputError(f"{path}: there is no bundled light {name[:80]!r}; choose another in the file")
    if kind in LIGHTS_FROM_FILES:
        try:
            name = str(path_from_file(name, path.parent, PICTURE_SUFFIXES, str(path)))
        except InputError as error:
            if stand_in is None:
                raise
            fault = "is not there" if isinstance(error, NotThereError) else "can't be used"
            fields.note(f"the light {PurePath(name).name:.80} {fault}, and {stand_in.source().title} stands in for it")
            # Level, colour and blur were changes to the light that is gone; boxes and the room's share stay.
            return stand_in, _light_edit(fields).added
    light_edit = _light_edit(fields)
    return LightRef(kind, name if kind != "own" else ""), light_edit


def _light_edit(fields: Fields) -> LightEdit:
    defaults = LightEdit()
    values = {key: fields.number(key, *LIGHT_EDIT_RANGES[key], getattr(defaults, key)) for key in LIGHT_EDIT_RANGES}
    boxes = tuple(_box(group) for group in fields.groups("boxes", MOST_BOXES))
    metered, apart = fields.flag("metered"), fields.flag("apart")
    fields.finish()
    return LightEdit(**values, boxes=boxes, metered=metered, apart=apart)


def _box(fields: Fields) -> SoftBox:
    defaults = SoftBox()
    values = {key: fields.number(key, *SOFT_BOX_RANGES[key], getattr(defaults, key)) for key in SOFT_BOX_RANGES}
    colour, form = fields.triple("colour"), fields.word("form", FORMS, defaults.form)
    off = fields.flag("off")
    name = "".join(filter(str.isprintable, fields.text("name", "")))[:_LONGEST_NAME]
    fields.finish()
    return SoftBox(**values, colour=colour, form=form, off=off, name=name)
