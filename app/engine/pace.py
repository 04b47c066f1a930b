"""How the engine shares the processor with the window, which has to draw while the networks run."""

from __future__ import annotations

import logging
import os
import sys
import threading

_SWITCH_S = 0.0005
"""How long the engine's Python may keep the window's waiting."""

_NICENESS = 5
_log = logging.getLogger(__name__)


def yield_to_the_window() -> None:
    """Let the window's thread go first wherever both want to run; called on the engine's thread, once.

    On Linux threads have a priority each, and those that the networks start inherit this one's. Elsewhere only
    Python's own turns get shorter.
    """
    sys.setswitchinterval(_SWITCH_S)
    if sys.platform != "linux":
        return
    thread = threading.get_native_id()
    try:
        os.setpriority(os.PRIO_PROCESS, thread, os.getpriority(os.PRIO_PROCESS, thread) + _NICENESS)
    except OSError as error:
        _log.info("the engine keeps the window's priority: %s", error)


def leave_a_core() -> None:
    """Let the networks use all cores but one; called on the thread that runs them, for the choice is a thread's own.

    The window draws on that one, and NumPy and OpenCV have threads of their own: where these wait for a core that
    PyTorch's idle threads still hold, an update takes longer with all cores than with one fewer.
    """
    import torch

    torch.set_num_threads(max(1, available_cores() - 1))


def available_cores() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
