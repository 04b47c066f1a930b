"""Tasks that wait for a finished picture, such as an export that is asked for while the networks still run."""

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
    """A task that waits for a picture.

    Attributes:
        request: the engine's request that gives the picture.
        run: called with the picture.
        makes_file, otherwise: see `Finished.then`.
    """

    request: Request
    run: Callable[[Picture], None]
    makes_file: bool
    otherwise: Callable[[], None]


class Finished:
    """Runs each task with the finished picture, at rest quality, of what was wanted when the task was given.

    Until that picture is there the engine is asked for it and for nothing newer, so that a photo that is opened
    meanwhile doesn't end up in the file.

    Args:
        state: what is wanted.
        say: shows a message, and whether it is an error.

    Attributes:
        failures: number of tasks that failed.
    """

    def __init__(self, state: EditorState, say: Callable[[str, bool], None]) -> None:
        self._state, self._say = state, say
        self._tasks: deque[_Task] = deque()
        self.failures = 0

    def then(
        self, run: Callable[[Picture], None], makes_file: bool = True, otherwise: Callable[[], None] = lambda: None
    ) -> None:
        """Call `run` with the finished picture as soon as it is there.

        Args:
            makes_file: the task makes a file, so the window asks before it closes without having run it.
            otherwise: called instead if there will never be such a picture.
        """
        self._tasks.append(_Task(self._state.request_at_rest(), run, makes_file, otherwise))

    @property
    def is_making_files(self) -> bool:
        """Whether there is a file whose picture is not there yet."""
        return any(task.makes_file for task in self._tasks)

    def wanted(self, newest: Request) -> Request:
        """The request to submit to the engine: that of the oldest waiting task, else the newest."""
        return self._tasks[0].request if self._tasks else newest

    def hand_out(self, snapshot: Snapshot, is_idle: bool) -> None:
        """Run the tasks whose picture is there, and fail the oldest one if its picture can't come any more.

        Args:
            is_idle: the engine has nothing left to do for the request that it got last.
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
        """Run a task; an exception becomes a message, and the window goes on."""
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
    """Why there will be no picture; on a second line the engine's message on the refused photo or light."""
    if request.photo in snapshot.refused:
        why = f"{request.photo.name} can't be opened"
    elif request.light in snapshot.refused:
        why = f"the light {request.light.title} can't be had"
    else:
        return "this picture can't be relit"
    told = snapshot.message
    return f"{why}\n{told.text}" if told is not None and told.is_error else why


def _answers(picture: Picture | None, request: Request) -> bool:
    """Whether a picture is the finished one of a request."""
    if (
        picture is None
        or picture.is_stale
        or (request.photo is not None and picture.opened.source is not request.photo)
    ):
        return False
    light = picture.light
    is_light = light.source is request.light and light.edit == request.light_edit and not light.is_draft
    return is_light and picture.edit == replace(request.edit, exposure_ev=0.0)
