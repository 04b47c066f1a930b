"""Work on one photo as the editor keeps it aside: while a session or an undo is on its way, and for another photo."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path

from app.document.document import Document
from app.engine.sources import LightSource, PhotoSource


@dataclass(frozen=True)
class Opening:
    """A session that was asked for.

    Attributes:
        wish: for its photo.
        path: its file; None for work that no session file holds.
        document: what the file holds.
        before: the work before.
    """

    wish: PhotoSource
    path: Path | None
    document: Document
    before: Document

    @property
    def kept(self) -> KeptWork:
        """What files hold of it once it is open."""
        # Nothing equals a document without a photo, so work that no file holds stays unsaved.
        return KeptWork(self.path, self.document if self.path else Document(), self.document)


@dataclass(frozen=True)
class Undoing:
    """A step of the history that was gone to, while its photo or its light is not there yet.

    Attributes:
        step: which step was in force before.
        photo, light: the wishes that came of it.
    """

    step: int
    photo: PhotoSource | None
    light: LightSource

    def is_coming(self, photo: PhotoSource | None, light: LightSource, at_work: bool, in_force: bool) -> bool:
        """Whether it is still what is wanted and isn't there; another light that was asked for since is none of it.

        Args:
            at_work: the photo that is wanted is open.
            in_force: so it is, and the light is there.
        """
        return photo is self.photo and not (at_work if light is not self.light else in_force)

    def is_refused(self, photo: PhotoSource | None, light: LightSource, refused: Collection[object]) -> bool:
        """Whether it can't be gone to: one of its wishes is still what is wanted, and was refused."""
        gone_photo = photo is self.photo and photo in refused
        return gone_photo or (light is self.light and light in refused)


@dataclass(frozen=True)
class KeptWork:
    """The work on a photo, and what files hold of it.

    Attributes:
        session_path: the file the work was last saved to or opened from; None where there is none.
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
        """Whether the photo was more than looked at."""
        return self.session_path is not None or self.left != self.document

    def named(self, path: Path) -> KeptWork:
        """The same with the photo's path written like this, as documents are compared by it."""
        return replace(self, document=_named(self.document, path), left=_named(self.left, path))


def _named(document: Document, path: Path) -> Document:
    return replace(document, photo=document.photo and replace(document.photo, path=path))
