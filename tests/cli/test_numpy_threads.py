"""NumPy's own threads, which wait at full speed, stay out of the way of the networks and the window."""

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
