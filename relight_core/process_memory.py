"""How much memory this process takes, as far as the system tells."""

from __future__ import annotations

import platform
from pathlib import Path

_STATUS = Path("/proc/self/status")


def memory_in_use_mib() -> float | None:
    """Resident now; the largest so far where the system tells no other, None where it tells neither."""
    return _of_status("VmRSS")


def peak_memory_mib() -> float | None:
    """The largest so far; on Linux since it was last reset. None where the system does not tell."""
    return _of_status("VmHWM")


def _of_status(name: str) -> float | None:
    try:
        line = next(line for line in _STATUS.read_text().splitlines() if line.startswith(name))
        return float(line.split()[1]) / 2**10
    except (OSError, StopIteration):
        return _peak_of_process()


def _peak_of_process() -> float | None:
    try:
        import resource
    except ImportError:
        # Windows has none.
        return None
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (2**20 if platform.system() == "Darwin" else 2**10)
