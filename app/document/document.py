"""Everything undo and a session keep: which photo, which light, and all that was set."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from app.engine.resized import Size
from app.engine.sources import LightSource, PhotoSource
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.lighting.light_edit import LightEdit
from relight_core.pipeline.auto_quality import AUTO
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.per_photo.brush import BrushStroke


@dataclass(frozen=True)
class PhotoRef:
    """A portrait by its file, and who in it is relit.

    Attributes:
        face_index: of the faces, the only one; None is all of them.
        boxes: where the faces are, once the user has corrected that; None is wherever the finder sees them.
        found: what the finder saw, for the names of changes; no part of what is equal.
        strokes: of the brush, who is person and what is not.
        size: of the photo that boxes and strokes were made on, or None, as of app.engine.sources.PhotoSource; no part
            of what is equal, since it doesn't change where they are.
    """

    path: Path
    face_index: int | None = None
    boxes: tuple[FaceBox, ...] | None = None
    found: tuple[FaceBox, ...] = field(default=(), compare=False)
    strokes: tuple[BrushStroke, ...] = ()
    size: Size | None = field(default=None, compare=False)

    @classmethod
    def of(cls, source: PhotoSource, path: Path, found: tuple[FaceBox, ...] = ()) -> PhotoRef:
        """What a wish wants of the photo in a file."""
        return cls(path, source.face_index, source.boxes, found, source.strokes, source.size)

    def wish(self, photo: Photo | None = None) -> PhotoSource:
        """A wish for this portrait; with its pixels where they have been read."""
        wish = PhotoSource(self.path, self.face_index, self.boxes, self.strokes, self.size)
        return wish if photo is None else wish.on(photo)

    @property
    def faces(self) -> tuple[FaceBox, ...]:
        """Where the faces are, by hand or as found."""
        return self.found if self.boxes is None else self.boxes


@dataclass(frozen=True)
class LightRef:
    """A light by its kind and name, as of app.engine.sources.LightSource, but equal where both are the same."""

    kind: str
    name: str = ""

    @classmethod
    def of(cls, source: LightSource) -> LightRef:
        """The light that a wish names."""
        return cls(source.kind, source.name)

    def source(self) -> LightSource:
        """A wish for this light."""
        return LightSource(self.kind, self.name)


@dataclass(frozen=True)
class Document:
    """One state of the user's work. Equal documents give the same picture.

    Attributes:
        photo: None before anything is opened.
        light: the base of the light.
        light_edit: what was changed about it.
        edit: the sliders; always of quality "final", with every channel.
        quality: the tier the user works at, or "auto".
    """

    photo: PhotoRef | None = None
    light: LightRef = LightRef("rig", "rembrandt")
    light_edit: LightEdit = field(default_factory=LightEdit)
    edit: Edit = field(default_factory=lambda: Edit(quality="final"))
    quality: str = AUTO
