"""The name of a change, as the history lists it: "Turn light to 35°", "Shadow 0.60"."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, fields

from app.document.document import Document, PhotoRef
from relight_core.imaging.files import legible
from relight_core.lighting.light_edit import LightEdit
from relight_core.lighting.soft_box import SoftBox, box_title
from relight_core.pipeline.edit import Edit

_MINUS = "\N{MINUS SIGN}"
_SAME_PX = 0.01
_BACKGROUNDS = {"keep": "photo", "match": "matched", "light": "light", "transparent": "none"}


@dataclass(frozen=True)
class Change:
    """What differs between two documents.

    Attributes:
        touched: the names of what changed; two changes that touch the same can be one step.
        name: for people.
        alone: it is a step of its own, however soon it follows the one before.
    """

    touched: tuple[str, ...]
    name: str
    alone: bool = False


def change_between(before: Document, after: Document) -> Change | None:
    """What was done between the two; None where nothing was."""
    if before == after:
        return None
    if before.photo != after.photo:
        return _photo_change(before, after)
    if before.light != after.light:
        return Change(("light",), f"Light: {after.light.source().title}")
    if before.quality != after.quality:
        return Change(("quality",), f"Quality: {after.quality}")
    edited = _differing(before.edit, after.edit, "edit")
    lit = _differing(before.light_edit, after.light_edit, "light")
    touched = (*edited, *lit)
    same_added = before.light_edit.added_boxes == after.light_edit.added_boxes
    about_boxes = set(touched) <= {"light.boxes", "light.base", "light.apart"}
    if "light.apart" in touched and about_boxes and same_added:
        taken = "Take the light's lamps apart" if after.light_edit.apart else "Put the light's lamps back"
        return Change(touched, taken, alone=True)
    if before.light_edit.boxes and not after.light_edit.boxes and about_boxes:
        return Change(("light.boxes.delete",), _without_boxes(before.light_edit), alone=True)
    if len(touched) > 1:
        return Change(touched, _several(after))
    if touched == ("light.boxes",):
        return _box_change(before.light_edit, after.light_edit)
    return Change(touched, _setting(touched[0], after))


def _photo_change(before: Document, after: Document) -> Change:
    if before.photo and after.photo and before.photo.path == after.photo.path:
        if before.photo.boxes != after.photo.boxes:
            return Change(("faces",), _face_boxes(before.photo, after.photo), alone=True)
        if before.photo.strokes != after.photo.strokes:
            return Change(("outline",), _outline(before.photo, after.photo), alone=True)
        index = after.photo.face_index
        return Change(("face",), "All faces" if index is None else f"Face {index + 1}")
    return Change(("photo",), f"Open {legible(after.photo.path.name)}" if after.photo else "Close the photo")


def _face_boxes(before: PhotoRef, after: PhotoRef) -> str:
    if after.boxes is None:
        return "Faces as they are found"
    old, new = before.faces, after.faces
    if len(new) == len(old) + 1 and new[:-1] == old:
        return f"Add face {len(new)}"
    gone = [index for index, box in enumerate(old) if box not in new]
    if len(new) == len(old) - 1 and len(gone) == 1:
        return f"Remove face {gone[0] + 1}"
    if len(new) != len(old) or len(gone) != 1:
        return "Change the faces"
    was, now = old[gone[0]], new[gone[0]]
    same_size = abs(was.width - now.width) < _SAME_PX and abs(was.height - now.height) < _SAME_PX
    return f"{'Move' if same_size else 'Resize'} face {gone[0] + 1}"


def _outline(before: PhotoRef, after: PhotoRef) -> str:
    old, new = before.strokes, after.strokes
    if len(new) <= len(old) or new[: len(old)] != old:
        return "Outline as found" if not new else "Change the outline"
    adds = {stroke.adds for stroke in new[len(old) :]}
    if len(adds) > 1:
        return "Change the outline"
    return "Add to the person" if adds == {True} else "Take from the person"


def _differing(before: object, after: object, prefix: str) -> list[str]:
    return [
        f"{prefix}.{entry.name}"
        for entry in fields(before)
        if getattr(before, entry.name) != getattr(after, entry.name)
    ]


def _several(after: Document) -> str:
    is_opened = after.light_edit == after.light.source().opening_edit
    at_rest = after.edit == Edit(quality=after.edit.quality) and is_opened
    return "Reset all" if at_rest else "Change several settings"


def _without_boxes(before: LightEdit) -> str:
    return _deletion(before.boxes[0]) if len(before.boxes) == 1 else "Remove all soft boxes"


def _deletion(box: SoftBox) -> str:
    return f"Delete {box.name.lower() or 'soft box'}"


def _box_change(before: LightEdit, after: LightEdit) -> Change:
    if len(after.boxes) > len(before.boxes):
        return Change(("light.boxes.add",), "Add soft box", alone=True)
    if len(after.boxes) < len(before.boxes):
        gone = [box for index, box in enumerate(before.boxes) if after.boxes[index : index + 1] != (box,)]
        return Change(("light.boxes.delete",), _deletion(gone[0]), alone=True)
    moved = [index for index, (old, new) in enumerate(zip(before.boxes, after.boxes, strict=True)) if old != new]
    if len(moved) != 1:
        return Change(("light.boxes",), "Change soft boxes")
    index = moved[0]
    touched = {name.removeprefix("box.") for name in _differing(before.boxes[index], after.boxes[index], "box")}
    verb = next(verb for names, verb in _BOX_VERBS if touched <= names)
    if touched == {"off"}:
        verb = "Switch off" if after.boxes[index].off else "Switch on"
    key = "".join(sorted(touched))
    title = box_title(after.boxes, index)
    return Change((f"light.boxes.{index}.{key}",), f"{verb} {title[0].lower()}{title[1:]}")


_BOX_VERBS = (
    ({"azimuth_deg", "elevation_deg"}, "Move"),
    ({"width_deg", "height_deg"}, "Resize"),
    ({"width_deg", "height_deg", "form", "hole"}, "Shape of"),
    ({"softness"}, "Soften"),
    ({"kelvin", "colour"}, "Colour of"),
    ({"intensity"}, "Brightness of"),
    ({entry.name for entry in fields(SoftBox)}, "Change"),
)


def _setting(touched: str, after: Document) -> str:
    owner, _, field = touched.partition(".")
    value = getattr(after.edit if owner == "edit" else after.light_edit, field)
    words = _SETTINGS.get(touched)
    return words(value).replace("-", _MINUS) if words else field.replace("_", " ").capitalize()


def _effects(names: Collection[str]) -> str:
    return ", ".join(sorted(names)).replace("_", " ") or "nothing"


def _number(label: str, form: str) -> Callable[[float], str]:
    return lambda value: f"{label} {value:{form}}"


_SETTINGS: dict[str, Callable] = {
    "edit.yaw_deg": lambda value: f"Turn light to {round(value) + 0}°",
    "edit.exposure_ev": lambda value: f"Exposure {value:+.2f} EV",
    "edit.specular": _number("Specular", ".2f"),
    "edit.shadow": _number("Shadow", ".2f"),
    "edit.specular_tint": _number("Specular tint", "+.2f"),
    "edit.shadow_softness": _number("Shadow softness", ".2f"),
    "edit.strength": _number("Strength", ".2f"),
    "edit.background": lambda value: f"Background: {_BACKGROUNDS.get(value, value)}",
    "edit.forced_on": lambda value: f"Always computed: {_effects(value)}",
    "edit.forced_off": lambda value: f"Left out: {_effects(value)}",
    "edit.background_fov_deg": lambda value: f"Background width {value:.0f}°",
    "edit.background_blur_deg": lambda value: f"Background blur {value:.1f}°",
    "light.level_ev": lambda value: f"Light level {value:+.2f} EV",
    "light.metered": lambda value: "Meter the light" if value else "Light as its file says",
    "light.base": _number("Room light", ".2f"),
    "light.saturation": _number("Light saturation", ".2f"),
    "light.warmth": _number("Light warmth", "+.2f"),
    "light.tint": _number("Light tint", "+.2f"),
    "light.blur_deg": lambda value: f"Light blur {value:.0f}°",
}
