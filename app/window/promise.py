"""A picture that is asked for before its file's place is known."""

from __future__ import annotations

from collections.abc import Callable

from app.engine.snapshot import Picture
from relight_core.errors import InputError


class Promise:
    """Runs a task on a picture once both are there, whichever comes first."""

    def __init__(self) -> None:
        self._picture: Picture | None = None
        self._task: Callable[[Picture], None] | None = None
        self._is_broken = False

    def keep(self, picture: Picture) -> None:
        """The picture is there."""
        self._picture = picture
        if self._task is not None:
            self._task(picture)

    def give_up(self) -> None:
        """There will never be one."""
        self._is_broken = True

    def then(self, task: Callable[[Picture], None]) -> None:
        """Call the task with the picture, at once if it is there.

        Raises:
            InputError: there will never be one.
        """
        if self._is_broken:
            raise InputError("Nothing was saved: the picture that was asked for can't be relit")
        self._task = task
        if self._picture is not None:
            task(self._picture)
