"""Measure the networks on heads and lights that no training has seen.

Every photo of a held-out head is taken apart and relit by the editor's own stages, and each channel is
compared with the true one. The test split wants 8 baked heads:
relight dataset bake --heads MODEL.npz --out DIR --split test --count 8
Choose between variants on --split validation, so that the test stays unseen.

relight evaluate breakdown --heads DIR --lights FILE [-o TABLE.md]

Where the error comes from: the same pictures again while de-lighting is told its albedo, its normals and so on.

relight evaluate ablation --heads DIR --lights FILE [--steps N] -o FOLDER
relight evaluate peers --heads DIR --lights FILE [--steps N] [--sun FILE] [--dpr FILE] -o FOLDER

The paper's Tables 2 and 3 at a budget of your choice: the first trains the paper's variants and ours alike
and compares them; the second trains Sun et al.'s network on the same batches and sets everybody beside the
others. Both go on where they were when given again, and share a folder.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from app.cli.arguments import add_json, user_path
from app.cli.comparisons import BUDGET, add_budget, run_comparison
from app.cli.maker_inputs import (
    add_heads_and_lights,
    check_heads_and_lights,
    check_output_file,
    count_at_least_one,
    counts_to,
    progress,
    refuse_unread,
)
from app.cli.outputs import write_text
from app.cli.report import Report, reporting
from relight_core.errors import InputError

if TYPE_CHECKING:
    from relight_core.evaluation.evaluate import Settings
    from relight_core.networks.bundle import NetworkBundle

_OF_EDITOR, _OF_PEERS = ("photos", "quality"), ("sun", "dpr")
_UNREAD = {
    "networks": (*BUDGET, *_OF_PEERS),
    "networks --detail": ("weights", *_OF_EDITOR, *BUDGET, *_OF_PEERS),
    "breakdown": (*BUDGET, *_OF_PEERS),
    "ablation": ("weights", *_OF_EDITOR, *_OF_PEERS),
    "peers": _OF_EDITOR,
    "peers --sun": (*_OF_EDITOR, "steps", "pairs"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of `relight evaluate`."""
    parser.add_argument(
        "what",
        nargs="?",
        choices=("networks", "breakdown", "ablation", "peers"),
        default="networks",
        help="networks by default",
    )
    add_heads_and_lights(parser)
    parser.add_argument("--weights", metavar="W", type=user_path, help="a .safetensors file; the bundled ones without")
    parser.add_argument("--split", choices=("test", "validation"), default="test")
    parser.add_argument("--count", metavar="N", type=count_at_least_one, default=8, help="heads (8)")
    parser.add_argument(
        "--photos",
        choices=("clean", "camera"),
        help="clean renderings on black (clean), or through a camera on backgrounds",
    )
    parser.add_argument("--quality", choices=("draft", "live", "final"), help="of the editor (final)")
    parser.add_argument(
        "--detail",
        action="store_true",
        help="compare ways to carry a relit view to the photo's size instead, on heads baked with --size 1024",
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="REPORT",
        type=user_path,
        help="also write the tables, a .md file; for the paper's tables a folder",
    )
    add_json(parser)
    add_budget(parser)


def run(arguments: argparse.Namespace) -> int:
    """Evaluate; returns the exit code."""
    if arguments.detail and arguments.what != "networks":
        raise InputError(f"--detail does not go with {arguments.what}: it compares something else")
    what = f"{arguments.what} --detail" if arguments.detail else arguments.what
    if what == "peers" and arguments.sun is not None:
        what = "peers --sun"
    refuse_unread(arguments, _UNREAD[what], f"evaluate {what}")
    if arguments.what in ("ablation", "peers"):
        return run_comparison(arguments)
    if arguments.output is not None:
        check_output_file(arguments.output, (".md",))
    if arguments.detail:
        return _compare_detail(arguments)
    return _break_down(arguments) if arguments.what == "breakdown" else _measure(arguments)


def _measure(arguments: argparse.Namespace) -> int:
    from relight_core.evaluation.evaluate import evaluate
    from relight_core.evaluation.report import as_markdown, as_record

    with reporting(arguments.json) as report:
        weights, bundle, settings = _under_test(arguments)
        with progress("relighting", 1.0) as show:
            evaluation = evaluate(bundle, settings, counts_to(show))
        page, record = as_markdown(evaluation, weights.name), as_record(evaluation, str(weights))
        _tell(report, arguments.output, page, record)
    return 0


def _break_down(arguments: argparse.Namespace) -> int:
    from relight_core.evaluation.breakdown import as_markdown, as_record, break_down
    from relight_core.pipeline.quality import quality_of

    with reporting(arguments.json) as report:
        weights, bundle, settings = _under_test(arguments)
        with progress("relighting", 1.0) as show:
            breakdown = break_down(bundle, settings, counts_to(show))
        measured = {"weights": str(weights), "split": arguments.split, "photos": settings.photos}
        record = as_record(breakdown) | measured | {"quality": quality_of(settings.tier)}
        _tell(report, arguments.output, as_markdown(breakdown, weights.name, settings), record)
    return 0


def _under_test(arguments: argparse.Namespace) -> tuple[Path, NetworkBundle, Settings]:
    from relight_core.evaluation.evaluate import Settings
    from relight_core.networks.bundle import load_bundle
    from relight_core.pipeline.quality import tier_of
    from relight_core.pipeline.relighter import WEIGHTS
    from relight_core.resources import resource_path

    weights = arguments.weights or resource_path(*WEIGHTS)
    bundle = load_bundle(weights).for_inference()
    check_heads_and_lights(arguments.heads, arguments.lights, arguments.split)
    settings = Settings(
        arguments.heads,
        arguments.lights,
        arguments.split,
        arguments.count,
        arguments.photos or "clean",
        tier_of(arguments.quality or "final"),
    )
    return weights, bundle, settings


def _tell(report: Report, place: Path | None, page: str, record: dict) -> None:
    report.figures(page, record)
    if place is not None:
        write_text(place, page)


def _compare_detail(arguments: argparse.Namespace) -> int:
    from relight_core.evaluation.detail import compare_detail, detail_table

    with reporting(arguments.json) as report:
        check_heads_and_lights(arguments.heads, arguments.lights, arguments.split)
        with progress("relighting", 1.0) as show:
            scores = compare_detail(
                arguments.heads,
                arguments.lights,
                arguments.split,
                arguments.count,
                counts_to(show),
            )
        record = {"errors": _known(scores.errors), "blurred": _known(scores.blurred)}
        record |= {"pictures": scores.pictures, "size": scores.size}
        _tell(report, arguments.output, detail_table(scores), record)
    return 0


def _known(errors: dict[str, dict[str, float]]) -> dict[str, dict[str, float | None]]:
    """Errors by method and region for the JSON object; null of a region that no head has."""
    from relight_core.evaluation.report import known

    return {method: {region: known(error) for region, error in row.items()} for method, row in errors.items()}
