"""The engine's thread steps back behind the window's, and leaves it a core."""

import os
import sys
import threading

import pytest

from app.engine import pace


@pytest.fixture
def switch_interval_kept():
    before = sys.getswitchinterval()
    sys.setswitchinterval(0.005)
    yield 0.005
    sys.setswitchinterval(before)


@pytest.mark.skipif(sys.platform != "linux", reason="threads have a priority each on Linux only")
def test_only_the_calling_thread_steps_back(switch_interval_kept):
    before = os.getpriority(os.PRIO_PROCESS, threading.get_native_id())
    found = []

    def work():
        pace.yield_to_the_window()
        found.append(os.getpriority(os.PRIO_PROCESS, threading.get_native_id()))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert found[0] > before or before == 19
    assert os.getpriority(os.PRIO_PROCESS, threading.get_native_id()) == before
    assert sys.getswitchinterval() < switch_interval_kept


def test_a_priority_that_cannot_be_had_is_survived(switch_interval_kept, monkeypatch):
    def refuse(*_):
        raise PermissionError

    monkeypatch.setattr(os, "setpriority", refuse, raising=False)
    pace.yield_to_the_window()
    assert sys.getswitchinterval() < switch_interval_kept


@pytest.mark.parametrize(("cores", "threads"), [(1, 1), (2, 1), (8, 7)])
def test_the_networks_leave_a_core(monkeypatch, cores, threads):
    import torch

    chosen = []
    monkeypatch.setattr(pace, "available_cores", lambda: cores)
    monkeypatch.setattr(torch, "set_num_threads", chosen.append)
    pace.leave_a_core()
    assert chosen == [threads]
