"""What is done with a finished picture waits for it: an export, say, asked for while the networks still run."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace

from app.engine.snapshot import Picture, Snapshot
from app.engine.sources import Request
from app.faults import error_line
from app.ui.state import EditorState
from relight_core.errors import InputError

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class _Task:
    """What waits for a picture.

    Attributes:
        request: asks for the picture.
        run: is called with it.
        makes_file, otherwise: as of `Finished.then`.
    """

    request: Request
    run: Callable[[Picture], None]
    makes_file: bool
    otherwise: Callable[[], None]


class Finished:
    """Hands each task the picture that was wanted when the task was given, as it is at rest.

    Until that picture is there the engine is asked for it and for nothing newer, so that another photo which is
    opened meanwhile doesn't end up in the file.

    Args:
        state: says what is wanted.
        say: tells a line, and whether it is an error.

    Attributes:
        failures: how many tasks came to nothing.
    """

    def __init__(self, state: EditorState, say: Callable[[str, bool], None]) -> None:
        self._state, self._say = state, say
        self._tasks: deque[_Task] = deque()
        self.failures = 0

    def then(
        self, run: Callable[[Picture], None], makes_file: bool = True, otherwise: Callable[[], None] = lambda: None
    ) -> None:
        """Call what is given with the finished picture, as soon as it is there.

        Args:
            makes_file: something is lost if that never happens.
            otherwise: called where it turns out that it never will.
        """
        self._tasks.append(_Task(self._state.request_at_rest(), run, makes_file, otherwise))

    @property
    def is_making_files(self) -> bool:
        """Whether there is a file whose picture is not there yet."""
        return any(task.makes_file for task in self._tasks)

    def wanted(self, newest: Request) -> Request:
        """What to ask the engine for: what the oldest task waits for, else the newest wish."""
        return self._tasks[0].request if self._tasks else newest

    def hand_out(self, snapshot: Snapshot, is_idle: bool) -> None:
        """Call the tasks whose picture is there.

        Args:
            is_idle: the engine has done all it can for what it was asked for last.
        """
        while self._tasks and _answers(snapshot.picture, self._tasks[0].request):
            self._attempt(self._tasks.popleft().run, snapshot.picture)
            is_idle = False
        if self._tasks and is_idle:
            task = self._tasks.popleft()
            task.otherwise()
            lost = "Nothing was saved" if task.makes_file else "Nothing was changed"
            self._fail(f"{lost}: {_why_not(task.request, snapshot)}")

    def _attempt(self, run: Callable[[Picture], None], picture: Picture) -> None:
        """Whatever goes wrong in a task is told; the window goes on."""
        try:
            run(picture)
        except Exception as error:
            if not isinstance(error, InputError):
                _log.error("what waited for a picture failed", exc_info=error)
            self._fail(error_line(error))

    def _fail(self, line: str) -> None:
        self.failures += 1
        self._say(line, True)


def _why_not(request: Request, snapshot: Snapshot) -> str:
    """Why a picture will never be there; on a second line what was told of a light or photo that can't be had."""
    if request.photo in snapshot.refused:
        why = f"{request.photo.name} can't be opened"
    elif request.light in snapshot.refused:
        why = f"the light {request.light.title} can't be had"
    else:
        return "this picture can't be relit"
    told = snapshot.message
    return f"{why}\n{told.text}" if told is not None and told.is_error else why


def _answers(picture: Picture | None, request: Request) -> bool:
    if (
        picture is None
        or picture.is_stale
        or (request.photo is not None and picture.opened.source is not request.photo)
    ):
        return False
    light = picture.light
    is_light = light.source is request.light and light.edit == request.light_edit and not light.is_draft
    return is_light and picture.edit == replace(request.edit, exposure_ev=0.0)
