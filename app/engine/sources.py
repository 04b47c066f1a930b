"""What the window asks the engine for: immutable records, compared by identity where they name a file."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np

from app.engine.resized import Size, at_size, size_of
from relight_core.errors import InputError, NoFaceError
from relight_core.imaging.files import legible
from relight_core.imaging.formats.raster import RAW_SUFFIXES
from relight_core.lighting.light_edit import LightEdit
from relight_core.pipeline.edit import Edit

if TYPE_CHECKING:
    from relight_core.face.find import FaceBox
    from relight_core.imaging.photo import Photo
    from relight_core.lighting.environment import Environment
    from relight_core.pipeline.per_photo.brush import BrushStroke
    from relight_core.pipeline.results.display import DisplayRecipe
    from relight_core.pipeline.results.picture import Picture

PANORAMA_SUFFIXES = (".hdr", ".exr")
PHOTO_SUFFIXES = (
    ".jpg",
    ".jpeg",
    ".jpe",
    ".jfif",
    ".png",
    ".tif",
    ".tiff",
    ".heic",
    ".heif",
    ".hif",
    ".webp",
    ".avif",
    ".bmp",
    ".exr",
)
"""Taken from folders. Raw files are not: most lie there beside a JPEG of the same name."""

PICTURE_SUFFIXES = (*PHOTO_SUFFIXES, *RAW_SUFFIXES, ".hdr")


LIGHTS_FROM_FILES = ("panorama", "portrait")
LIGHT_KINDS = ("rig", *LIGHTS_FROM_FILES, "own")
"""What `LightSource.kind` may be; settings, sessions and light files have these words in them."""

BORROWED_AT = "final"
"""The quality of de-lighting that tells the light of a portrait, wherever that light is lent to another photo."""


def borrowed_light(relighter: RelighterLike, lender: Photo) -> Environment:
    """The light that a photo was taken under; the photo becomes the relighter's portrait.

    Raises:
        InputError: there is no face in it.
    """
    try:
        relighter.set_portrait(lender)
    except NoFaceError:
        raise no_light_to_borrow(lender.path) from None
    return relighter.estimated_light(BORROWED_AT)


def base_light(
    light: LightSource, borrow: Callable[[Path], Environment], estimate_own: Callable[[], Environment]
) -> Environment:
    """The light that a wish names, before anything is changed about it.

    Args:
        borrow: estimates the light that the portrait in a file was taken under.
        estimate_own: estimates the light that the open photo was taken under.

    Raises:
        InputError: there is no such rig or file, or the file is bad.
    """
    from relight_core.lighting.environment import read_environment
    from relight_core.lighting.rigs import load_rig

    if light.kind == "rig":
        return load_rig(light.name)
    if light.kind == "panorama":
        return read_environment(Path(light.name))
    return borrow(Path(light.name)) if light.kind == "portrait" else estimate_own()


def no_light_to_borrow(portrait: Path) -> InputError:
    """What is told of a picture whose light can't be borrowed: where a face is can be said of the photo alone."""
    return InputError(f"{portrait}: no face found to borrow light from; choose a portrait in which one is larger")


class RelighterLike(Protocol):
    """The part of relight_core.pipeline.relighter.Relighter that the engine uses."""

    def set_portrait(
        self,
        photo: Photo,
        face_index: int | None = None,
        boxes: Sequence[FaceBox] | None = None,
        strokes: Sequence[BrushStroke] = (),
    ) -> None:
        """Make a photo the portrait; slow. InputError, NoFaceError too, leaves the previous portrait in place."""

    @property
    def people(self) -> Sequence[FaceBox]:
        """Everyone in the portrait, as face_index counts them."""

    def relight(
        self, environment: Environment, edit: Edit, longest_side_px: int | None = None, *, for_shader: bool = False
    ) -> RelitLike:
        """The portrait under a light, no larger than that, as pixels or as what a shader draws; fast."""

    def estimated_light(self, quality: str) -> Environment:
        """The light the portrait was taken under, as de-lighting at that quality sees it."""

    def get_ready(self, environment: Environment, edit: Edit) -> None:
        """Find out what an edit's quality needs to know of the portrait once, before it relights."""

    def forget_lights(self) -> None:
        """Drop what came with a light or an edit, so that the next picture is made anew."""


class RelitLike(Protocol):
    """The part of relight_core.pipeline.relighter.Relit that the window uses."""

    image: np.ndarray | None
    alpha: np.ndarray | None
    recipe: DisplayRecipe | None
    channels: dict[str, np.ndarray]
    faces: list
    stages: dict
    window: tuple[float, float, float, float] | None
    roll_deg: float
    full: Picture | None
    level_as_in_photo_ev: Callable[..., float]
    outline: Callable[[], list[np.ndarray]]
    channels_together: Callable[[], list[dict[str, np.ndarray]]]


@dataclass(frozen=True, eq=False)
class PhotoSource:
    """One wish to open a photo: opening the same path again is another wish.

    Attributes:
        place: the file, or a decoded photo.
        face_index: which face alone; None is all of them.
        boxes: where the faces are; None is wherever the finder sees them.
        strokes: of the brush, who is person and what is not.
        size: of the photo that boxes and strokes were made on; None is whichever it turns out to have.
    """

    place: Path | Photo
    face_index: int | None = None
    boxes: tuple[FaceBox, ...] | None = None
    strokes: tuple[BrushStroke, ...] = ()
    size: Size | None = None

    def on(self, photo: Photo) -> PhotoSource:
        """Another wish for the same in the photo as it was read: boxes and strokes are where they belong in that."""
        return replace(at_size(self, size_of(photo)), place=photo)

    @property
    def path(self) -> Path | None:
        """The file behind it, if there is one."""
        return self.place if isinstance(self.place, Path) else self.place.path

    @property
    def name(self) -> str:
        """For messages."""
        return legible(self.path.name) if self.path else "the photo"


@dataclass(frozen=True, eq=False)
class LightSource:
    """One wish for a light.

    Attributes:
        kind: one of LIGHT_KINDS: "rig" (a bundled one, by name), "panorama" (an .hdr or .exr file), "portrait" (the
            light that the photo in a file was taken under) or "own" (the same, of the open photo).
        name: the rig's name or the file; empty for "own".
    """

    kind: str
    name: str = ""

    @classmethod
    def named(cls, text: str) -> LightSource:
        """A light as the command line names it: a rig, an .hdr or .exr file, or a portrait.

        A file is named in full, so that it is the same light however it was named.
        """
        from relight_core.lighting.rigs import rig_names

        if text in rig_names():
            return cls("rig", text)
        return cls("panorama" if text.lower().endswith(PANORAMA_SUFFIXES) else "portrait", os.path.abspath(text))

    @property
    def is_from_file(self) -> bool:
        """Whether `name` is a file, which may be gone or have changed."""
        return self.kind in LIGHTS_FROM_FILES

    @property
    def title(self) -> str:
        """For the list of lights."""
        if self.kind == "own":
            return "Original"
        if self.kind == "rig":
            return self.name.replace("-", " ").capitalize()
        return legible(Path(self.name).stem)

    @property
    def opening_edit(self) -> LightEdit:
        """How the light is opened: panoramas, which come in units of their own, are metered.

        All others are in the photo's units: rigs were made so, and borrowed light comes from a photo.
        """
        return LightEdit(metered=self.kind == "panorama")

    def opened_around(self, before: LightEdit) -> LightEdit:
        """How the light is opened in the place of another: the user's soft boxes stay, and the room's share with them.

        Level, colour and blur were changes to the light before, and lamps of its own go with it.
        """
        added = before.added
        return replace(self.opening_edit, base=added.base, boxes=added.boxes)

    def same_as(self, other: LightSource | None) -> bool:
        """Whether the other wish is for the same light."""
        return other is not None and (self.kind, self.name) == (other.kind, other.name)


@dataclass(frozen=True)
class Request:
    """Everything the window wants to see; only the newest counts. Equal where it asks for the same wishes.

    Attributes:
        photo: None before anything is opened.
        light: None keeps the light in force.
        light_edit: what is changed about that light.
        edit: the sliders. Its exposure is the shader's business and makes the engine do nothing.
        longest_side_px: the picture of a large photo may be this small; None wants it as large as the photo.
        in_motion: what the hand's next movement will ask for, to get ready for it while the hand rests; None where it
            will be of this edit's own quality.
        outlined: the people's outline is wanted beside the picture.
    """

    photo: PhotoSource | None = None
    light: LightSource | None = None
    edit: Edit = field(default_factory=Edit)
    light_edit: LightEdit = field(default_factory=LightEdit)
    longest_side_px: int | None = None
    in_motion: Edit | None = None
    outlined: bool = False
