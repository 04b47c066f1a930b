"""Settings for every test, and networks that are the same every time."""

import os
import signal

import pytest
from hypothesis import settings

if "PYTEST_XDIST_WORKER" in os.environ:
    # As many processes as cores each compute on one; read when PyTorch is imported, after this.
    os.environ.setdefault("OMP_NUM_THREADS", "1")

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # A shell's background job ignores it, and tests that raise it would wait for nothing.
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Machines differ in speed, and a first call may load a library: no test fails for being slow.
settings.register_profile("relight", deadline=None, max_examples=50)
settings.load_profile("relight")


@pytest.fixture
def seeded():
    """What PyTorch draws is the same in every run."""
    import torch

    torch.manual_seed(0)


@pytest.fixture(scope="module")
def weights(tmp_path_factory):
    """A file of tiny networks."""
    from tiny_networks import write_tiny_weights

    return write_tiny_weights(tmp_path_factory.mktemp("weights"))
