"""Long work that nobody waits for any more: whoever began it says so, and it stops where it next asks.

The question is laid around the work instead of being handed through it: what asks lies far beneath what was called,
and finds the same whoever called it. It belongs to the thread that laid it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_is_unwanted: ContextVar[Callable[[], bool]] = ContextVar("is_unwanted", default=lambda: False)


class UnwantedError(Exception):
    """The work was stopped: its result is no longer wanted, and nothing of it is kept."""


@contextmanager
def stopping_when(is_unwanted: Callable[[], bool]) -> Iterator[None]:
    """Let `stop_if_unwanted` ask this, in what is called within.

    Args:
        is_unwanted: quick, for it is asked often; may be asked on the threads that copy this one's context.
    """
    token = _is_unwanted.set(is_unwanted)
    try:
        yield
    finally:
        _is_unwanted.reset(token)


def stop_if_unwanted() -> None:
    """For long work, between its parts.

    Raises:
        UnwantedError: nobody waits for it any more.
    """
    if _is_unwanted.get()():
        raise UnwantedError
