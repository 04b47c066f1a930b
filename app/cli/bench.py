"""Measure what accuracy costs in time on this machine.

Every quality tier and its variants are timed in one process, in turns and in random order, from a turned light
to the maps that the window draws the picture from, and compared with the final tier on photos and, where baked test
heads and a light library are given, with the truth. Into the folder go bench.json, bench.md and bench.png.

With --session, an editing session is replayed on every photo instead (open, turn the light a full circle, drag
both sliders, swap lights), then every light of the library is visited: how many stage runs the plan avoids, what
time that saves, and the largest error that each of its rules makes. Into the folder go session.json and session.md.
The exit code is 1 if a picture is further off than the plan stated.

With --files, a photo is enlarged to 24 megapixels and relit to every kind of file, for time, memory and
size: files.json and files.md.

With --stability, hostile portraits are relit under hostile lights instead, and every error is set against its
bound: stability.json, stability.md and stability.png. The exit code is 1 if one is above it.

The networks have as many threads as in the editor. Run it on a machine that does nothing else; the load average
is part of the report.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING

from app.cli.arguments import add_json, user_path
from app.cli.maker_inputs import (
    check_heads_and_lights,
    count_at_least_one,
    counts_to,
    photos_after_option,
    progress,
    refuse_unread,
)
from app.cli.outputs import check_report, make_folder, write_report
from app.cli.report import Report, reporting
from app.cli.session import sample_portrait
from app.engine.pace import leave_a_core
from relight_core.errors import InputError
from relight_core.imaging.files import KnownFiles

if TYPE_CHECKING:
    from collections.abc import Iterator

    from relight_core.evaluation.bench_configurations import Configuration
    from relight_core.evaluation.bench_report import BenchResult
    from relight_core.evaluation.bench_session import Savings
    from relight_core.evaluation.bench_timing import Timing
    from relight_core.imaging.photo import Photo
    from relight_core.lighting.environment import Environment
    from relight_core.pipeline.relighter import Relighter

_QUICK_ROUNDS, _ROUNDS = 5, 30
_STARTS = 3
_BENCH_LIGHTS = ("rembrandt", "overcast", "golden-hour")
_COUNT, _TURNS, _QUICK_TURNS = 8, 24, 12


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of `relight bench`."""
    parser.add_argument("--quick", action="store_true", help="a minute: fewer settings and fewer rounds")
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--session", action="store_true", help="replay an editing session instead")
    instead.add_argument("--files", action="store_true", help="relight 24 megapixels from file to file instead")
    instead.add_argument("--stability", action="store_true", help="attack the pipeline instead")
    parser.add_argument(
        "--photos",
        metavar="PHOTOS",
        type=user_path,
        help="a photo or a folder of them, for --files and --stability one alone; without, the sample portrait",
    )
    parser.add_argument("--heads", metavar="DIR", type=user_path, help="test heads from relight dataset bake")
    parser.add_argument("--lights", metavar="LIGHTS", type=user_path, help="a light library, or a folder of panoramas")
    parser.add_argument("--weights", metavar="W", type=user_path, help="a .safetensors file; the bundled ones without")
    parser.add_argument("--count", metavar="N", type=count_at_least_one, help=f"test heads ({_COUNT})")
    parser.add_argument(
        "--rounds", metavar="N", type=count_at_least_one, help=f"turns of each setting, all photos together ({_ROUNDS})"
    )
    parser.add_argument("--turns", metavar="N", type=count_at_least_one, help=f"stops of a full circle ({_TURNS})")
    parser.add_argument("--device", choices=("cpu", "cuda"), default="cpu")
    parser.add_argument("-o", "--output", metavar="DIR", type=user_path, default=Path("bench"), help="a folder (bench)")
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Measure; returns the exit code."""
    _check_wishes(arguments)
    leave_a_core()
    with reporting(arguments.json) as report:
        photos = _photos(arguments.photos, arguments.files or arguments.stability)
        instead = next((name for name in ("session", "files", "stability") if getattr(arguments, name)), "bench")
        check_report(arguments.output / instead, KnownFiles(photo.path for photo in photos))
        make_folder(arguments.output)
        if arguments.files:
            return _files(arguments, photos[0], report)
        if arguments.stability:
            return _stability(arguments, photos[0], report)
        return (_session if arguments.session else _bench)(arguments, photos, report)


def _check_wishes(arguments: argparse.Namespace) -> None:
    """Raise InputError for what can't be had, and for what would be ignored."""
    for words, unread in _unread(arguments).items():
        refuse_unread(arguments, unread, words)
    if arguments.device == "cuda":
        import torch

        if not torch.cuda.is_available():
            raise InputError("--device cuda: PyTorch finds no CUDA device on this machine; take it away to use the CPU")
    if arguments.heads is not None:
        if arguments.lights is None:
            raise InputError("--heads needs --lights: the truth is rendered from both")
        check_heads_and_lights(arguments.heads, arguments.lights, "test")


def _unread(arguments: argparse.Namespace) -> dict[str, tuple[str, ...]]:
    """By the words of the command that say what is measured, the options that it does not read."""
    if arguments.files:
        return {"bench --files": ("weights", "device", "heads", "lights", "count", "turns")}
    if arguments.stability:
        return {"bench --stability": ("device", "heads", "lights", "rounds", "count", "turns")}
    if arguments.session:
        of_quick = ("lights", "turns") if arguments.quick else ()
        return {"bench --session": ("heads", "rounds", "count"), "bench --session --quick": of_quick}
    without_heads = ("lights", "count") if arguments.heads is None else ()
    of_quick = ("count",) if arguments.quick else ()
    return {"bench by itself": ("turns",), "bench without --heads": without_heads, "bench --quick": of_quick}


def _photos(place: Path | None, takes_one: bool) -> list[Photo]:
    from relight_core.imaging.read import read_photo

    if place is None:
        return [read_photo(sample_portrait())]
    paths = photos_after_option(place)
    if takes_one and len(paths) > 1:
        raise InputError(f"{place}: --files and --stability measure one photo, and there are {len(paths)} in it")
    return [read_photo(path) for path in paths]


def _bench(arguments: argparse.Namespace, photos: list[Photo], report: Report) -> int:
    from relight_core.evaluation.bench_report import as_full_record, as_markdown, as_record, plot
    from relight_core.imaging.files import whole_file

    for result in _measured(arguments, photos):
        page = as_markdown(result)
        report.figures(page, as_record(result))
        write_report(arguments.output / "bench", page, as_full_record(result))
        with whole_file(arguments.output / "bench.png") as partial:
            plot(result, partial)
    return 0


def _measured(arguments: argparse.Namespace, photos: list[Photo]) -> Iterator[BenchResult]:
    """What is known after the timing, then the same with the truth where there are heads: that takes far longer."""
    from relight_core.evaluation.bench_accuracy import Accuracy, HeldOutData, against_final, against_truth
    from relight_core.evaluation.bench_configurations import configurations
    from relight_core.evaluation.bench_machine import demands, describe_machine, measure_peaks
    from relight_core.evaluation.bench_report import BenchResult, Row
    from relight_core.lighting.rigs import load_rig
    from relight_core.networks.bundle import load_bundle
    from relight_core.pipeline.relighter import WEIGHTS, Relighter
    from relight_core.resources import resource_path

    device, quick = arguments.device, arguments.quick
    weights = arguments.weights or resource_path(*WEIGHTS)
    settings = configurations(quick=quick)
    machine = describe_machine(device) | {"first_picture_s": _first_picture_s(1 if quick else _STARTS)}
    peaks = measure_peaks(device)
    relighter, bundle = Relighter(weights, device), load_bundle(weights).for_inference().to(device)
    with progress("against final", 1.0) as show:
        lights = [load_rig(name) for name in _BENCH_LIGHTS]
        to_final = against_final(relighter, photos, lights, settings, counts_to(show))
    timing = _timed(arguments, relighter, photos, settings)
    asked = {setting.name: demands(bundle, setting.tier, device) for setting in settings}

    def result(accuracy: dict[str, Accuracy]) -> BenchResult:
        for name, error in to_final.items():
            accuracy[name].against_final = error
        return BenchResult(machine, peaks, [Row(s, timing[s.name], accuracy[s.name], asked[s.name]) for s in settings])

    yield result({setting.name: Accuracy() for setting in settings})
    if arguments.heads is not None:
        data = HeldOutData(
            arguments.heads, arguments.lights, 1 if quick else arguments.count or _COUNT, 3 if quick else 20
        )
        with progress("against the truth", 1.0) as show:
            accuracy = against_truth(bundle, data, settings, counts_to(show), device)
        yield result(accuracy)


def _timed(
    arguments: argparse.Namespace, relighter: Relighter, photos: list[Photo], settings: list[Configuration]
) -> dict[str, Timing]:
    from app.engine.screen import radiance_for_screen
    from relight_core.evaluation.bench_timing import time_configurations
    from relight_core.lighting.rigs import load_rig

    with progress("timing", 1.0) as show:
        return time_configurations(
            relighter,
            photos,
            load_rig("rembrandt"),
            settings,
            rounds=arguments.rounds or (_QUICK_ROUNDS if arguments.quick else _ROUNDS),
            display=lambda relit: relit.recipe or radiance_for_screen(relit.image, relit.alpha),
            report=counts_to(show),
            device=arguments.device,
        )


def _first_picture_s(starts: int) -> float | None:
    """Seconds from a new process to a relit picture of the sample portrait in a file; the best of several starts."""
    words = [sys.executable, "-m", "app", "render", str(sample_portrait()), "--light", "rembrandt", "--quality", "live"]
    taken = []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(starts):
            started = time.perf_counter()
            done = subprocess.run([*words, "-o", f"{folder}/{number}.png"], capture_output=True, check=False)
            if done.returncode != 0:
                return None
            taken.append(time.perf_counter() - started)
    return round(min(taken), 2)


def _files(arguments: argparse.Namespace, photo: Photo, report: Report) -> int:
    from app.cli.bench_files import as_markdown, time_files
    from relight_core.evaluation.bench_machine import describe_machine

    machine, rounds = describe_machine(), arguments.rounds or (1 if arguments.quick else _STARTS)
    with progress("files", 1.0) as show:
        found = time_files(photo, rounds, counts_to(show))
    record = {"machine": machine, "files": {kind[1:]: of for kind, of in found.items()}}
    report.figures(as_markdown(found), record)
    write_report(arguments.output / "files", as_markdown(found), record)
    return 0


def _stability(arguments: argparse.Namespace, photo: Photo, report: Report) -> int:
    from relight_core.evaluation.stability import run_stability
    from relight_core.evaluation.stability_plot import plot_stability
    from relight_core.imaging.files import whole_file

    with progress("attacking", 1.0) as show:
        result = run_stability(photo, quick=arguments.quick, weights=arguments.weights, report=counts_to(show))
    page, record = result.as_markdown(), result.as_record()
    report.figures("\n".join([page, *result.failures]), record)
    write_report(arguments.output / "stability", page + "\n", record)
    with whole_file(arguments.output / "stability.png") as partial:
        plot_stability(result, partial)
    return 1 if result.failures else 0


def _session(arguments: argparse.Namespace, photos: list[Photo], report: Report) -> int:
    are_broken = False
    for page, record in _replayed(arguments, photos):
        report.figures(page, record)
        write_report(arguments.output / "session", page, record)
        are_broken = any(of["broken"] for of in record.values() if isinstance(of, dict) and "broken" in of)
    return 1 if are_broken else 0


def _replayed(arguments: argparse.Namespace, photos: list[Photo]) -> Iterator[tuple[str, dict]]:
    """After each photo, a page and a record of all that was replayed so far."""
    from relight_core.evaluation.bench_machine import describe_machine
    from relight_core.evaluation.bench_session import Savings, recorded_session, replay, visits
    from relight_core.lighting.rigs import load_rig
    from relight_core.pipeline.relighter import Relighter

    turns = _QUICK_TURNS if arguments.quick else arguments.turns or _TURNS
    few = [load_rig(name) for name in _BENCH_LIGHTS]
    many = few if arguments.quick else _visited_lights(arguments.lights)
    plays = {"session": recorded_session(few, turns), "visits": visits(many, turns)}
    relighter, thorough = (Relighter(arguments.weights, arguments.device) for _ in range(2))
    found, machine = {name: Savings() for name in plays}, describe_machine(arguments.device)
    total = sum(map(len, plays.values())) * len(photos)

    with progress("replaying", 1.0) as show:
        show_done = counts_to(show)
        show_updates = lambda: show_done(sum(savings.updates for savings in found.values()), total)  # noqa: E731
        for number, photo in enumerate(photos, 1):
            for name, steps in plays.items():
                replay(relighter, thorough, photo, steps, found[name], report=show_updates)
            yield _session_pages(number, plays, found, machine)


def _session_pages(photos: int, plays: dict, found: dict[str, Savings], machine: dict) -> tuple[str, dict]:
    """Markdown and a JSON-ready record of what was replayed so far."""
    from relight_core.evaluation.bench_session import as_markdown
    from relight_core.evaluation.counted import counted

    page, record = "", {"machine": machine, "photos": photos}
    for name, steps in plays.items():
        lights = len({light.name for light, _ in steps})
        record[name] = {"lights": lights} | found[name].as_record()
        page += f"{name}: {counted(photos, 'photo')}, {counted(lights, 'light')}\n\n{as_markdown(found[name])}\n\n"
    return page, record


def _visited_lights(library: Path | None) -> list[Environment]:
    """The panoramas of a library or a folder, or, where none is given, the bundled rigs."""
    from relight_core.dataset.lighting.lights import read_lights
    from relight_core.lighting.environment import Environment
    from relight_core.lighting.rigs import load_rig, rig_names

    if library is None:
        return [load_rig(name) for name in rig_names()]
    lights, _ = read_lights(library)
    return [
        Environment.from_radiance(panorama, name) for panorama, name in zip(lights.panoramas, lights.names, strict=True)
    ]
