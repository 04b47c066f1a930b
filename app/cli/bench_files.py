"""What it takes to relight a photo of 24 megapixels from file to file: `relight bench --files`."""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image

from relight_core.errors import InputError
from relight_core.evaluation.tables import markdown_table
from relight_core.imaging.photo import Photo
from relight_core.imaging.view_transform import apply_view

_PIXELS = 24_000_000
_GRAIN_CODES = 2.0
_KINDS = (".png", ".jpg", ".tif", ".exr")
_LIGHT = "rembrandt"
_WITNESS = """
import resource, subprocess, sys, time
began = time.perf_counter()
status = subprocess.run(sys.argv[1:]).returncode
print(f"\\n{time.perf_counter() - began} {resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss}")
sys.exit(status)
"""
"""A small process that starts the program, tells its seconds and its peak: Linux counts what the process that starts a
program has ever held to that program's own peak, and the bench has held the enlarged photo."""


def time_files(photo: Photo, rounds: int, report: Callable[[int, int], None]) -> dict[str, dict[str, float]]:
    """Relight a JPEG of 24 megapixels to every kind of file, each time in a new process; kinds take turns.

    Args:
        photo: enlarged to that size, with the grain that enlarging takes away.
        rounds: how often.
        report: told how many of how many files are done.

    Returns:
        by suffix, medians: "whole_s" from the start of the program to its end, "after_networks_s" from the end of
        the last network to the file under its name, "peak_mib" of memory, "file_mb".

    Raises:
        InputError: the photo can't be relit.
    """
    found: dict[str, list[dict[str, float]]] = {kind: [] for kind in _KINDS}
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "photo.jpg"
        _enlarged(photo).save(source, quality=93)
        for number in range(rounds):
            for place, kind in enumerate(_KINDS):
                found[kind].append(_relit_once(source, Path(folder) / f"relit{kind}"))
                report(number * len(_KINDS) + place + 1, rounds * len(_KINDS))
    return {
        kind: {name: round(statistics.median(run[name] for run in runs), 2) for name in runs[0]}
        for kind, runs in found.items()
    }


def as_markdown(found: dict[str, dict[str, float]]) -> str:
    """A table of what `time_files` found."""
    titles = ("24 MP JPEG to", "whole program, s", "after the networks, s", "peak memory, MiB", "file, MB")
    forms = {"whole_s": ".1f", "after_networks_s": ".1f", "peak_mib": ".0f", "file_mb": ".0f"}
    rows = [[kind[1:].upper(), *(f"{of[name]:{form}}" for name, form in forms.items())] for kind, of in found.items()]
    return "\n".join(markdown_table(titles, rows)) + "\n"


def _enlarged(photo: Photo) -> Image.Image:
    codes = np.rint(apply_view(photo.linear) * 255).astype(np.uint8)
    scale = (_PIXELS / (codes.shape[0] * codes.shape[1])) ** 0.5
    size = tuple(round(length * scale) for length in codes.shape[1::-1])
    large = np.asarray(Image.fromarray(codes).resize(size, Image.Resampling.LANCZOS), np.float32)
    large = large + np.random.default_rng(0).standard_normal(large.shape, np.float32) * _GRAIN_CODES
    return Image.fromarray(np.clip(np.rint(large), 0, 255).astype(np.uint8))


def _relit_once(source: Path, output: Path) -> dict[str, float]:
    words = [sys.executable, "-m", "app", "render", str(source), "--light", _LIGHT, "--json", "-o", str(output)]
    try:
        said, whole_s, peak_mib = _witnessed(words)
    except subprocess.CalledProcessError:
        # Of the enlarged photo's own file, which goes with its folder, nobody knows.
        raise InputError("the photo can't be relit at 24 megapixels; choose one with a face after --photos") from None
    return {
        "whole_s": whole_s,
        "after_networks_s": json.loads(said)["after_networks_ms"] / 1e3,
        "peak_mib": peak_mib,
        "file_mb": output.stat().st_size / 1e6,
    }


def _witnessed(words: list[str]) -> tuple[str, float, float]:
    """What a program says on stdout, its seconds, and its peak of memory in MiB.

    Raises:
        subprocess.CalledProcessError: it fails.
    """
    witness = [sys.executable, "-c", _WITNESS, *words]
    done = subprocess.run(witness, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=True)
    said, _, figures = done.stdout.decode().rstrip("\n").rpartition("\n")
    seconds, peak = (float(figure) for figure in figures.split())
    return said, seconds, peak / (2**20 if sys.platform == "darwin" else 2**10)
