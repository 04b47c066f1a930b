"""Threads that have nothing to do, and would wait for work at full speed, stay out of the way of those that have."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from app.engine.pace import available_cores

THREADS_OF_A_COMMAND = """
import os, sys
from app.cli.main import main

assert main(["rigs"]) == 0
import numpy
square = numpy.ones((1024, 1024), numpy.float32)
square @ square
print(len(os.listdir("/proc/self/task")), file=sys.stderr)
"""


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="counts threads where Linux lists them")
@pytest.mark.parametrize(("asked", "threads"), [(None, 1), ("2", min(2, available_cores()))])
def test_numpy_has_one_thread_unless_more_are_asked_for(asked, threads):
    environment = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    environment |= {} if asked is None else {"OPENBLAS_NUM_THREADS": asked}
    done = subprocess.run(
        [sys.executable, "-c", THREADS_OF_A_COMMAND], env=environment, capture_output=True, text=True, check=True
    )
    assert int(done.stderr) == threads


# Every one is refused before it trains anything, and after it has said how threads are to wait.
TRAININGS = [
    ("train", "--stage", "no-such-stage", "--minutes", "1", "-o", "weights.safetensors"),
    ("evaluate", "ablation", "-o", "weights.safetensors"),
    ("dataset", "effect", "--bare", ".", "--photos", ".", "-o", "sheet.pdf"),
    ("dataset", "speed"),
]


@pytest.mark.parametrize("words", TRAININGS, ids=lambda words: " ".join(words[:2]))
@pytest.mark.parametrize(("asked", "policy"), [(None, "PASSIVE"), ("ACTIVE", "ACTIVE")])
def test_what_trains_lets_idle_threads_sleep_unless_told_otherwise(
    relight, tmp_path, monkeypatch, words, asked, policy
):
    # Set first in either case, so that what the command sets is taken back after the test.
    monkeypatch.setenv("OMP_WAIT_POLICY", asked or "")
    if asked is None:
        monkeypatch.delenv("OMP_WAIT_POLICY")
    data = "--shards" if words[0] == "dataset" else "--heads"
    assert relight(*words, data, tmp_path, "--lights", tmp_path).code == 2
    assert os.environ["OMP_WAIT_POLICY"] == policy
