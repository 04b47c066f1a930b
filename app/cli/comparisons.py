"""`relight evaluate ablation` and `relight evaluate peers`: the paper's Tables 2 and 3."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from app.cli.arguments import user_path
from app.cli.maker_inputs import (
    check_head_sizes,
    check_heads_and_lights,
    count_at_least_one,
    let_idle_threads_sleep,
    progress,
)
from app.cli.outputs import make_folder, write_report
from app.cli.report import Report, reporting
from relight_core.errors import InputError

if TYPE_CHECKING:
    from relight_core.evaluation.ablation.variants import Budget
    from relight_core.evaluation.contest import Contest, Outcome

BUDGET = ("steps", "size", "pairs", "every")
"""Options of the tables alone; None where they are not given."""

_SIZE, _PAIRS, _EVERY = 64, 4, 1


def add_budget(parser: argparse.ArgumentParser) -> None:
    """Declare what only the tables take."""
    group = parser.add_argument_group("with ablation and peers")
    group.add_argument(
        "--steps", metavar="N", type=count_at_least_one, help="of each warm-up; fine-tuning takes a third of them (300)"
    )
    group.add_argument(
        "--size", metavar="PX", type=count_at_least_one, help=f"side of the images, a multiple of 32 ({_SIZE})"
    )
    group.add_argument("--pairs", metavar="N", type=count_at_least_one, help=f"pairs of lights in a batch ({_PAIRS})")
    group.add_argument(
        "--every", metavar="N", type=count_at_least_one, help=f"take every N-th relighting of a head ({_EVERY})"
    )
    group.add_argument(
        "--sun",
        metavar="FILE",
        type=user_path,
        help="peers: Sun et al.'s network of another comparison, sun/sun.safetensors there, at its own size",
    )
    group.add_argument("--dpr", metavar="FILE", type=user_path, help="peers: DPR's own weights, trained_model_03.t7")


def run_comparison(arguments: argparse.Namespace) -> int:
    """Train what is missing, compare, write; returns the exit code."""
    let_idle_threads_sleep()
    from relight_core.evaluation.ablation.variants import Budget
    from relight_core.evaluation.contest import Contest

    if arguments.output is None:
        raise InputError(f"evaluate {arguments.what} wants a folder after -o")
    size = arguments.size or _SIZE
    if size % 32:
        raise InputError(f"--size {size} is not a multiple of 32")
    learns = arguments.what == "ablation" or arguments.sun is None
    for split in (["train"] if learns else []) + [arguments.split]:
        check_heads_and_lights(arguments.heads, arguments.lights, split)
        count = arguments.count if split == arguments.split else None
        check_head_sizes(arguments.heads, split, [(f"evaluate {arguments.what}", size)], count)
    make_folder(arguments.output)
    budget = Budget(arguments.steps, size, arguments.pairs or _PAIRS)
    contest = Contest(
        arguments.heads, arguments.lights, size, arguments.split, arguments.count, arguments.every or _EVERY
    )
    compare = {"ablation": _ablation, "peers": _peers}[arguments.what]
    with reporting(arguments.json) as report:
        compare(arguments, budget, contest, report)
    return 0


def _ablation(arguments: argparse.Namespace, budget: Budget, contest: Contest, report: Report) -> None:
    from relight_core.evaluation.ablation.table import as_markdown, score_variants
    from relight_core.evaluation.ablation.variants import in_words, train_variants

    with progress("training", 1.0) as show:
        weights = train_variants(contest.heads, contest.lights, arguments.output, budget, show)
    with progress("relighting", 1.0) as show:
        outcome = score_variants(weights, contest, show)
    _write(arguments.output / "ablation", outcome, as_markdown(outcome, in_words(budget)), in_words(budget), report)


def _peers(arguments: argparse.Namespace, budget: Budget, contest: Contest, report: Report) -> None:
    from relight_core.evaluation.ablation.variants import in_words, trained_variants
    from relight_core.evaluation.contest import hold
    from relight_core.evaluation.peers.dpr import load_dpr
    from relight_core.evaluation.peers.sun import Sun, load_sun
    from relight_core.evaluation.peers.table import as_markdown, contenders, trained_sun
    from relight_core.networks.bundle import load_bundle
    from relight_core.pipeline.quality import tier_of

    # Whoever can't be read is told before the training and not after it.
    dpr = None if arguments.dpr is None else load_dpr(arguments.dpr)
    networks = {name: load_bundle(path) for name, path in trained_variants(arguments.output).items()}
    given = None if arguments.weights is None else load_bundle(arguments.weights)
    if arguments.sun is not None:
        sun = Sun(load_sun(arguments.sun))
        training = sun.in_words()
    else:
        like = given.config.delight if given is not None and not networks else None
        with progress("training", 1.0) as show:
            sun = trained_sun(contest.heads, contest.lights, arguments.output, budget, show, like)
        training = in_words(budget)
    in_editor = {}
    if given is not None:
        # A file may be called as a variant of the folder is, and both take part.
        name = arguments.weights.name if arguments.weights.stem in networks else arguments.weights.stem
        networks[name] = given
        training += f" {name} was trained elsewhere."
        if contest.size >= tier_of("final").delight_size:
            in_editor[name] = load_bundle(arguments.weights).for_inference()
    everybody = contenders(networks, sun, dpr, in_editor)
    with progress("relighting", 1.0) as show:
        outcome = hold(everybody, contest, show)
    _write(arguments.output / "peers", outcome, as_markdown(outcome, training), training, report)


def _write(place: Path, outcome: Outcome, page: str, training: str, report: Report) -> None:
    from relight_core.evaluation.contest_report import as_record
    from relight_core.imaging.write import write_image

    record = as_record(outcome, training)
    report.figures(page, record)
    write_report(place, page, record)
    write_image(place.with_suffix(".png"), outcome.sheet)
