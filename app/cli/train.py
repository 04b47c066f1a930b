"""Train a stage of the networks for some minutes.

The stages, in their order: warm-delight, warm-relight (or warm-specular-shadow and warm-composition, one
after the other), tune-delight, tune-relight. Each goes on from the weights that --start names. A log of the
losses and a picture of their curves are written beside the weights; a checkpoint every two minutes.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from app.cli.maker_inputs import (
    add_heads_and_lights,
    check_heads_and_lights,
    check_output_file,
    count_at_least_one,
    progress,
)
from relight_core.errors import InputError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of `relight train`."""
    parser.add_argument("--stage", metavar="STAGE", required=True, help="one of those above")
    add_heads_and_lights(parser)
    parser.add_argument("--minutes", metavar="M", type=_positive, required=True, help="how long")
    parser.add_argument(
        "--start", metavar="WEIGHTS", type=Path, help="weights to go on from; random ones without"
    )
    parser.add_argument(
        "-o", "--output", metavar="WEIGHTS", type=Path, required=True, help="a .safetensors file"
    )
    parser.add_argument(
        "--size", metavar="PX", type=count_at_least_one, default=128, help="side of the images (128)"
    )
    parser.add_argument(
        "--pairs", metavar="N", type=count_at_least_one, default=8, help="pairs in a batch (8)"
    )
    parser.add_argument("--seed", metavar="N", type=int, default=0)
    parser.add_argument(
        "--rate", metavar="R", type=_positive, help="peak learning rate; the stage's own without"
    )


def run(arguments: argparse.Namespace) -> int:
    """Train; returns the exit code."""
    from relight_core.training.loop import TrainingDiverged
    from relight_core.training.run import Run, train
    from relight_core.training.stages import STAGES

    if arguments.stage not in STAGES:
        raise InputError(f"unknown stage {arguments.stage!r}: choose one of {', '.join(STAGES)}")
    check_output_file(arguments.output, (".safetensors",))
    check_heads_and_lights(arguments.heads, arguments.lights, "train")
    settings = Run(
        arguments.stage,
        arguments.heads,
        arguments.lights,
        arguments.output,
        arguments.start,
        minutes=arguments.minutes,
        size=arguments.size,
        pairs=arguments.pairs,
        seed=arguments.seed,
        learning_rate=arguments.rate,
    )
    with progress(arguments.stage, 1.0) as show:
        try:
            train(settings, lambda step, elapsed, losses: show(elapsed, _note(step, losses)))
        except TrainingDiverged as error:
            raise InputError(f"{arguments.stage}: stopped ({error}); try a lower --rate") from error
    print(f"wrote {arguments.output}", flush=True)
    _draw_curves(arguments.output)
    return 0


def _draw_curves(weights: Path) -> None:
    from relight_core.training.curves import draw_curves

    log, picture = weights.with_suffix(".log.json"), weights.with_suffix(".curves.png")
    try:
        draw_curves(log, picture)
    except InputError as error:
        print(f"no curves: {error}", flush=True)
    else:
        print(f"wrote {picture}", flush=True)


def _note(step: int, losses: dict[str, float]) -> str:
    return f"step {step}  " + "  ".join(f"{name} {value:.4f}" for name, value in losses.items())


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (value > 0 and math.isfinite(value)):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number above 0")
    return value
