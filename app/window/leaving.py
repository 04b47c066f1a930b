"""Closing the window while files are still being made."""

from __future__ import annotations

from collections.abc import Callable

from app.engine.snapshot import Message
from app.ui.asking import Asking, Question

_KEY = "leave"


class Leaving:
    """Decides whether the window may close.

    Args:
        asking: where the user is asked.
        is_busy: whether files that the user asked for are still being made.
        newest: the newest line told to the user.
    """

    def __init__(self, asking: Asking, is_busy: Callable[[], bool], newest: Callable[[], Message | None]) -> None:
        self._asking, self._is_busy, self._newest = asking, is_busy, newest
        self._stops = False
        self._finishes_after: int | None = None

    def allows(self, wanted: bool) -> bool:
        """Whether the window may close now; asks where something would be lost by it.

        Args:
            wanted: the user has asked for it just now.
        """
        if self._stops:
            return True
        if self._is_busy():
            if wanted:
                self._ask()
            return False
        may = wanted or (self._finishes_after is not None and not self._has_failed())
        self._finishes_after = None
        return may

    def _ask(self) -> None:
        self._finishes_after = None
        choices = (("Finish first", self._finish), ("Stop it", self._stop), ("Stay open", lambda: None))
        self._asking.ask(Question(_KEY, "Files you asked for are still being made.", choices))

    def _finish(self) -> None:
        self._finishes_after = self._number()

    def _stop(self) -> None:
        self._stops = True

    def _has_failed(self) -> bool:
        """Whether what was to be finished was not, which has to be read before the window is gone."""
        message = self._newest()
        return message is not None and message.is_error and message.number > self._finishes_after

    def _number(self) -> int:
        message = self._newest()
        return message.number if message else 0
