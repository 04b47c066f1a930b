"""The queue: photos that were opened together, one of which is shown."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path


@dataclass(frozen=True)
class PhotoQueue:
    """Photos in the order in which they were dropped.

    Attributes:
        paths: the files.
        at: index of the one that was asked for last.
        is_beside: another photo than that is open.
    """

    paths: tuple[Path, ...] = ()
    at: int = 0
    is_beside: bool = False

    @property
    def current(self) -> Path | None:
        """The file that was asked for last."""
        return self.paths[self.at] if self.paths else None

    def step(self, by: int) -> PhotoQueue | None:
        """The queue some photos further on, or None beyond its ends."""
        at = self.at + by
        return PhotoQueue(self.paths, at) if 0 <= at < len(self.paths) else None

    def refused(self, before: PhotoQueue, stays: Path | None) -> PhotoQueue:
        """The queue after its current photo was refused.

        A new queue is replaced by the one before it, unless that has at most one photo and the new one has others to
        step to.

        Args:
            before: the queue of the photo that stays open.
            stays: the photo that stays open; None if the window is empty.
        """
        is_fresh = self.paths != before.paths
        comes_back = is_fresh and (len(before.paths) > 1 or len(self.paths) == 1)
        return before if comes_back else replace(self, is_beside=stays is not None and not self._is_at(stays))

    def showing(self, path: Path | None) -> PhotoQueue:
        """The queue when a photo was opened in another way than by stepping, such as by undo."""
        places = [place.absolute() for place in self.paths]
        if not places:
            return self
        if path is None or path.absolute() not in places:
            return replace(self, is_beside=True)
        return PhotoQueue(self.paths, self.at if self._is_at(path) else places.index(path.absolute()))

    def _is_at(self, path: Path) -> bool:
        return self.current is not None and self.current.absolute() == path.absolute()

    @property
    def label(self) -> str:
        """ "2 of 7"; without a number while another photo is open."""
        if self.is_beside:
            return f"– of {len(self.paths)}"
        return f"{self.at + 1} of {len(self.paths)}"
