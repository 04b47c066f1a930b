"""What image libraries print of their own, kept off the terminal: our errors say more, and in one line."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
from collections.abc import Iterator

_STREAMS = threading.RLock()
"""Whoever redirects the process's streams: two at a time would put back what the other had put in their place."""

_STDERR = 2


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Keep both streams from whatever is printed meanwhile, also where the process has been given no stderr."""
    with _STREAMS, open(os.devnull, "w") as nowhere, contextlib.redirect_stdout(nowhere):
        kept = None
        with contextlib.suppress(OSError):
            kept = os.dup(_STDERR)
        with contextlib.suppress(OSError, AttributeError):
            sys.stderr.flush()
        try:
            os.dup2(nowhere.fileno(), _STDERR)
            yield
        finally:
            if kept is None:
                os.close(_STDERR)
            else:
                os.dup2(kept, _STDERR)
                os.close(kept)
