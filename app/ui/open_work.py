"""Work on one photo as the editor keeps it aside: while a session or an undo is on its way, and for another photo."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
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
        return KeptWork(self.path, self.document if self.path else Document())


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

    def is_refused(self, photo: PhotoSource | None, light: LightSource, refused: Collection[object]) -> bool:
        """Whether it can't be gone to: one of its wishes is still what is wanted, and was refused."""
        gone_photo = photo is self.photo and photo in refused
        return gone_photo or (light is self.light and light in refused)


@dataclass(frozen=True)
class KeptWork:
    """What files hold of the work on a photo.

    Attributes:
        session_path: the file the work was last saved to or opened from; None where there is none.
        document: the work as that file has it, or as the photo was opened.
    """

    session_path: Path | None
    document: Document
