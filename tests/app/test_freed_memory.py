"""Freed memory goes back to the system."""

import sys
from pathlib import Path

import numpy as np
import pytest

from app.engine.freed_memory import give_back_freed_memory


def resident_mib():
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith("VmRSS"))


@pytest.mark.skipif(sys.platform != "linux", reason="other systems' C libraries give memory back themselves")
def test_what_was_freed_below_what_is_in_use_is_given_back():
    blocks = [np.ones(12_000) for _ in range(3000)]
    kept = blocks[::100]
    del blocks
    before = resident_mib()
    give_back_freed_memory()
    assert resident_mib() < before - 150
    assert all(block[0] == 1 for block in kept)
