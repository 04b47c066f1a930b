"""Signals that tell the program to end: heard while the window system waits, and after the command has cleaned up."""

import _imp
import signal
import subprocess
import sys
import threading
import weakref
from importlib.machinery import ExtensionFileLoader

import pytest
from fake_relighter import LONG_S

from app.endings import ENDINGS, take_endings_for_interrupts
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


@pytest.fixture
def endings_taken():
    before = {number: signal.getsignal(number) for number in ENDINGS}
    take_endings_for_interrupts()
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture
def made_of_c(monkeypatch, endings_taken):
    """Makes a module by a function in place of C code, and waits for an interrupt."""

    def make(initialise):
        monkeypatch.setattr(_imp, "exec_dynamic", lambda module: initialise())
        ExtensionFileLoader("made", "made.so").exec_module(None)
        threading.Event().wait(LONG_S)

    return make


@pytest.mark.parametrize("number", ENDINGS)
def test_an_interrupt_while_c_code_makes_a_module_of_itself_comes_after_that(made_of_c, number):
    """That of PyTorch drops what is raised in it."""
    met = []

    def initialise():
        try:
            signal.raise_signal(number)
            met.append("nothing")
        except KeyboardInterrupt:
            met.append("an interrupt")

    with pytest.raises(KeyboardInterrupt):
        made_of_c(initialise)
    assert met == ["nothing"]


def test_a_second_interrupt_waits_for_nothing_and_the_first_comes_no_more(made_of_c):
    def initialise():
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        pytest.fail("it went on")

    with pytest.raises(KeyboardInterrupt):
        made_of_c(initialise)
    for thread in threading.enumerate():
        if thread.name == "relight-ending":
            thread.join(LONG_S)
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)


def test_an_interrupt_is_not_lost_in_what_python_tidies_up_after_an_import(endings_taken):
    tidying = "def tidy(ref):\n    signal.raise_signal(signal.SIGINT)"
    exec(compile(tidying, "<frozen importlib._bootstrap>", "exec"), names := {"signal": signal})

    def import_and_wait():
        lock = threading.Event()
        ref = weakref.ref(lock, names["tidy"])
        del lock
        assert ref() is None
        threading.Event().wait(LONG_S)

    with pytest.raises(KeyboardInterrupt):
        import_and_wait()
