"""What the subcommands that make and measure (dataset, train, evaluate, bench, measure) share."""

from __future__ import annotations

import argparse
import contextlib
import math
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from datetime import timedelta
from pathlib import Path
from typing import TYPE_CHECKING

from app.cli.arguments import user_path
from app.cli.outputs import check_folder
from app.cli.streams import Heedless, tell
from app.engine.batch import photos_in
from relight_core.errors import InputError

if TYPE_CHECKING:
    from rich.progress import Task

LIGHTS_HELP = "a light library, an .npz, or a folder of .hdr and .exr panoramas"
SPLITS = ("train", "validation", "test")

_LEAST_SIDE_PX = 16
"""Of samples: the losses compare heights that lie so far apart."""

_ESTIMATED_OVER_S = 900.0
"""Training tells how far it is once in a minute or two, and two such times are the least that tell its speed."""


def add_heads_and_lights(parser: argparse.ArgumentParser, *, required: bool = True) -> None:
    """--heads and --lights, the data of training and evaluation."""
    parser.add_argument(
        "--heads", metavar="DIR", type=user_path, required=required, help="heads from relight dataset bake"
    )
    parser.add_argument("--lights", metavar="LIGHTS", type=user_path, required=required, help=LIGHTS_HELP)


def count_at_least_one(text: str) -> int:
    """An argument's whole number, 1 or more."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from 1 up")
    return int(text)


def count_from_zero(text: str) -> int:
    """An argument's whole number, 0 or more, and no larger than a seed may be."""
    if not text.isdecimal() or int(text) >= 2**63:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from 0 up, below 2**63")
    return int(text)


def number_above_zero(text: str) -> float:
    """An argument's finite number that is larger than 0."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (value > 0 and math.isfinite(value)):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number above 0")
    return value


def let_idle_threads_sleep() -> None:
    """PyTorch's threads that have nothing to do leave their cores to the samples' makers; read when it is imported."""
    os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")


def check_heads_and_lights(heads: Path, lights: Path, split: str) -> int:
    """Make sure that a split has heads and lights before anything slow starts.

    Every head is opened, in a millisecond each: a training that meets half a file after hours could not go on, for
    a head that is baked anew makes the data others than it began with.

    Returns:
        the number of heads.

    Raises:
        InputError: either is missing or can't be read.
    """
    from relight_core.dataset.baking.shard import shard_size
    from relight_core.dataset.lighting.lights import load_lights
    from relight_core.dataset.recipe import load_split

    load_lights(lights, split)
    if not heads.is_dir():
        raise InputError(f"{heads}: no such folder; make heads with: relight dataset bake --out {heads}")
    paths = load_split(heads, split)
    if not paths:
        raise InputError(
            f"{heads}: no heads of the {split} split; make some with: "
            f"relight dataset bake --split {split} --out {heads}"
        )
    for path in paths:
        shard_size(path)
    return len(paths)


def check_head_sizes(heads: Path, split: str, asked: Sequence[tuple[str, int]], count: int | None = None) -> None:
    """Raise InputError where a split's first `count` heads, all without it, lack a size: it would be met hours later.

    Sizes below 16 pixels are lacking everywhere.

    Args:
        asked: who asks, and for which side of the images in pixels.
    """
    from relight_core.dataset.baking.shard import shard_size
    from relight_core.dataset.recipe import load_split

    for who, size in asked:
        if size < _LEAST_SIDE_PX:
            raise InputError(f"{who} asks for a size of {size}: samples are {_LEAST_SIDE_PX} pixels wide or more")
    for path in load_split(heads, split)[:count]:
        whole = shard_size(path)
        for who, size in asked:
            if whole % size:
                raise InputError(
                    f"{path}: a head of {whole} pixels has no size of {size}, which {who} asks for; "
                    "give a divisor of it, or bake heads with another --size"
                )


def photos_after_option(place: Path) -> list[Path]:
    """What stands after --photos: one photo, or those in a folder as of `photos_in`; InputError where there is none."""
    if place.is_file():
        return [place]
    if not place.is_dir():
        raise InputError(f"{place}: no such photo or folder; give one after --photos")
    return photos_in(place)


def check_output_file(path: Path, suffixes: tuple[str, ...]) -> None:
    """Raise InputError unless a file of one of these suffixes can be written there."""
    if path.suffix.lower() not in suffixes:
        raise InputError(f"{path}: its name must end in {' or '.join(suffixes)}")
    if os.path.isdir(path):
        raise InputError(f"{path}: is a folder; give a file's name")
    check_folder(path.parent)


def refuse_unread(arguments: argparse.Namespace, options: Iterable[str], what: str) -> None:
    """Raise InputError for an option that would change nothing: the figures would be taken for what they are not."""
    for option in options:
        if getattr(arguments, option) not in (None, "cpu"):
            raise InputError(f"--{option}: changes nothing of what {what} measures; take it away")


@contextlib.contextmanager
def progress(title: str, total: float, line_every_s: float = 60.0) -> Iterator[Callable[[float, str], None]]:
    """A bar on stderr with an estimate of the time left; call the result with what is done and a note.

    Where stderr is no terminal but, say, the log of a run of hours, a line is written every `line_every_s` instead,
    and one where it ended.
    """
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        TextColumn("{task.fields[note]}"),
    )
    console = Console(file=Heedless(sys.stderr))
    in_lines = not console.is_terminal
    with Progress(*columns, console=console, speed_estimate_period=_ESTIMATED_OVER_S, disable=in_lines) as bar:
        bar.add_task(title, total=total, note="")
        (task,) = bar.tasks
        told_at, untold = time.monotonic(), False

        def show(done: float, note: str = "") -> None:
            nonlocal told_at, untold
            bar.update(task.id, completed=done, note=note)
            untold = in_lines
            if untold and time.monotonic() - told_at >= line_every_s:
                told_at, untold = time.monotonic(), False
                tell(_line(task))

        try:
            yield show
        finally:
            if untold:
                tell(_line(task))


def counts_to(show: Callable[[float, str], None]) -> Callable[[int, int], None]:
    """Shows how many are done, of how many, on a `progress` whose total is 1."""
    return lambda done, total: show(done / total, f"{done} of {total}")


def _line(task: Task) -> str:
    """How far a task is, for a log."""
    elapsed, left = (
        "-:--:--" if seconds is None else timedelta(seconds=round(seconds))
        for seconds in (task.elapsed, task.time_remaining)
    )
    return f"{task.description} {task.percentage:.0f} % {elapsed} left {left} {task.fields['note']}".rstrip()
