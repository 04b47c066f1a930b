"""Signals that tell the program to end: heard while the window system waits, and after the command has cleaned up."""

import signal
import subprocess
import sys
import threading

import pytest
from fake_relighter import LONG_S

from app.window.interrupts import Interrupts


def test_a_signal_ends_the_waiting_and_is_raised_where_it_is_heeded():
    woken, before = threading.Event(), signal.getsignal(signal.SIGINT)
    with Interrupts(woken.set) as interrupts:
        interrupts.heed()
        signal.raise_signal(signal.SIGINT)
        assert woken.wait(LONG_S)
        with pytest.raises(KeyboardInterrupt):
            interrupts.heed()
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
@pytest.mark.parametrize("is_ignored", [False, True], ids=["heard", "ignored"])
def test_every_way_to_end_a_command_is_an_interrupt_unless_it_is_ignored(name, is_ignored):
    number = getattr(signal, name, None) or pytest.skip("no such signal here")
    script = f"""if True:
        import signal, sys, types

        def command(interrupted):
            signal.raise_signal({int(number)})
            return 7

        signal.signal({int(number)}, signal.{"SIG_IGN" if is_ignored else "SIG_DFL"})
        sys.modules["app.cli.main"] = types.SimpleNamespace(main=command)
        from app.__main__ import main

        sys.exit(main())
    """
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (7 if is_ignored else 130, "")
