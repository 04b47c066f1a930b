"""Processes that make samples do not outlive the training they make them for."""

import contextlib
import os
import select
import signal
import subprocess
import sys

import pytest

TRAINING = """
import multiprocessing
from threading import Event

from relight_core.training.loader_worker import begin_worker


def work(pid):
    begin_worker()
    pid.send(multiprocessing.current_process().pid)
    Event().wait()


if __name__ == "__main__":
    context = multiprocessing.get_context("forkserver")
    here, there = context.Pipe()
    worker = context.Process(target=work, args=(there,), daemon=True)
    worker.start()
    print(here.recv(), flush=True)
    worker.join()
"""


@pytest.mark.skipif(not hasattr(os, "pidfd_open"), reason="asks Linux when a process has ended")
def test_a_worker_ends_when_its_training_is_killed(tmp_path):
    script = tmp_path / "training.py"
    script.write_text(TRAINING)
    training = subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True)
    worker = int(training.stdout.readline())
    ended = os.pidfd_open(worker)
    assert not select.select([ended], [], [], 0)[0]
    try:
        training.send_signal(signal.SIGKILL)
        training.wait()
        assert select.select([ended], [], [], 60)[0], "the worker lives on"
    finally:
        with contextlib.suppress(ProcessLookupError):
            signal.pidfd_send_signal(ended, signal.SIGKILL)
        os.close(ended)
