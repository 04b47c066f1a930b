"""Relight photos and write them to files.

-o OUT is a file for one photo; for several, a folder (made when its name ends in a slash; results are PNG)
or a pattern in which {name} stands for the photo's name: -o 'out/{name}.exr'. The results of a.jpg and a.png are
called a-jpg and a-png. PNG, JPEG and TIFF are ready to look at; EXR holds linear radiance. Nothing is ever written
over an input.

With --json, one photo gives one object; several photos, a folder or --resume give
{"results": [...], "errors": [{"input", "error"}]}. A photo that can't be relit doesn't stop the others, but makes the
exit code 2, or 1 if that is a fault of ours.
--resume goes on where an earlier run was interrupted. Photos and results may share a folder: a file with the name of
another photo's result counts as that result and is not relit.
"""

from __future__ import annotations

import argparse
import os
import time
import warnings
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from app.cli.arguments import add_json, add_light, add_sliders, edit_from, user_name, user_path
from app.cli.outputs import (
    OPAQUE_SUFFIXES,
    check_place,
    make_folder,
    plan_outputs,
    results_among,
    unclaimed_results,
)
from app.cli.report import FileTimes, Report, relit_line, relit_record, reporting
from app.cli.session import Session, light_files
from app.cli.streams import tell
from app.engine.batch import Outcome, is_done, photos_in, relight_each, summary
from app.engine.sources import PANORAMA_SUFFIXES
from relight_core.errors import InputError
from relight_core.imaging.files import KnownFiles

if TYPE_CHECKING:
    from relight_core.lighting.environment import Environment
    from relight_core.pipeline.cache import Stage
    from relight_core.pipeline.results.relit import Relit

MATCH_LIMIT_EV = 40.0
"""Of --match-face, either way: so far apart are the darkest and the brightest that a half float holds."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of `relight render`."""
    parser.add_argument(
        "photos", metavar="PHOTO", nargs="+", type=user_path, help="a portrait photo, or a folder of them"
    )
    add_light(parser, required=True)
    add_sliders(parser)
    parser.add_argument(
        "--match-face",
        action="store_true",
        help="set the light's level so that the lit part of the face is as bright as in the photo",
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="OUT",
        type=user_name,
        required=True,
        help="file, folder/ or {name} pattern",
    )
    parser.add_argument(
        "--bits",
        type=int,
        choices=(8, 16, 32),
        default=8,
        help="bits a channel: 8 or 16 in PNG and TIFF; 32 for floats in EXR, which holds halves otherwise",
    )
    parser.add_argument(
        "--profile",
        choices=("srgb", "photo"),
        default="srgb",
        help="colours of PNG, JPEG and TIFF: sRGB, or the photo's own profile",
    )
    parser.add_argument("--resume", action="store_true", help="skip photos whose results are there and newer")
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Render every photo; returns the exit code."""
    several = len(arguments.photos) > 1 or os.path.isdir(arguments.photos[0]) or arguments.resume
    of_light = light_files(arguments.light)
    given = _photos(arguments.photos, of_light)
    results = results_among(given, arguments.output) if arguments.resume else []
    arguments.photos = [photo for photo in given if photo not in results]
    outputs = _checked_outputs(arguments, of_light)
    unclaimed = unclaimed_results(arguments.photos, outputs, results)
    with reporting(arguments.json) as report:
        for path in unclaimed:
            report.line(f"left out {path}: it has the name of a result")
        session = Session()
        light = session.light(arguments.light, arguments.meter)
        if not several:
            record, line = _render(session, light, arguments, arguments.photos[0], outputs[0])
            report.record(record)
            report.line(line)
            return 0
        return _render_each(session, light, arguments, outputs, unclaimed, report)


def _checked_outputs(arguments: argparse.Namespace, of_light: list[Path]) -> list[Path]:
    from relight_core.imaging.write import check_output

    outputs = plan_outputs(arguments.photos, arguments.output)
    if arguments.background == "transparent" and any(p.suffix.lower() in OPAQUE_SUFFIXES for p in outputs):
        raise InputError(f"{arguments.output}: JPEG holds no transparency; write .png, .tif or .exr")
    inputs = KnownFiles([*arguments.photos, *of_light])
    for output in outputs:
        check_output(output, arguments.bits)
        check_place(output, inputs, folder_is_made=_is_folder(arguments.output))
    return outputs


def _is_folder(out: str) -> bool:
    return out.endswith("/")


def _render_each(
    session: Session,
    light: Environment,
    arguments: argparse.Namespace,
    outputs: list[Path],
    left_out: list[Path],
    report: Report,
) -> int:
    def one(photo: Path, output: Path) -> tuple[dict, str]:
        return _render(session, light, arguments, photo, output)

    outcomes, written = [], []
    tasks = list(zip(arguments.photos, outputs, strict=True))
    for outcome in relight_each(tasks, one, is_done if arguments.resume else None):
        outcomes.append(outcome)
        if outcome.state == "failed":
            _tell_failure(outcome)
        elif outcome.state == "written":
            record, line = outcome.result
            written.append(record)
            report.line(line)
        elif outcome.state == "kept":
            report.line(f"kept {outcome.output}")
    failed = [outcome for outcome in outcomes if outcome.state == "failed"]
    record = {
        "results": written,
        "errors": [{"input": str(outcome.photo), "error": outcome.error} for outcome in failed],
    }
    kept = [str(outcome.output) for outcome in outcomes if outcome.state == "kept"]
    resumed = {"kept": kept, "left_out": [str(path) for path in left_out]}
    report.record(record | (resumed if arguments.resume else {}))
    if failed and len(outcomes) > 2:
        tell(f"relight render: {summary(outcomes)}")
    if any(outcome.fault for outcome in failed):
        return 1
    return 2 if failed else 0


def _tell_failure(outcome: Outcome) -> None:
    line = outcome.error
    if outcome.fault:
        line += "; RELIGHT_DEBUG=1 shows where it happened"
        if os.environ.get("RELIGHT_DEBUG") == "1":
            tell(outcome.fault)
    tell(f"relight render: {line}")


def _photos(given: list[Path], of_light: list[Path]) -> list[Path]:
    """The photos, with folders replaced by what is in them, but for the panorama that is to be the light."""
    panoramas = KnownFiles(path for path in of_light if path.suffix.lower() in PANORAMA_SUFFIXES)
    return [photo for path in given for photo in (photos_in(path, panoramas) if os.path.isdir(path) else [path])]


def _render(
    session: Session,
    light: Environment,
    arguments: argparse.Namespace,
    photo: Path,
    output: Path,
) -> tuple[dict, str]:
    """Write one photo's result; gives what `--json` says of it, and a line for people."""
    from relight_core.imaging.write import FileStyle, write_bands

    # Only the picture is written, and only in bands: no channel is looked at, no screen wants it.
    edit = session.turned(replace(edit_from(arguments), channels=()))
    opened = session.open(photo, arguments.face, arguments.box, arguments.add_box)
    relit = session.relighter.relight(light, edit, longest_side_px=0)
    if arguments.match_face:
        matched = session.relighter.relight(_matched(light, relit, photo), edit, longest_side_px=0)
        relit = replace(matched, stages=_of_both(relit.stages, matched.stages))
    if _is_folder(arguments.output):
        make_folder(output.parent)
    icc = opened.icc if arguments.profile == "photo" else None
    wide = icc is not None or output.suffix.lower() == ".exr"
    style = FileStyle(arguments.bits, exposure_ev=edit.exposure_ev, icc=icc, exif=opened.exif)
    began = time.perf_counter()
    write_bands(output, relit.full.size, relit.full.in_bands(wide=wide), relit.full.has_alpha, style)
    ended = time.perf_counter()
    after_networks_s = ended - (relit.networks_ended_s or began)
    times = FileTimes(session.opening_ms, (ended - began) * 1e3, after_networks_s * 1e3)
    return relit_record(str(photo), str(output), relit, times), relit_line(str(output), relit, edit)


def _of_both(first: dict[str, Stage], then: dict[str, Stage]) -> dict[str, Stage]:
    """What two relightings of one photo took together; what the second found ready, the first computed for it."""
    computed = {name: stage for name, stage in first.items() if stage.state == "computed"}
    return then | {
        name: replace(stage, ms=stage.ms + (then[name].ms if name in then else 0.0)) for name, stage in computed.items()
    }


def _matched(light: Environment, relit: Relit, photo: Path) -> Environment:
    """The light at the level that leaves the lit part of the face as bright as in the photo."""
    stops = relit.level_as_in_photo_ev(MATCH_LIMIT_EV)
    if abs(stops) >= MATCH_LIMIT_EV:
        warnings.warn(
            f"{photo}: --match-face changes a light by {MATCH_LIMIT_EV:g} stops at the most, "
            "which does not leave the face as bright as in the photo",
            stacklevel=2,
        )
    return light.at_level(light.level * 2.0**stops)
