"""The queue: photos that were opened together, one of which is shown."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path


@dataclass(frozen=True)
class PhotoQueue:
    """Photos in the order in which they were dropped.

    Attributes:
        paths: the files.
        at: index of the one that was asked for last, or of the open one where that was refused.
        is_beside: another photo than that is open.
        passed: indices of those that were refused since the open one was asked for.
    """

    paths: tuple[Path, ...] = ()
    at: int = 0
    is_beside: bool = False
    passed: frozenset[int] = frozenset()

    @property
    def current(self) -> Path | None:
        """The file at `at`."""
        return self.paths[self.at] if self.paths else None

    def step(self, by: int) -> PhotoQueue | None:
        """The queue some photos further on, past those that were refused; None beyond its ends."""
        at = self.at + by
        while at in self.passed:
            at += 1 if by > 0 else -1
        return PhotoQueue(self.paths, at, passed=self.passed) if 0 <= at < len(self.paths) else None

    def refused(self, before: PhotoQueue, stays: Path | None) -> PhotoQueue:
        """The queue after its current photo was refused: at the open photo again, where that is one of it.

        A new queue is replaced by the one before it, unless that has at most one photo and the new one has others to
        step to.

        Args:
            before: the queue of the photo that stays open.
            stays: the photo that stays open; None if the window is empty.
        """
        is_fresh = self.paths != before.paths
        comes_back = is_fresh and (len(before.paths) > 1 or len(self.paths) == 1)
        if comes_back:
            return before
        if stays is None:
            return self
        there = (self if is_fresh else before).showing(stays)
        if there.is_beside:
            return replace(self, is_beside=True)
        return there if there.at == self.at else replace(there, passed=self.passed | {self.at})

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
