"""Long work beside the window: one job at a time, with how far it is, how long it takes, and Cancel."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

from app.faults import error_line
from relight_core.errors import InputError
from relight_core.unwanted import UnwantedError, stopping_when

_log = logging.getLogger(__name__)


class Cancelled(Exception):
    """The user thought better of it."""


@dataclass(frozen=True)
class JobStatus:
    """How far a job is.

    Attributes:
        name: for people: "Turntable".
        done, total: steps; total is 0 before it is known.
        left_s: estimate of what is left, or None.
        cancelling: the user has cancelled it, and it will stop at its next step.
        waiting: how many jobs come after it.
        number: which job it is, of all since the start.
    """

    name: str
    done: int = 0
    total: int = 0
    left_s: float | None = None
    cancelling: bool = False
    waiting: int = 0
    number: int = 0

    @property
    def share(self) -> float:
        """Of the whole, [0, 1]."""
        return self.done / self.total if self.total else 0.0


class JobControl:
    """What a job's work uses to say how far it is."""

    def __init__(self, jobs: Jobs, name: str) -> None:
        self._jobs, self._name = jobs, name
        self._began_s = time.monotonic()

    def step(self, done: int, total: int, unneeded: int = 0) -> None:
        """So many steps are done.

        Args:
            unneeded: how many of them there was nothing to do for, and which say nothing of how long others take.

        Raises:
            Cancelled: the user has cancelled the job.
        """
        if self._jobs.is_cancelled():
            raise Cancelled
        elapsed_s = time.monotonic() - self._began_s
        left_s = elapsed_s / (done - unneeded) * (total - done) if done > unneeded else None
        self._jobs.publish(JobStatus(self._name, done, total, left_s))


class Jobs:
    """Runs jobs one after the other.

    Args:
        say: told what became of each: a line, and whether it is an error.
        wake: called when the status has changed.
        on_start: called first on the thread the jobs run on; they run even if it fails.

    Attributes:
        failures: how many jobs came to nothing, those that were cancelled aside.
    """

    def __init__(
        self,
        say: Callable[[str, bool], None],
        wake: Callable[[], None] = lambda: None,
        on_start: Callable[[], None] = lambda: None,
    ) -> None:
        self._say, self._wake = say, wake
        self._on_start = on_start
        self._pool = ThreadPoolExecutor(max_workers=1, thread_name_prefix="relight-job", initializer=self._begin)
        self._lock = threading.Lock()
        self._status: JobStatus | None = None
        self._waiting = self._untold = self._number = 0
        self.failures = 0
        self._cancel = threading.Event()
        self._begins_no_more = False

    def start(self, name: str, work: Callable[[JobControl], str]) -> None:
        """Queue a job; `work` returns the line to say when it is done."""
        with self._lock:
            self._pool.submit(self._run, name, work)
            self._waiting += 1
            self._untold += 1

    def is_busy(self) -> bool:
        """Whether there is a job of which it has not been told yet what became of it."""
        with self._lock:
            return self._untold > 0

    def status(self) -> JobStatus | None:
        """The job that runs, or None."""
        with self._lock:
            return self._status and replace(self._status, waiting=self._waiting)

    def cancel(self, job: JobStatus) -> None:
        """Stop this job at its next step or amid its search for faces, but no other that runs since it has ended."""
        with self._lock:
            if self._status is None or self._status.number != job.number:
                return
            self._cancel.set()
            self._status = _stopping(self._status)
        self._wake()

    def close(self, cancel: bool = False) -> None:
        """Finish what was queued, or only what can't be stopped; safe to call twice."""
        if cancel:
            # A job that has been taken up just now has no status yet that could be cancelled.
            self._begins_no_more = True
            if (running := self.status()) is not None:
                self.cancel(running)
        self._pool.shutdown(wait=True, cancel_futures=cancel)

    def is_cancelled(self) -> bool:
        """Whether the job that runs is to stop."""
        return self._cancel.is_set()

    def publish(self, status: JobStatus | None) -> None:
        """For the job that runs: how far it is."""
        with self._lock:
            if status is not None:
                status = replace(status, number=self._number)
            # A step may have looked just before the cancel; the job still stops at its next one.
            self._status = _stopping(status) if status is not None and self.is_cancelled() else status
        self._wake()

    def _begin(self) -> None:
        """What fails here would leave the pool broken, and every job waiting for ever."""
        try:
            self._on_start()
        except Exception as error:
            _log.error("the jobs' thread could not be set up", exc_info=error)
            self._say(error_line(error), True)

    def _run(self, name: str, work: Callable[[JobControl], str]) -> None:
        self._cancel.clear()
        with self._lock:
            self._waiting -= 1
            self._number += 1
        self.publish(JobStatus(name))
        try:
            if self._begins_no_more:
                raise Cancelled
            # A search for faces lies between two steps, and may take half a minute.
            with stopping_when(self.is_cancelled):
                line, is_error = work(JobControl(self, name)), False
        except (Cancelled, UnwantedError):
            line, is_error = f"{name}: cancelled", False
        except InputError as error:
            line, is_error = error_line(error), True
        except Exception as error:
            _log.error("%s failed", name, exc_info=error)
            line, is_error = error_line(error), True
        self.publish(None)
        self._say(line, is_error)
        with self._lock:
            self.failures += is_error
            self._untold -= 1
        self._wake()


def _stopping(status: JobStatus) -> JobStatus:
    return replace(status, left_s=None, cancelling=True)
