"""Closing the window while files are still being made."""

from __future__ import annotations

from collections.abc import Callable

from app.ui.asking import Asking, Question

_KEY = "leave"


class Leaving:
    """Decides whether the window may close.

    Args:
        asking: where the user is asked.
        is_busy: whether files that the user asked for are still being made.
        failures: how many of the files asked for so far could not be made.
    """

    def __init__(self, asking: Asking, is_busy: Callable[[], bool], failures: Callable[[], int]) -> None:
        self._asking, self._is_busy, self._failures = asking, is_busy, failures
        self._stops = False
        self._failures_before: int | None = None

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
        # What was to be finished and was not has to be read before the window is gone.
        may = wanted or self._failures() == self._failures_before
        self._failures_before = None
        return may

    def _ask(self) -> None:
        self._failures_before = None
        choices = (("Finish first", self._finish), ("Stop it", self._stop), ("Stay open", lambda: None))
        self._asking.ask(Question(_KEY, "Files you asked for are still being made.", choices))

    def _finish(self) -> None:
        self._failures_before = self._failures()

    def _stop(self) -> None:
        self._stops = True
