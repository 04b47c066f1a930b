"""Train the networks by a recipe, or one stage of them for some minutes.

relight train --recipe shipped --heads DIR --lights FILE -o FOLDER
relight train --stage STAGE --minutes M --heads DIR --lights FILE -o WEIGHTS.safetensors
relight train --join OTHER.safetensors --start WEIGHTS.safetensors -o BOTH.safetensors

A run that was stopped goes on where it was when the command is given again; weights that a stage has ended with are
not trained over. A recipe is a TOML file, or the name of one that comes with relight.

The stages, in their order, each going on from the weights that --start names:
  warm-delight                                 de-lighting, on true channels
  warm-relight                                 the relighting networks, on true channels; or one after the other
                                               by warm-specular-shadow and warm-composition
  tune-delight, tune-delight-strongly          de-lighting, through the fixed relighting networks
  tune-relight, tune-on-predictions            the relighting networks, on what de-lighting finds
  distil-relight                               a narrow pair of relighting networks, taught by the wide one
  outline, foreign-shadow                      the person and the foreign-shadow network, beside all these

--join puts the narrow pair, the person and the foreign-shadow network of one file, as far as it has them, beside the
other networks of another. A log of the losses and a picture of their curves are written beside the weights; a
checkpoint every two minutes.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from app.cli.arguments import user_path
from app.cli.maker_inputs import (
    add_heads_and_lights,
    check_head_sizes,
    check_heads_and_lights,
    check_output_file,
    count_at_least_one,
    count_from_zero,
    let_idle_threads_sleep,
    number_above_zero,
    progress,
)
from app.cli.outputs import make_folder
from app.cli.streams import say
from relight_core.errors import InputError
from relight_core.imaging.files import is_same_file

if TYPE_CHECKING:
    from collections.abc import Iterable

    from relight_core.training.state import Progress

_OF_A_RUN = ("size", "pairs", "seed", "residual", "decoder_residual", "uses", "window")
_OF_A_STAGE = ("minutes", "rate", *_OF_A_RUN)
_OF_SAMPLES = ("heads", "lights", "places", "workers")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of `relight train`."""
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--recipe", metavar="RECIPE", help="a .toml file, or the name of a bundled recipe")
    what.add_argument("--stage", metavar="STAGE", help="one of those above")
    what.add_argument(
        "--join",
        metavar="OTHER",
        type=user_path,
        help="weights whose networks beside the first three go into --start's",
    )
    add_heads_and_lights(parser, required=False)
    parser.add_argument("--start", metavar="WEIGHTS", type=user_path, help="weights to go on from; random ones without")
    parser.add_argument(
        "-o",
        "--output",
        metavar="PLACE",
        type=user_path,
        required=True,
        help="a folder; with --stage a .safetensors file",
    )
    parser.add_argument(
        "--workers",
        metavar="N",
        type=count_at_least_one,
        help="processes that make samples (1); with a GPU one for each core. Other samples for another number",
    )
    parser.add_argument(
        "--places",
        metavar="DIR",
        type=user_path,
        help="a folder of panoramas (.hdr, .exr) that the person network's samples are put before, beside drawn scenes",
    )
    _add_stage_arguments(parser.add_argument_group("with --stage"))


def _add_stage_arguments(stage: argparse._ArgumentGroup) -> None:
    stage.add_argument("--minutes", metavar="M", type=number_above_zero, help="how long")
    stage.add_argument("--size", metavar="PX", type=count_at_least_one, help="side of the images (128)")
    stage.add_argument("--pairs", metavar="N", type=count_at_least_one, help="pairs in a batch (8)")
    stage.add_argument("--seed", metavar="N", type=count_from_zero, help="of samples and first weights (0)")
    stage.add_argument(
        "--residual",
        metavar="N,N,...",
        type=_counts,
        help="residual blocks at each level of de-lighting's encoder, finest first, where the weights have none yet",
    )
    stage.add_argument(
        "--decoder-residual", metavar="N,N,...", type=_counts, help="the same for its decoder, of one level fewer"
    )
    stage.add_argument(
        "--uses", metavar="N", type=count_at_least_one, help="how often each pair is learnt from (1); more for a GPU"
    )
    stage.add_argument("--window", metavar="N", type=count_at_least_one, help="pairs that are kept for that (1024)")
    stage.add_argument("--rate", metavar="R", type=number_above_zero, help="peak learning rate (the stage's own)")


def run(arguments: argparse.Namespace) -> int:
    """Train; returns the exit code."""
    given = [f"--{name.replace('_', '-')}" for name in _OF_A_STAGE if getattr(arguments, name) is not None]
    if arguments.stage is None and given:
        raise InputError(f"{given[0]}: goes with --stage only; a recipe says that itself, and joining needs none")
    if arguments.join is not None:
        return _join(arguments)
    if arguments.heads is None or arguments.lights is None:
        raise InputError("give --heads and --lights: what to train on")
    let_idle_threads_sleep()
    from relight_core.training.loop import TrainingDiverged

    train = _train_stage if arguments.recipe is None else _follow_recipe
    try:
        return train(arguments)
    except TrainingDiverged as error:
        raise InputError(f"{arguments.output}: training stopped ({error}); try a lower learning rate") from error


def _check_weights_file(arguments: argparse.Namespace) -> None:
    """Raise InputError unless the output is a file of weights that can be written, and none of those that are read."""
    check_output_file(arguments.output, (".safetensors",))
    for weights in (arguments.start, arguments.join):
        if weights is not None and is_same_file(arguments.output, weights):
            raise InputError(f"{arguments.output}: would be written over the weights it is made from; name another")


def _join(arguments: argparse.Namespace) -> int:
    from relight_core.networks.bundle import MORE_NETWORKS, load_bundle, save_bundle

    for name in _OF_SAMPLES:
        if getattr(arguments, name) is not None:
            raise InputError(f"--{name}: joining weights needs none; take it away")
    if arguments.start is None:
        raise InputError("give --start: the weights that the other networks go into")
    _check_weights_file(arguments)
    other, joined = load_bundle(arguments.join), load_bundle(arguments.start)
    found = {name: network for name in MORE_NETWORKS if (network := getattr(other, name)) is not None}
    if not found:
        raise InputError(
            f"{arguments.join}: has no narrow pair, no person network and no foreign-shadow network; "
            "train them with: relight train --stage distil-relight, outline or foreign-shadow"
        )
    for name, network in found.items():
        joined = MORE_NETWORKS[name](joined, network)
    save_bundle(arguments.output, joined)
    say(f"wrote {arguments.output}")
    return 0


def _follow_recipe(arguments: argparse.Namespace) -> int:
    from relight_core.training.recipe import follow, load_recipe

    recipe = load_recipe(arguments.recipe)
    result = arguments.output / "relight.safetensors"
    if arguments.start is not None and is_same_file(result, arguments.start):
        raise InputError(f"{result}: would be written over the weights it is made from; name another folder after -o")
    make_folder(arguments.output)
    check_heads_and_lights(arguments.heads, arguments.lights, "train")
    _check_sizes([(plan.name, plan.size) for plan in recipe.stages], arguments.heads)
    _check_places(arguments.places, [plan.name for plan in recipe.stages])
    with progress("training", recipe.expected_minutes(len(recipe.stages) - 1, 1.0)) as show:

        def report(number: int, elapsed: float, state: Progress) -> None:
            show(recipe.expected_minutes(number, elapsed), f"{recipe.stages[number].name}: {_note(state)}")

        follow(
            recipe,
            arguments.heads,
            arguments.lights,
            arguments.output,
            report,
            arguments.start,
            workers=arguments.workers or 1,
            places=arguments.places,
        )
    for log in sorted(arguments.output.glob("*.log.json")):
        _draw_curves(log)
    say(f"wrote {result}")
    return 0


def _check_sizes(sizes: Iterable[tuple[str, int]], heads: Path) -> None:
    """Raise InputError for a stage, of those and their sizes, that the heads are too small for."""
    from relight_core.training.stages import STAGES

    # People are cut out at the heads' own size, and put into photos of any.
    asked = [(name, size) for name, size in sizes if STAGES[name].samples != "outlines"]
    check_head_sizes(heads, "train", asked)


def _check_places(places: Path | None, names: Iterable[str]) -> None:
    """Raise InputError for panoramas that can't be read, or that none of the stages of these names looks at."""
    from relight_core.dataset.cutouts.scenery.panoramas import read_places
    from relight_core.training.stages import STAGES

    if places is None:
        return
    if not any(STAGES[name].samples == "outlines" for name in names):
        raise InputError("--places: only the person network's samples are put before them; take it away")
    read_places(places)


def _train_stage(arguments: argparse.Namespace) -> int:
    from relight_core.training.loop import state_path
    from relight_core.training.run import Run, train
    from relight_core.training.stages import STAGES

    if arguments.stage not in STAGES:
        raise InputError(f"unknown stage {arguments.stage!r}: choose one of {', '.join(STAGES)}")
    if arguments.minutes is None:
        raise InputError("give --minutes with --stage")
    if arguments.window is not None and (arguments.uses or 1) == 1:
        raise InputError("--window: pairs are kept to be used again; give --uses as well, or take it away")
    _check_weights_file(arguments)
    if arguments.output.exists() and not state_path(arguments.output).exists():
        raise InputError(
            f"{arguments.output}: holds weights whose training has ended; "
            "name another file after -o (to train them further, with these after --start), or delete it"
        )
    check_heads_and_lights(arguments.heads, arguments.lights, "train")
    given = {name: getattr(arguments, name) for name in _OF_A_RUN}
    settings = Run(
        arguments.stage,
        arguments.heads,
        arguments.lights,
        arguments.output,
        arguments.start,
        minutes=arguments.minutes,
        workers=arguments.workers or 1,
        places=arguments.places,
        learning_rate=arguments.rate,
        **{name: value for name, value in given.items() if value is not None},
    )
    _check_sizes([(settings.stage, settings.size)], settings.heads)
    _check_places(settings.places, [settings.stage])
    with progress(arguments.stage, 1.0) as show:
        train(settings, lambda elapsed, state: show(elapsed, _note(state)))
    say(f"wrote {arguments.output}")
    _draw_curves(arguments.output.with_suffix(".log.json"))
    return 0


def _draw_curves(log: Path) -> None:
    from relight_core.training.curves import draw_curves

    picture = log.with_name(log.name.replace(".log.json", ".curves.png"))
    try:
        draw_curves(log, picture)
    except InputError as error:
        say(f"no curves: {error}")
    else:
        say(f"wrote {picture}")


def _note(state: Progress) -> str:
    skipped = f" ({state.skipped} skipped)" if state.skipped else ""
    losses = "  ".join(f"{name} {value:.4f}" for name, value in state.smoothed.items())
    return f"step {state.step}{skipped}  {losses}"


def _counts(text: str) -> tuple[int, ...]:
    parts = text.split(",")
    if not all(part.strip().isdecimal() for part in parts):
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of numbers such as 0,0,0,1,1,0")
    return tuple(int(part) for part in parts)
