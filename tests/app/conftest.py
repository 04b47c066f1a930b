"""A display for the window's tests: an Xvfb of their own, or the machine's where there is no Xvfb."""

import os
import shutil
import subprocess

import pytest


@pytest.fixture(scope="session")
def display():
    """Name of an X display on which windows may be opened."""
    program = shutil.which("Xvfb")
    if program is None:
        if os.environ.get("DISPLAY"):
            yield os.environ["DISPLAY"]
            return
        pytest.skip("no Xvfb and no display to open a window on")
    read_end, write_end = os.pipe()
    command = [program, "-displayfd", str(write_end), "-screen", "0", "1600x1000x24", "-nolisten", "tcp", "-noreset"]
    server = subprocess.Popen(
        command, pass_fds=[write_end], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    os.close(write_end)
    with os.fdopen(read_end) as answer:
        number = answer.readline().strip()
    if not number:
        server.wait()
        pytest.fail("Xvfb did not start")
    changes = {"DISPLAY": f":{number}", "LIBGL_ALWAYS_SOFTWARE": "1", "WAYLAND_DISPLAY": ""}
    before = {name: os.environ.get(name) for name in changes}
    os.environ.update(changes)
    yield f":{number}"
    for name, value in before.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value
    server.terminate()
    server.wait()
