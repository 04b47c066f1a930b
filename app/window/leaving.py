"""Closing the window while files are still being made, or with unsaved work that can't be kept."""

from __future__ import annotations

from collections.abc import Callable

from app.ui.asking import Asking, Question

_FILES, _WORK = "files being made", "work that is lost"


class Leaving:
    """Decides whether the window may close.

    Args:
        asking: where the user is asked.
        is_busy: whether files that the user asked for are still being made.
        failures: how many of the files asked for so far could not be made.
        would_lose_work: whether there is unsaved work that can't be kept for the next start.

    The user may finish the files first, after which the window closes by itself, unless one of them failed.
    """

    def __init__(
        self,
        asking: Asking,
        is_busy: Callable[[], bool],
        failures: Callable[[], int],
        would_lose_work: Callable[[], bool] = lambda: False,
    ) -> None:
        self._asking, self._is_busy, self._failures = asking, is_busy, failures
        self._would_lose_work = would_lose_work
        self._stops = self._gives_up = False
        self._failures_before: int | None = None

    def allows(self, wanted: bool) -> bool:
        """Whether the window may close now; asks where something would be lost by it.

        Args:
            wanted: the user has asked for it just now.
        """
        if self._gives_up:
            return True
        if not self._stops and self._is_busy():
            if wanted:
                self._ask()
            return False
        self._asking.drop(_FILES)
        # After "Finish first" the window closes by itself, unless a file failed: its message has to be read first.
        may = self._stops or wanted or self._failures() == self._failures_before
        self._failures_before = None
        if may and self._would_lose_work():
            self._stops = False
            self._ask_about_work()
            return False
        return may

    def _ask(self) -> None:
        self._failures_before = None
        choices = (("Finish first", self._finish), ("Stop it", self._stop), ("Stay open", lambda: None))
        text = "Files you asked for are still being made."
        self._asking.ask(Question(_FILES, text, choices, calling_off="Stay open"))

    def _finish(self) -> None:
        self._failures_before = self._failures()
        # In sight until then: whoever goes on working meanwhile would lose sight of the window without a word.
        text = "This window closes once the files you asked for are made."
        self._asking.ask(Question(_FILES, text, (("Stay open", self._stay),), calling_off="Stay open"))

    def _stay(self) -> None:
        self._failures_before = None

    def _stop(self) -> None:
        self._stops = True

    def _ask_about_work(self) -> None:
        text = "There is unsaved work, and it can't be kept for the next start. Save the session, or it is lost."
        choices = (("Stay open", lambda: None), ("Close anyway", self._give_up))
        self._asking.ask(Question(_WORK, text, choices, calling_off="Stay open"))

    def _give_up(self) -> None:
        self._gives_up = True
