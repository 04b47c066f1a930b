"""The engine thread: takes the newest request, works in steps, publishes snapshots."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from app.engine.desk import Desk, Step
from app.engine.snapshot import Message, Snapshot
from app.engine.sources import RelighterLike, Request
from app.faults import error_line
from relight_core.errors import InputError
from relight_core.imaging.files import legible
from relight_core.unwanted import UnwantedError, stopping_when

_log = logging.getLogger(__name__)


class Engine:
    """Runs a Relighter on its own thread.

    `submit` and `snapshot` may be called from any thread and never wait for the networks. While a slider is
    dragged every finished result is published, even if a newer one has been asked for by then; a result for a
    photo that has meanwhile been replaced is dropped, and the search for the faces of such a photo stops.

    Args:
        make_relighter: called on the engine's thread when the networks are first needed; again if that fails.
        wake: called, on the engine's thread, after every change of the snapshot.
        on_start: called first on the engine's thread.
        calibration_path: where the costs of the quality tiers are kept; None neither measures nor keeps them.
    """

    def __init__(
        self,
        make_relighter: Callable[[], RelighterLike],
        wake: Callable[[], None] = lambda: None,
        on_start: Callable[[], None] = lambda: None,
        calibration_path: Path | None = None,
    ) -> None:
        self._desk = Desk(make_relighter, calibration_path)
        self._wake = wake
        self._on_start = on_start
        self._changed = threading.Condition()
        self._request = Request()
        self._snapshot = Snapshot()
        self._idle = True
        self._closing = False
        self._messages = 0
        self._thread = threading.Thread(target=self._run, name="relight-engine", daemon=True)
        self._thread.start()

    def submit(self, request: Request) -> None:
        """Replace what is wanted; a request that was not begun is forgotten."""
        with self._changed:
            self._request = request
            self._idle = False
            self._changed.notify_all()

    def snapshot(self) -> Snapshot:
        """What is in force now."""
        with self._changed:
            return self._snapshot

    def say(self, text: str, is_error: bool = False) -> None:
        """Publish a line for the user, or several; for the other threads of the program."""
        text = "\n".join(legible(line) for line in text.split("\n"))
        with self._changed:
            self._messages += 1
            self._snapshot = self._snapshot.telling(Message(self._messages, text, is_error))
        self._wake()

    def wait_until_idle(self, timeout_s: float | None = None) -> bool:
        """Block until the newest request is answered or refused; False if it took longer."""
        with self._changed:
            return self._changed.wait_for(lambda: self._idle or self._closing, timeout_s)

    def close(self) -> None:
        """End the thread after the step that runs, which stops where it can; safe to call twice."""
        with self._changed:
            self._closing = True
            self._changed.notify_all()
        if self._thread is not threading.current_thread():
            self._thread.join()

    def _run(self) -> None:
        try:
            self._on_start()
        except Exception as error:
            self._confess(error)
        while True:
            with self._changed:
                self._changed.wait_for(lambda: not self._idle or self._closing)
                if self._closing:
                    return
                request, now = self._request, self._snapshot
            step = self._next_step(request, now)
            if step is None or not self._took(step):
                self._rest(request)

    def _next_step(self, request: Request, now: Snapshot) -> Step | None:
        try:
            return self._desk.next_step(request, now)
        except Exception as error:
            self._confess(error)
            return None

    def _rest(self, request: Request) -> None:
        with self._changed:
            if self._request is not request:
                return
            self._idle = True
            self._snapshot = replace(self._snapshot, activity=None)
            self._changed.notify_all()
        self._wake()

    def _took(self, step: Step) -> bool:
        """Take the step; where even giving it up fails, the thread lives on and rests until there is a new request."""
        try:
            self._take(step)
        except Exception as error:
            self._confess(error)
            return False
        return True

    def _take(self, step: Step) -> None:
        with self._changed:
            self._snapshot = before = replace(self._snapshot, activity=step.activity)
        self._wake()
        after = self._outcome(step, before)
        with self._changed:
            # With another portrait there comes no result: what was in sight goes, or stays until it is relit anew.
            is_result = after.picture is not before.picture and after.opened is before.opened
            if is_result and self._photo_was_replaced(after):
                after = replace(after, picture=before.picture)
            # What was said meanwhile.
            now = self._snapshot
            self._snapshot = replace(after, message=now.message, errors=now.errors)
        self._wake()

    def _outcome(self, step: Step, before: Snapshot) -> Snapshot:
        try:
            with stopping_when(partial(self._is_superseded, step)):
                return step.run(before)
        except UnwantedError:
            # Nothing failed: what is in force stays, and the newest request says what is next.
            return before
        except InputError as error:
            self.say(error_line(error), is_error=True)
        except Exception as error:
            self._confess(error)
        return step.give_up(before)

    def _is_superseded(self, step: Step) -> bool:
        with self._changed:
            return self._closing or step.is_superseded(self._request)

    def _photo_was_replaced(self, after: Snapshot) -> bool:
        wanted = self._request.photo
        if wanted is None or after.opened is None:
            return False
        return wanted is not after.opened.source and wanted not in after.refused

    def _confess(self, error: Exception) -> None:
        _log.error("the engine failed", exc_info=error)
        self.say(error_line(error), is_error=True)
