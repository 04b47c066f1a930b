"""`relight measure`: how quick the window is on this machine."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path

from relight_core.pipeline.quality import TIERS


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of `relight measure`."""
    parser.add_argument("photos", nargs="+", metavar="PHOTO", type=Path, help="portraits; the first is dragged")
    parser.add_argument("--openings", type=int, default=0, metavar="N", help="open N photos in turn for the memory")
    parser.add_argument("--seconds", type=float, default=8.0, help="how long the light is dragged (8)")
    parser.add_argument("--repeats", type=int, default=40, help="movements timed for each slider (40)")
    parser.add_argument(
        "--quality", choices=("auto", *TIERS), default="auto", help="the tier to work at; draft opens photos soonest"
    )
    parser.add_argument("--json", action="store_true", help="one JSON object on stdout")


def run(arguments: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from app.window.measure import measure_window
    from app.window.run import NoDisplayError, make_relighter
    from relight_core.errors import InputError

    try:
        speed = measure_window(
            make_relighter,
            arguments.photos,
            drag_s=arguments.seconds,
            repeats=arguments.repeats,
            openings=arguments.openings,
            quality=arguments.quality,
        )
    except (NoDisplayError, TimeoutError) as error:
        raise InputError(f"the window can't be measured: {error}") from error
    if arguments.json:
        print(json.dumps(asdict(speed)))
        return 0
    print("                                        median      p95")
    for name, spread in (
        ("a frame while the networks run", speed.frame),
        ("rotation, hand to picture", speed.rotation),
        ("shadow, hand to picture", speed.shadow),
        ("exposure, hand to picture", speed.exposure),
    ):
        print(f"{name:36s} {spread.median_ms:7.1f} ms {spread.p95_ms:7.1f} ms")
    print(f"{speed.frames} frames and {speed.updates} pictures during the drag")
    print(f"at rest {speed.idle_cpu:.2%} of a core")
    if speed.memory_mb:
        most = max(speed.memory_mb)
        shown = sorted({0, *(len(speed.memory_mb) * part // 4 - 1 for part in (1, 2, 3, 4))} - {-1})
        places = ", ".join(f"{index + 1}: {speed.memory_mb[index]:.0f}" for index in shown)
        print(f"MiB of memory after opening number {places}; {most:.0f} at the most")
    return 0
