"""Threads that have nothing to do wait for work at full speed, where nobody asks them not to."""

from __future__ import annotations

import os


def keep_numpy_to_one_thread() -> None:
    """Leave the other cores to the networks, to the window, and to other makers of samples.

    Our products are over before OpenBLAS's other threads could help, and those then wait for the next product at full
    speed: for every turn of the light 48 ms of a core, which is more than all of the turn's own work. NumPy reads this
    when it is imported, in the processes that we start as well.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
