"""Memory is told in MiB on every system, or not at all."""

import sys
from types import SimpleNamespace

import pytest

from relight_core import process_memory


@pytest.fixture
def without_proc(tmp_path, monkeypatch):
    monkeypatch.setattr(process_memory, "_STATUS", tmp_path / "none")


@pytest.mark.parametrize(("system", "unit"), [("Darwin", 2**20), ("FreeBSD", 2**10)])
def test_a_peak_is_in_bytes_on_macos_and_in_kilobytes_elsewhere(without_proc, monkeypatch, system, unit):
    usage = SimpleNamespace(ru_maxrss=300 * unit)
    resource = SimpleNamespace(RUSAGE_SELF=0, getrusage=lambda _who: usage)
    monkeypatch.setitem(sys.modules, "resource", resource)
    monkeypatch.setattr(process_memory.platform, "system", lambda: system)
    assert process_memory.memory_in_use_mib() == process_memory.peak_memory_mib() == 300


def test_windows_tells_none(without_proc, monkeypatch):
    monkeypatch.setitem(sys.modules, "resource", None)
    assert process_memory.memory_in_use_mib() is None
    assert process_memory.peak_memory_mib() is None
