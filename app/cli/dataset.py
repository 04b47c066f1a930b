"""Make the training data: bake heads, check their light against a path tracer, look at samples.

relight dataset bake --heads MODEL.npz [--wardrobe FOLDER] --out DIR --split train --count N
relight dataset skins --heads MODEL.npz --wardrobe FOLDER --out DIR
relight dataset check --heads MODEL.npz [--wardrobe FOLDER] --lights FILE [--count N]
relight dataset preview --shards DIR --lights FILE -o SHEET.png

A head belongs to its seed, and every split has its own seeds, so no identity is in two splits. Baking that
was interrupted goes on where it stopped.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from app.cli.maker_inputs import (
    SPLITS,
    check_heads_and_lights,
    check_output_file,
    count_at_least_one,
    progress,
)
from app.cli.outputs import make_folder
from relight_core.errors import InputError

_COLUMNS = 12
_CELL_PX = 160


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of `relight dataset`."""
    actions = parser.add_subparsers(dest="action", metavar="bake|skins|check|preview", required=True)
    bake = actions.add_parser("bake", description="Bake heads: everything that any light needs to light them.")
    bake.add_argument("--heads", metavar="MODEL", type=Path, required=True, help="the head model, an .npz")
    bake.add_argument("--wardrobe", metavar="FOLDER", type=Path, help="unpacked MakeHuman data; heads are bare without")
    bake.add_argument("--out", metavar="DIR", type=Path, required=True, help="where the heads go")
    bake.add_argument("--split", choices=SPLITS, default="train")
    bake.add_argument("--count", metavar="N", type=count_at_least_one, required=True, help="how many heads in all")
    bake.add_argument("--size", metavar="PX", type=_size, default=256, help="side of the images (256)")
    skins = actions.add_parser("skins", description="Carry MakeHuman's skins onto the head model, beside baked heads.")
    skins.add_argument("--heads", metavar="MODEL", type=Path, required=True, help="the head model, an .npz")
    skins.add_argument("--wardrobe", metavar="FOLDER", type=Path, required=True, help="unpacked MakeHuman data")
    skins.add_argument("--out", metavar="DIR", type=Path, required=True, help="the folder of the heads")
    check = actions.add_parser("check", description="Compare baked light with a path tracer's, head by head.")
    check.add_argument("--heads", metavar="MODEL", type=Path, required=True, help="the head model, an .npz")
    check.add_argument("--wardrobe", metavar="FOLDER", type=Path, help="unpacked MakeHuman data")
    check.add_argument("--lights", metavar="FILE", type=Path, required=True, help="the light library, an .npz")
    check.add_argument("--count", metavar="N", type=count_at_least_one, default=10, help="heads (10)")
    check.add_argument("--lights-per-head", metavar="N", type=count_at_least_one, default=10, help="(10)")
    preview = actions.add_parser("preview", description="Draw every channel of samples as training sees them.")
    preview.add_argument("--shards", metavar="DIR", type=Path, required=True, help="heads that bake made")
    preview.add_argument("--lights", metavar="FILE", type=Path, required=True, help="the light library, an .npz")
    preview.add_argument("--split", choices=SPLITS, default="train")
    preview.add_argument("--count", metavar="N", type=count_at_least_one, default=8, help="samples, one in a row (8)")
    preview.add_argument("--seed", metavar="N", type=int, default=0, help="another seed draws other samples")
    preview.add_argument("-o", "--output", metavar="SHEET", type=Path, required=True, help="a .png or .jpg file")


def run(arguments: argparse.Namespace) -> int:
    """Bake, write skins, check or preview; returns the exit code."""
    return {"bake": _bake, "skins": _skins, "check": _check, "preview": _preview}[arguments.action](arguments)


def _bake(arguments: argparse.Namespace) -> int:
    from relight_core.dataset.recipe import SPLIT_SEEDS, bake_missing

    casting = _casting(arguments.heads, arguments.wardrobe)
    make_folder(arguments.out)
    if arguments.split == "train" and arguments.wardrobe is not None:
        _add_skins(casting, arguments.wardrobe, arguments.out)
    first = SPLIT_SEEDS[arguments.split]
    seeds = range(first, first + arguments.count)
    size_bytes = 0
    with progress(f"baking {arguments.split} heads", arguments.count) as show:
        for done, path in enumerate(bake_missing(casting, arguments.out, seeds, arguments.size), 1):
            size_bytes += path.stat().st_size
            show(done, f"{done} of {arguments.count}")
    print(f"{arguments.out}: {arguments.count} {arguments.split} heads, {size_bytes / 1e6:.1f} MB", flush=True)
    return 0


def _add_skins(casting, wardrobe: Path, folder: Path) -> None:
    """Write MakeHuman's skins beside the heads unless they are there or the wardrobe has none."""
    from relight_core.dataset.skin_textures import load_skins, write_skins
    from relight_core.dataset.skin_transfer import transfer_skins

    if load_skins(folder) is None:
        skins = transfer_skins(wardrobe, casting.model)
        if skins.names:
            write_skins(folder, skins)


def _skins(arguments: argparse.Namespace) -> int:
    from relight_core.dataset.skin_textures import write_skins
    from relight_core.dataset.skin_transfer import transfer_skins

    casting = _casting(arguments.heads, arguments.wardrobe)
    make_folder(arguments.out)
    skins = transfer_skins(arguments.wardrobe, casting.model)
    if not skins.names:
        raise InputError(f"{arguments.wardrobe}: no skins here; give the whole MakeHuman archive, unpacked")
    path = write_skins(arguments.out, skins)
    print(f"{path}: {len(skins.names)} skins", flush=True)
    return 0


def _check(arguments: argparse.Namespace) -> int:
    import numpy as np

    from relight_core.dataset.check import check_heads
    from relight_core.dataset.lights import load_lights, sample_light
    from relight_core.dataset.recipe import SPLIT_SEEDS

    casting = _casting(arguments.heads, arguments.wardrobe)
    library, rng = load_lights(arguments.lights, "validation"), np.random.default_rng(0)
    lights = np.stack([sample_light(library, rng) for _ in range(arguments.lights_per_head)])
    first = SPLIT_SEEDS["validation"]
    found = []
    print("| head | light | direct | bounces, without term | bounces, with term |\n|---|---|---|---|---|")
    for difference in check_heads(casting, range(first, first + arguments.count), lights):
        errors = (difference.direct, difference.without_bounce, difference.with_bounce)
        found.append(errors)
        cells = " | ".join(f"{error:.4f}" for error in errors)
        print(f"| {difference.seed} | {difference.light} | {cells} |", flush=True)
    cells = " | ".join(f"{error:.4f}" for error in np.sqrt(np.mean(np.square(found), 0)))
    print(f"| all | | {cells} |")
    return 0


def _casting(model: Path, wardrobe: Path | None):
    from relight_core.dataset.recipe import Casting

    if not model.is_file():
        raise InputError(f"{model}: no such file; give the head model's .npz after --heads")
    if wardrobe is not None and not wardrobe.is_dir():
        raise InputError(f"{wardrobe}: no such folder; give the unpacked MakeHuman data, or leave --wardrobe out")
    return Casting.load(model, wardrobe)


def _preview(arguments: argparse.Namespace) -> int:
    from app.cli.sheet import contact_sheet
    from relight_core.dataset.preview import sample_pictures
    from relight_core.imaging.photo import Photo
    from relight_core.imaging.write import write_image

    check_output_file(arguments.output, (".png", ".jpg", ".jpeg"))
    check_heads_and_lights(arguments.shards, arguments.lights, arguments.split)
    pictures = []
    with progress("drawing samples", arguments.count) as show:
        samples = sample_pictures(arguments.shards, arguments.lights, arguments.split, arguments.count, arguments.seed)
        for done, row in enumerate(samples, 1):
            pictures += row
            show(done)
    sheet = contact_sheet(pictures, _COLUMNS, _CELL_PX)
    write_image(arguments.output, Photo.from_srgb(sheet).linear)
    print(f"wrote {arguments.output}", flush=True)
    return 0


def _size(text: str) -> int:
    if not text.isdecimal() or int(text) < 32 or int(text) % 32:
        raise argparse.ArgumentTypeError(f"{text!r} is not a multiple of 32")
    return int(text)
