"""Undo and redo: documents in the order in which they came about, one step for each movement of the hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from app.document.document import Document
from app.document.naming import Change, change_between
from relight_core.imaging.files import legible

MOST_STEPS = 300
TOGETHER_S = 0.8
"""Wheel steps and key presses that change the same thing within this time are one step."""


@dataclass(frozen=True)
class Step:
    """One entry of the list.

    Attributes:
        name: what was done.
        document: what it led to.
        touched: what it changed, as of app.document.naming.Change.
        last_s: when it was last added to.
    """

    name: str
    document: Document
    touched: tuple[str, ...] = ()
    last_s: float = 0.0


class History:
    """The steps so far and which of them is in force.

    Attributes:
        steps: oldest first.
        at: which is in force, or -1 before the first.
        left: which was in force before the newest undo, redo or jump, or -1.
    """

    def __init__(self) -> None:
        self.steps: list[Step] = []
        self.at = self.left = -1
        self._present: Document | None = None

    @property
    def can_undo(self) -> bool:
        """Whether there is an earlier step, or a change that is no step yet."""
        return self.at > 0 or self.is_ahead

    @property
    def can_redo(self) -> bool:
        """Whether a step was undone that can come back."""
        return self.at + 1 < len(self.steps)

    def observe(self, document: Document, resting: bool, now_s: float, turning: bool = False) -> None:
        """Look at the document, as often as one likes; changes become steps once the hand rests.

        Args:
            document: as it is now.
            resting: no control is being dragged and nothing that was asked for is still awaited.
            now_s: a clock that never goes back.
            turning: the light turns by itself, which is a step only once it ends.
        """
        if turning and self.at >= 0:
            yaw_deg = self.steps[self.at].document.edit.yaw_deg
            document = replace(document, edit=replace(document.edit, yaw_deg=yaw_deg))
        held, self._present = self._present, document
        if held is not None and self._is_held(held) and document.photo != held.photo:
            # A key opened another photo while the hand still held a slider: what it did to this one is a step, too.
            self._rest(held, now_s)
        if resting:
            self._rest(document, now_s)

    def _rest(self, document: Document, now_s: float) -> None:
        if self.at < 0 or (self.at == 0 and self.steps[0].document.photo is None):
            opened = f"Open {legible(document.photo.path.name)}" if document.photo else "Start"
            self.steps, self.at = [Step(opened, document)], 0
            return
        change = change_between(self.steps[self.at].document, document)
        if change is not None:
            self._add(change, document, now_s)

    def undo(self) -> Document | None:
        """Go one step back; the document to show, or None where there is none.

        What is no step yet, as a photo that is still being read, is what is taken back first.
        """
        if self.is_ahead:
            return self.go(self.at)
        return self.go(self.at - 1) if self.can_undo else None

    def redo(self) -> Document | None:
        """Go one step forward again; the document to show, or None."""
        return self.go(self.at + 1) if self.can_redo else None

    def go(self, index: int) -> Document:
        """Go to any step of the list.

        Raises:
            IndexError: there is no such step.
        """
        if not 0 <= index < len(self.steps):
            raise IndexError(f"no step {index} of {len(self.steps)}")
        self.left, self.at = self.at, index
        self._present = self.steps[index].document
        return self._present

    def refit(self, fit: Callable[[Document], Document]) -> None:
        """Change every document alike, as where the photo in a file has come to have another size: that is no step."""
        self.steps = [replace(step, document=fit(step.document)) for step in self.steps]
        self._present = self._present and fit(self._present)

    @property
    def has_turned(self) -> bool:
        """Whether the newest undo, redo or jump led to another rotation of the light."""
        left, now = (self.steps[index].document.edit.yaw_deg for index in (self.left, self.at))
        return left != now

    @property
    def is_ahead(self) -> bool:
        """Whether there is a change that is no step yet, as a photo that is still being read."""
        if self.at < 0 or self._present is None:
            return False
        document = self.steps[self.at].document
        return document.photo is not None and document != self._present

    def _is_held(self, document: Document) -> bool:
        """Whether a document follows the step in force with nothing awaited: the same photo, under the same light."""
        if self.at < 0 or document.photo is None:
            return False
        step = self.steps[self.at].document
        return (document.photo, document.light) == (step.photo, step.light)

    def _add(self, change: Change, document: Document, now_s: float) -> None:
        del self.steps[self.at + 1 :]
        last = self.steps[self.at]
        same = last.touched == change.touched and not change.alone
        if self.at > 0 and same and now_s - last.last_s <= TOGETHER_S:
            whole = change_between(self.steps[self.at - 1].document, document)
            del self.steps[self.at]
            self.at -= 1
            if whole is None:
                return
            change = Change(change.touched, whole.name)
        self.steps.append(Step(change.name, document, change.touched, now_s))
        del self.steps[: max(0, len(self.steps) - MOST_STEPS)]
        self.at = len(self.steps) - 1
