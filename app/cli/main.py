"""Entry point of the `relight` command: chooses the subcommand and turns what went wrong into an exit code.

A subcommand is a module of this package with `add_arguments(parser)` and `run(arguments) -> int`. Only the
chosen one is imported, and none imports heavy libraries before `run`, so `--help` answers at once.
"""

from __future__ import annotations

import importlib
import io
import os
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from types import ModuleType

from app.cli.arguments import OneLineParser
from app.cli.streams import flush_said, let_go_of_streams, tell
from app.faults import confession
from relight_core.errors import InputError
from relight_core.idle_threads import keep_numpy_to_one_thread

DONE, OUR_FAULT, BAD_INPUT, INTERRUPTED, READER_LEFT = 0, 1, 2, 130, 141

EDITOR = "edit"

COMMANDS = {
    "render": "relight photos and write them to files",
    "channels": "write every intermediate channel of one relighting",
    "turntable": "write a sheet or a film of one photo under a turning light",
    "rigs": "list the bundled lights",
    "info": "show versions, devices, graphics, weights and threads",
    "dataset": "make the training data",
    "train": "train the networks",
    "evaluate": "measure the networks",
    "bench": "time the stages",
    "measure": "measure how quick the window is",
}

_TAKE_SEVERAL = {EDITOR, "render"}
"""Commands to which several photos may be given."""

_TRAIN_EXTRAS = {"mitsuba", "drjit", "rich", "matplotlib"}


def main(argv: Sequence[str] | None = None, interrupted: Callable[[], None] = lambda: None) -> int:
    """Run the command line and return its exit code.

    Args:
        argv: the words after the program's name; sys.argv's by default.
        interrupted: called where it has been, before what the command had open is let go of.

    Returns:
        0 done, 2 wrong usage, bad input or output that can't be written (one line on stderr), 1 a fault of ours,
        130 interrupted, 141 where whoever read our output has left.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    name = words.pop(0) if words and words[0] in available_commands() else EDITOR
    program = "relight" if name == EDITOR else f"relight {name}"
    _stand_in_for_closed_streams()
    _let_any_file_name_print()
    keep_numpy_to_one_thread()
    code = _outcome(name, program, words, interrupted)
    let_go_of_streams()
    return code


def _outcome(name: str, program: str, words: list[str], interrupted: Callable[[], None]) -> int:
    try:
        with _one_line_warnings(program):
            return _run(name, program, words)
    except InputError as error:
        _tell(program, str(error))
        return BAD_INPUT
    except KeyboardInterrupt:
        interrupted()
        return INTERRUPTED
    except BrokenPipeError:
        return READER_LEFT
    except Exception as error:
        _confess(program, error)
        return OUR_FAULT


def available_commands() -> dict[str, str]:
    """The subcommands this installation has, each with a line of help."""
    return {name: line for name, line in COMMANDS.items() if find_spec(f"app.cli.{name}") is not None}


def _run(name: str, program: str, words: list[str]) -> int:
    try:
        command = importlib.import_module(f"app.cli.{name}")
        parser = OneLineParser(prog=program, description=command.__doc__, takes_several=name in _TAKE_SEVERAL)
        command.add_arguments(parser)
        if name == EDITOR:
            parser.epilog = _list_of_commands()
        code = _run_parsed(command, parser, words)
        flush_said()
        return code
    except ModuleNotFoundError as error:
        if error.name and error.name.partition(".")[0] in _TRAIN_EXTRAS:
            raise InputError(f"this needs {error.name}: pip install -e '.[train]'") from error
        raise


def _run_parsed(command: ModuleType, parser: OneLineParser, words: list[str]) -> int:
    try:
        return command.run(parser.parse_args(words))
    except SystemExit as stop:
        return stop.code if isinstance(stop.code, int) else DONE


def _list_of_commands() -> str:
    lines = [f"  {name:<12}{line}" for name, line in available_commands().items()]
    return "commands (relight COMMAND --help tells more):\n" + "\n".join(lines)


@contextmanager
def _one_line_warnings(program: str) -> Iterator[None]:
    def show(message, category, *_place, **_more) -> None:
        _tell(program, f"warning: {message}")

    with warnings.catch_warnings():
        warnings.showwarning = show
        yield


def _stand_in_for_closed_streams() -> None:
    """Whoever starts programs may give them no streams; then nobody reads what is told, and all else goes on."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            # The lowest number that is free, which is the closed stream's own.
            setattr(sys, name, open(os.devnull, mode))  # noqa: SIM115


def _let_any_file_name_print() -> None:
    """File names need not be text in the terminal's encoding; show the odd byte instead of failing on it."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


def _confess(program: str, error: Exception) -> None:
    if os.environ.get("RELIGHT_DEBUG") == "1":
        tell(traceback.format_exc(), end="")
    _tell(program, f"{confession(error)}; RELIGHT_DEBUG=1 shows where it happened")


def _tell(program: str, message: str) -> None:
    tell(f"{program}: {' '.join(message.splitlines())}")
