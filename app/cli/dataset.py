"""Make the training data: bake heads, check their light against a path tracer, look at samples.

relight dataset bake --heads HEADS [--wardrobe FOLDER] --out DIR --split train [--skip N] --count N
relight dataset skins --heads MODEL.npz --wardrobe FOLDER --out DIR
relight dataset lights FOLDER -o LIGHTS.npz
relight dataset check --heads HEADS [--wardrobe FOLDER] --lights LIGHTS [--count N]
relight dataset preview --shards DIR --lights LIGHTS -o SHEET.png
relight dataset speed --shards DIR --lights LIGHTS
relight dataset effect --shards DIR --bare DIR --lights LIGHTS --photos FOLDER -o SHEET.png

A head belongs to its seed, and every split has its own seeds, so no identity is in two splits. Baking that
was interrupted goes on where it stopped. HEADS is a head model (.npz) or a folder of scans, LIGHTS a light library
(.npz) or a folder of panoramas; docs/dataset.md says how both are laid out.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from app.cli.arguments import user_path
from app.cli.dataset_studies import STUDIES, add_study_arguments
from app.cli.maker_inputs import (
    LIGHTS_HELP,
    SPLITS,
    check_output_file,
    count_at_least_one,
    count_from_zero,
    progress,
)
from app.cli.outputs import check_place, make_folder
from app.cli.streams import say
from relight_core.errors import InputError
from relight_core.imaging.files import KnownFiles

_HEADS = "a head model, an .npz, or a folder of scans"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of `relight dataset`."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    bake = actions.add_parser("bake", description="Bake heads: everything that any light needs to light them.")
    bake.add_argument("--heads", metavar="HEADS", type=user_path, required=True, help=_HEADS)
    bake.add_argument(
        "--wardrobe", metavar="FOLDER", type=user_path, help="unpacked MakeHuman data; heads are bare without"
    )
    bake.add_argument("--out", metavar="DIR", type=user_path, required=True, help="where the heads go")
    bake.add_argument("--split", choices=SPLITS, default="train")
    bake.add_argument("--count", metavar="N", type=count_at_least_one, required=True, help="how many heads in all")
    bake.add_argument(
        "--skip", metavar="N", type=count_from_zero, default=0, help="leave the split's first N people out"
    )
    bake.add_argument("--headwear", metavar="SHARE", type=_share, help="how many heads wear something on them, 0 to 1")
    bake.add_argument("--arms", metavar="SHARE", type=_share, help="how many have an arm raised to them")
    bake.add_argument("--hair-mass", metavar="SHARE", type=_share, help="how many without headwear have great hair")
    bake.add_argument("--size", metavar="PX", type=_size, default=256, help="side of the images (256)")
    skins = actions.add_parser("skins", description="Carry MakeHuman's skins onto the head model, beside baked heads.")
    skins.add_argument("--heads", metavar="MODEL", type=user_path, required=True, help="the head model, an .npz")
    skins.add_argument("--wardrobe", metavar="FOLDER", type=user_path, required=True, help="unpacked MakeHuman data")
    skins.add_argument("--out", metavar="DIR", type=user_path, required=True, help="the folder of the heads")
    lights = actions.add_parser("lights", description="Keep a folder of panoramas as one file that opens quickly.")
    lights.add_argument(
        "folder", metavar="FOLDER", type=user_path, help=".hdr and .exr panoramas, a sub-folder per place"
    )
    lights.add_argument("-o", "--output", metavar="LIGHTS", type=user_path, required=True, help="an .npz file")
    check = actions.add_parser("check", description="Compare baked light with a path tracer's, head by head.")
    check.add_argument("--heads", metavar="HEADS", type=user_path, required=True, help=_HEADS)
    check.add_argument("--wardrobe", metavar="FOLDER", type=user_path, help="unpacked MakeHuman data")
    check.add_argument("--lights", metavar="LIGHTS", type=user_path, required=True, help=LIGHTS_HELP)
    check.add_argument("--count", metavar="N", type=count_at_least_one, default=10, help="heads (10)")
    check.add_argument("--lights-per-head", metavar="N", type=count_at_least_one, default=10, help="(10)")
    add_study_arguments(actions)


def run(arguments: argparse.Namespace) -> int:
    """Do what the action says; returns the exit code."""
    return _ACTIONS[arguments.action](arguments)


def _bake(arguments: argparse.Namespace) -> int:
    from relight_core.dataset.recipe import SPLIT_SEEDS, SPLIT_SIZE, bake_missing, shard_path
    from relight_core.evaluation.counted import counted

    if arguments.skip + arguments.count > SPLIT_SIZE:
        raise InputError(f"--skip and --count: a split has {SPLIT_SIZE} people; those after them are the next split's")
    casting = _casting(arguments.heads, arguments.wardrobe, **_shares(arguments))
    make_folder(arguments.out)
    if arguments.split == "train" and arguments.wardrobe is not None:
        _add_skins(casting, arguments.wardrobe, arguments.out)
    first = SPLIT_SEEDS[arguments.split] + arguments.skip
    seeds = range(first, first + arguments.count)
    kept, size_bytes = sum(shard_path(arguments.out, seed).exists() for seed in seeds), 0
    with progress(f"baking {arguments.split} heads", arguments.count) as show:
        for done, path in enumerate(bake_missing(casting, arguments.out, seeds, arguments.size), 1):
            size_bytes += path.stat().st_size
            show(done, f"{done} of {arguments.count}")
    # Made with or without a wardrobe and of whatever shares: a head does not tell, and is not made again.
    as_they_were = f"; {kept} of them were there and stay as they were baked" if kept else ""
    baked = counted(arguments.count, f"{arguments.split} head")
    say(f"{arguments.out}: {baked}, {size_bytes / 1e6:.1f} MB{as_they_were}")
    return 0


def _add_skins(casting, wardrobe: Path, folder: Path) -> None:
    """Write MakeHuman's skins beside the heads unless they are there or the wardrobe has none."""
    from relight_core.dataset.painting.skin_textures import load_skins, write_skins
    from relight_core.dataset.painting.skin_transfer import transfer_skins

    if load_skins(folder) is None:
        skins = transfer_skins(wardrobe, casting.model)
        if skins.names:
            write_skins(folder, skins)


def _skins(arguments: argparse.Namespace) -> int:
    from relight_core.dataset.painting.skin_textures import FILE_NAME, write_skins
    from relight_core.dataset.painting.skin_transfer import transfer_skins
    from relight_core.evaluation.counted import counted

    if arguments.heads.is_dir():
        raise InputError(f"{arguments.heads}: skins are carried onto a head model; give its .npz")
    check_place(arguments.out / FILE_NAME, KnownFiles([arguments.heads]), folder_is_made=True)
    casting = _casting(arguments.heads, arguments.wardrobe)
    make_folder(arguments.out)
    skins = transfer_skins(arguments.wardrobe, casting.model)
    if not skins.names:
        raise InputError(f"{arguments.wardrobe}: no skins here; give the whole MakeHuman archive, unpacked")
    path = write_skins(arguments.out, skins)
    say(f"{path}: {counted(len(skins.names), 'skin')}")
    return 0


def _check(arguments: argparse.Namespace) -> int:
    import numpy as np

    from relight_core.dataset.baking.check import check_heads
    from relight_core.dataset.lighting.lights import load_lights, sample_network_lights
    from relight_core.dataset.recipe import SPLIT_SEEDS

    casting = _casting(arguments.heads, arguments.wardrobe)
    library, rng = load_lights(arguments.lights, "validation"), np.random.default_rng(0)
    lights = sample_network_lights(library, rng, arguments.lights_per_head)
    first = SPLIT_SEEDS["validation"]
    found = []
    say("| head | light | direct | bounces, without term | bounces, with term |\n|---|---|---|---|---|")
    for difference in check_heads(casting, range(first, first + arguments.count), lights):
        errors = (difference.direct, difference.without_bounce, difference.with_bounce)
        found.append(errors)
        cells = " | ".join(f"{error:.4f}" for error in errors)
        say(f"| {difference.seed} | {difference.light} | {cells} |")
    cells = " | ".join(f"{error:.4f}" for error in np.sqrt(np.mean(np.square(found), 0)))
    say(f"| all | | {cells} |")
    return 0


def _shares(arguments: argparse.Namespace) -> dict[str, float]:
    """Those that are given."""
    asked = {name: getattr(arguments, name) for name in ("headwear", "arms", "hair_mass")}
    return {name: share for name, share in asked.items() if share is not None}


def _casting(heads: Path, wardrobe: Path | None, **shares: float):
    from relight_core.dataset.garments.dressing import Shares
    from relight_core.dataset.recipe import load_casting

    if not heads.exists():
        raise InputError(f"{heads}: no such file; give a head model's .npz or a folder of scans after --heads")
    if wardrobe is not None and not wardrobe.is_dir():
        raise InputError(f"{wardrobe}: no such folder; give the unpacked MakeHuman data, or leave --wardrobe out")
    if shares and wardrobe is None:
        option = next(iter(shares)).replace("_", "-")
        raise InputError(f"--{option} needs --wardrobe: heads are bare without")
    return load_casting(heads, wardrobe, Shares(**shares))


def _lights(arguments: argparse.Namespace) -> int:
    from relight_core.dataset.lighting.light_folder import read_light_folder, write_light_library
    from relight_core.evaluation.counted import counted

    check_output_file(arguments.output, (".npz",))
    if not arguments.folder.is_dir():
        raise InputError(f"{arguments.folder}: no such folder; give the folder of the panoramas")
    arrays = read_light_folder(arguments.folder)
    write_light_library(arguments.output, arrays)
    panoramas, places = len(arrays["names"]), len(set(arrays["group"].tolist()))
    say(f"{arguments.output}: {counted(panoramas, 'panorama')} of {counted(places, 'place')}")
    return 0


def _share(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value <= 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number from 0 to 1")
    return value


def _size(text: str) -> int:
    if not text.isdecimal() or int(text) < 32 or int(text) % 32:
        raise argparse.ArgumentTypeError(f"{text!r} is not a multiple of 32")
    return int(text)


_ACTIONS = {"bake": _bake, "skins": _skins, "lights": _lights, "check": _check, **STUDIES}
