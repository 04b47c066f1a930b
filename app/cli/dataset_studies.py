"""Looks at the training data: contact sheets, speeds, and what a data set is worth."""

from __future__ import annotations

import argparse
import os
import tempfile
from pathlib import Path

from app.cli.arguments import user_path
from app.cli.maker_inputs import (
    LIGHTS_HELP,
    SPLITS,
    check_head_sizes,
    check_heads_and_lights,
    check_output_file,
    count_at_least_one,
    count_from_zero,
    let_idle_threads_sleep,
    photos_after_option,
    progress,
)
from app.cli.outputs import check_place, make_folder
from app.cli.streams import say
from relight_core.errors import InputError
from relight_core.imaging.files import KnownFiles

_COLUMNS = 12
_CELL_PX = 160
_PICTURES = (".png", ".jpg", ".jpeg")


def add_study_arguments(actions) -> None:
    """Declare the arguments of `relight dataset preview`, `speed` and `effect`."""
    preview = actions.add_parser("preview", description="Draw every channel of samples as training sees them.")
    _add_data(preview)
    preview.add_argument("--split", choices=SPLITS, default="train")
    preview.add_argument("--count", metavar="N", type=count_at_least_one, default=8, help="samples, one in a row (8)")
    preview.add_argument("--seed", metavar="N", type=count_from_zero, default=0, help="another one draws other samples")
    preview.add_argument("-o", "--output", metavar="SHEET", type=user_path, required=True, help="a .png or .jpg file")
    speed = actions.add_parser("speed", description="Time the making of samples on one core of an idle machine.")
    _add_data(speed)
    speed.add_argument("--size", metavar="PX", type=int, action="append", help="side of the images (128 and 256)")
    speed.add_argument("--rounds", metavar="N", type=count_at_least_one, default=1, help="of 8 heads each (1)")
    speed.add_argument(
        "--steps", metavar="N", type=count_from_zero, default=20, help="training steps to watch; 0 for none (20)"
    )
    effect = actions.add_parser("effect", description="Train one small network on two data sets, and compare them.")
    _add_data(effect)
    effect.add_argument("--bare", metavar="DIR", type=user_path, required=True, help="heads baked without a wardrobe")
    effect.add_argument("--photos", metavar="PHOTOS", type=user_path, required=True, help="a photo or a folder of them")
    effect.add_argument("--steps", metavar="N", type=count_at_least_one, default=600, help="of training (600)")
    effect.add_argument("--size", metavar="PX", type=count_at_least_one, default=64, help="side of the images (64)")
    effect.add_argument("--pairs", metavar="N", type=count_at_least_one, default=8, help="in a batch (8)")
    effect.add_argument("--width", metavar="N", type=count_at_least_one, default=12, help="of the network (12)")
    effect.add_argument(
        "--work", metavar="DIR", type=user_path, help="keep the weights there; what is there is used again"
    )
    effect.add_argument("-o", "--output", metavar="SHEET", type=user_path, required=True, help="a .png or .jpg file")


def _add_data(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--shards", metavar="DIR", type=user_path, required=True, help="heads that bake made")
    parser.add_argument("--lights", metavar="LIGHTS", type=user_path, required=True, help=LIGHTS_HELP)


def _preview(arguments: argparse.Namespace) -> int:
    from relight_core.dataset.preview import sample_pictures
    from relight_core.imaging.contact_sheet import contact_sheet

    check_output_file(arguments.output, _PICTURES)
    check_heads_and_lights(arguments.shards, arguments.lights, arguments.split)
    pictures = []
    with progress("drawing samples", arguments.count) as show:
        samples = sample_pictures(arguments.shards, arguments.lights, arguments.split, arguments.count, arguments.seed)
        for done, row in enumerate(samples, 1):
            pictures += row
            show(done)
    _write_sheet(arguments.output, contact_sheet(pictures, _COLUMNS, _CELL_PX))
    return 0


def _speed(arguments: argparse.Namespace) -> int:
    let_idle_threads_sleep()
    from relight_core.evaluation.bench_machine import load_average
    from relight_core.evaluation.loader_speed import loader_speed, waiting_share

    check_heads_and_lights(arguments.shards, arguments.lights, "train")
    sizes = arguments.size or (128, 256)
    check_head_sizes(arguments.shards, "train", [("dataset speed", size) for size in sizes])
    if (load := load_average()) is not None:
        busy = "; the machine is busy, these are not its speeds" if load > 0.5 else ""
        say(f"load average before: {load:.1f} on {os.cpu_count()} cores{busy}")
    say("| size | samples | per second, one core | per second of its own time | steps wait for the loader |")
    say("|---|---|---|---|---|")
    for size in sizes:
        found = loader_speed(arguments.shards, arguments.lights, size, arguments.rounds)
        share = ""
        if arguments.steps > 0:
            share = f"{waiting_share(arguments.shards, arguments.lights, size, arguments.steps):.0%}"
        say(f"| {size} | {found.samples} | {found.wall_per_s:.1f} | {found.cpu_per_s:.1f} | {share} |")
    return 0


def _effect(arguments: argparse.Namespace) -> int:
    let_idle_threads_sleep()
    from relight_core.evaluation.dataset_effect import TrainingSettings, photos_of_people

    check_output_file(arguments.output, _PICTURES)
    if arguments.size % 16:
        raise InputError(f"--size {arguments.size}: not a multiple of 16")
    for folder in (arguments.shards, arguments.bare):
        check_heads_and_lights(folder, arguments.lights, "train")
        check_head_sizes(folder, "train", [("dataset effect", arguments.size)])
    paths = photos_after_option(arguments.photos)
    check_place(arguments.output, KnownFiles(paths))
    if arguments.work is not None:
        make_folder(arguments.work)
    paths = photos_of_people(paths)  # What can't be shown is told before the training and not after it.
    settings = TrainingSettings(arguments.steps, arguments.size, arguments.pairs, arguments.width)
    if arguments.work is not None:
        return _compare(arguments, paths, settings, arguments.work)
    with tempfile.TemporaryDirectory() as folder:
        return _compare(arguments, paths, settings, Path(folder))


def _compare(arguments: argparse.Namespace, paths: list[Path], settings, work: Path) -> int:
    from relight_core.evaluation.dataset_effect import compare_photos, trained
    from relight_core.evaluation.tables import figure_text, markdown_table
    from relight_core.imaging.contact_sheet import contact_sheet

    networks = {}
    for name, heads, plain in (("plain", arguments.bare, True), ("varied", arguments.shards, False)):
        with progress(f"training on {name} heads", 1.0) as show:
            networks[name] = trained(
                heads, arguments.lights, settings, work / f"{name}.safetensors", lambda part, _: show(part), plain=plain
            )
    comparison = compare_photos(networks, paths, settings.size)
    rows = []
    for name, figures in comparison.figures.items():
        row = ((figures.detail, ".3f"), (figures.spread, ".3f"), (figures.light_left, ".2f"))
        rows.append([name, *(figure_text(*figure) for figure in row), str(comparison.photos)])
    titles = ("trained on", "detail kept", "spread of people, stops", "light left", "photos")
    say("\n".join(markdown_table(titles, rows)))
    _write_sheet(arguments.output, contact_sheet(comparison.pictures, 1 + 2 * len(networks), _CELL_PX))
    return 0


def _write_sheet(path: Path, sheet) -> None:
    from relight_core.imaging.photo import Photo
    from relight_core.imaging.write import write_image

    write_image(path, Photo.from_srgb(sheet).linear)
    say(f"wrote {path}")


STUDIES = {"preview": _preview, "speed": _speed, "effect": _effect}
"""What each of these actions does; each returns the exit code."""
