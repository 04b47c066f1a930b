"""Measure how quick the window is on this machine."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from app.cli.arguments import user_path
from app.cli.maker_inputs import check_output_file, count_at_least_one, count_from_zero, number_above_zero
from app.cli.outputs import check_place, write_text
from app.cli.streams import say, tell
from relight_core.imaging.files import KnownFiles
from relight_core.pipeline.quality import TIERS

if TYPE_CHECKING:
    from app.window.measure import WindowSpeed

_HEADING = f"{'median':>46s} {'p95':>8s}"
_EVERY = 10
"""Openings between two lines that tell how far it is, after a first one."""

_SPREADS = (
    ("frame", "a frame while the networks run"),
    ("rotation", "rotation, hand to picture"),
    ("shadow", "shadow, hand to picture"),
    ("exposure", "exposure, hand to picture"),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of `relight measure`."""
    parser.add_argument("photos", nargs="+", metavar="PHOTO", type=user_path, help="portraits; the first is dragged")
    parser.add_argument(
        "--openings", type=count_from_zero, default=0, metavar="N", help="open N photos in turn for the memory"
    )
    parser.add_argument("--seconds", type=number_above_zero, default=8.0, help="how long the light is dragged (8)")
    parser.add_argument("--repeats", type=count_at_least_one, default=40, help="movements timed for each slider (40)")
    parser.add_argument(
        "--quality", choices=("auto", *TIERS), default="auto", help="the tier to work at; draft opens photos soonest"
    )
    parser.add_argument("--json", action="store_true", help="one JSON object on stdout")
    parser.add_argument(
        "-o",
        "--output",
        type=user_path,
        metavar="FILE.json",
        help="write it there too, again after each part and opening",
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the command and return its exit code. What was measured before an interruption is told all the same."""
    from app.making import make_relighter
    from app.window.measure import WindowSpeed, measure_window
    from app.window.run import NoDisplayError
    from relight_core.errors import InputError

    if arguments.output:
        check_output_file(arguments.output, (".json",))
        check_place(arguments.output, KnownFiles(arguments.photos))
    speed, told = WindowSpeed(), tell if arguments.json else say
    try:
        for now in measure_window(
            make_relighter,
            arguments.photos,
            drag_s=arguments.seconds,
            repeats=arguments.repeats,
            openings=arguments.openings,
            quality=arguments.quality,
        ):
            for line in news(speed, now):
                told(line)
            speed = now
            if arguments.output:
                _write(arguments.output, speed)
            _tell_progress(speed, arguments.openings)
    except (NoDisplayError, TimeoutError) as error:
        raise InputError(f"the window can't be measured: {error}") from error
    finally:
        if speed.memory_mb and None not in speed.memory_mb:
            told(memory_line(speed.memory_mb))
        if arguments.json and speed.frame:
            say(json.dumps(asdict(speed)))
    return 0


def news(before: WindowSpeed, now: WindowSpeed) -> list[str]:
    """What `now` tells beyond `before`, a line each; what was measured first has the table's heading above it."""
    lines = [_HEADING] if before.frame is None and now.frame is not None else []
    for field, title in _SPREADS:
        spread = getattr(now, field)
        if spread is not None and spread != getattr(before, field):
            lines.append(f"{title:36s} {spread.median_ms:7.1f} ms {spread.p95_ms:7.1f} ms")
    if before.frames is None and now.frames is not None:
        lines.append(f"{now.frames} frames and {now.updates} pictures during the drag")
    if before.idle_cpu is None and now.idle_cpu is not None:
        lines.append(f"at rest {now.idle_cpu:.2%} of a core")
    return lines


def memory_line(memory_mb: tuple[float, ...]) -> str:
    """The memory after some of the openings, the first and the last among them."""
    shown = sorted({0, *(len(memory_mb) * part // 4 - 1 for part in (1, 2, 3, 4))} - {-1})
    places = ", ".join(f"{index + 1}: {memory_mb[index]:.0f}" for index in shown)
    return f"MiB of memory after opening number {places}; {max(memory_mb):.0f} at the most"


def _tell_progress(speed: WindowSpeed, openings: int) -> None:
    done = len(speed.opening_s)
    if done and (done == 1 or done % _EVERY == 0 or done == openings):
        each_s = sum(speed.opening_s) / done
        left = f"{each_s * (openings - done) / 60:.1f} min left"
        memory_mb = speed.memory_mb[-1]
        memory = "" if memory_mb is None else f"{memory_mb:.0f} MiB, "
        words = f"opened {done} of {openings}, {memory}{each_s:.1f} s each, {left}"
        tell(words)


def _write(path: Path, speed: WindowSpeed) -> None:
    write_text(path, json.dumps(asdict(speed), indent=1))
