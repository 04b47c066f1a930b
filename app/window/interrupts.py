"""Ctrl + C in the terminal, and other wishes that the program end, while the window system waits for events."""

from __future__ import annotations

import signal
import socket
import threading
from collections.abc import Callable

from app.endings import ENDINGS, raises_interrupts


class Interrupts:
    """In a `with` block signals to end are noted, and raised where `heed` is called.

    The window system waits in C, where Python looks after no signal; and what a signal's handler raises in one of the
    callbacks from there is lost.

    Args:
        wake: ends the waiting; called on a thread of its own.
    """

    def __init__(self, wake: Callable[[], None]) -> None:
        self._wake, self._came = wake, False

    def __enter__(self) -> Interrupts:
        self._near, self._far = socket.socketpair()
        self._far.setblocking(False)
        # Python's own C code writes there, whatever the main thread is at.
        self._wakes_before = signal.set_wakeup_fd(self._far.fileno(), warn_on_full_buffer=False)
        raising = [number for number in ENDINGS if raises_interrupts(number)]
        self._before = {number: signal.signal(number, self._note) for number in raising}
        self._listener = threading.Thread(target=self._listen, name="relight-interrupts", daemon=True)
        self._listener.start()
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(self._wakes_before)
        self._far.close()
        self._listener.join()
        self._near.close()

    def heed(self) -> None:
        """Raise KeyboardInterrupt if the program is to end."""
        if self._came:
            raise KeyboardInterrupt

    def _note(self, *_: object) -> None:
        self._came = True

    def _listen(self) -> None:
        while self._near.recv(1):
            self._wake()
