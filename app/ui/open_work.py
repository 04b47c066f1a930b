"""Records of work that is put aside: while a session or an undo is loading, and while another photo is open."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path

from app.document.document import Document
from app.engine.sources import LightSource, PhotoSource


@dataclass(frozen=True)
class Opening:
    """A session that was asked for and is not there yet.

    Attributes:
        wish: for its photo.
        path: its file; None for work that no session file holds.
        document: what the file holds.
        before: the document to return to if the photo is refused.
    """

    wish: PhotoSource
    path: Path | None
    document: Document
    before: Document

    @property
    def kept(self) -> KeptWork:
        """The work on its photo once that is open."""
        # Nothing equals a document without a photo, so work that no file holds stays unsaved.
        return KeptWork(self.path, self.document if self.path else Document(), self.document)


@dataclass(frozen=True)
class Undoing:
    """An undo or redo whose photo or light is not there yet.

    Attributes:
        step: index of the step that was in force before.
        photo, light: the wishes that it made.
    """

    step: int
    photo: PhotoSource | None
    light: LightSource

    def is_coming(self, photo: PhotoSource | None, light: LightSource, at_work: bool, in_force: bool) -> bool:
        """Whether its photo, or its light, is still wanted and not there yet.

        Args:
            photo, light: what is wanted now; a light that was asked for since does not count.
            at_work: the wanted photo is open.
            in_force: the wanted photo is open and the light is there.
        """
        return photo is self.photo and not (at_work if light is not self.light else in_force)

    def is_refused(self, photo: PhotoSource | None, light: LightSource, refused: Collection[object]) -> bool:
        """Whether one of its wishes is still wanted and was refused."""
        gone_photo = photo is self.photo and photo in refused
        return gone_photo or (light is self.light and light in refused)


@dataclass(frozen=True)
class KeptWork:
    """The work on a photo, put aside, and what its session file holds.

    Attributes:
        session_path: the file that the work was last saved to or opened from; None if there is none.
        document: the work as that file has it, or as the photo was opened.
        left: the work as it was when another photo was asked for.
        is_refused: the photo could not be opened again with its faces as they were left.
    """

    session_path: Path | None
    document: Document
    left: Document
    is_refused: bool = False

    @property
    def is_work(self) -> bool:
        """Whether the photo has a session or was changed, and was not just looked at."""
        return self.session_path is not None or self.left != self.document

    def named(self, path: Path) -> KeptWork:
        """The same with the photo's path written like this, as documents are compared by it."""
        return replace(self, document=_named(self.document, path), left=_named(self.left, path))


def _named(document: Document, path: Path) -> Document:
    return replace(document, photo=document.photo and replace(document.photo, path=path))
