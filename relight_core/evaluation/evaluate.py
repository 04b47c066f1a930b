"""How good the networks are on people and lights they have never seen (paper, Table 2, "Full").

A photo of a held-out head under a held-out light is taken apart and relit with another held-out light by
the very stages that the editor runs, and every channel is compared with the true one.
"""

from __future__ import annotations

import math
import time
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from relight_core.dataset.baking.shard import shard_size
from relight_core.evaluation.bench import Bench, Editor
from relight_core.evaluation.held_out import (
    Case,
    HeldOutHead,
    HeldOutLight,
    Photos,
    cases_of,
    held_out_lights,
    held_out_paths,
    held_out_textures,
    load_head,
)
from relight_core.evaluation.metrics import Interval, interval_over_heads
from relight_core.evaluation.scoring import Figures
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import NetworkBundle
from relight_core.pipeline.quality import TIERS, Tier

Rows = list[tuple[str, Figures]]
"""The head and the figures of every picture."""


@dataclass(frozen=True)
class Settings:
    """What is evaluated.

    Attributes:
        heads: folder of baked shards.
        lights: a light library (.npz), or a folder of panoramas.
        split: "test"; "validation" for choices between variants, so that the test stays unseen.
        count: heads.
        photos: "clean" renderings on black, or through the "camera" on backgrounds.
        tier: how large the networks see a photo; the photo itself is as large as the head was baked.
    """

    heads: Path
    lights: Path
    split: str = "test"
    count: int = 8
    photos: Photos = "clean"
    tier: Tier = TIERS["final"]


@dataclass
class Evaluation:
    """Figures with their confidence intervals over heads.

    Attributes:
        figures: by group and name, such as figures["panoramas"]["relit.rmse"]. Groups: "panoramas" and
            "lamps" are the whole way from a photo over all of the head; "face" the former within the
            paper's eight regions; "true surface, ..." start from true albedo, normals and relief.
        samples: pictures in each group.
    """

    figures: dict[str, dict[str, Interval]]
    samples: dict[str, int]
    heads: int
    lights: int
    size: int
    seconds: float
    settings: Settings = field(repr=False)


class Scores(Protocol):
    """One head under test."""

    def score(self, case: Case) -> Mapping[Any, Figures]:
        """Figures of one relighting, by whatever they are told apart by."""


@dataclass(frozen=True)
class HeldOut:
    """The pictures of a split, in their order."""

    lights: list[HeldOutLight]
    paths: list[Path]

    @classmethod
    def of(cls, settings: Settings) -> HeldOut:
        """Those that settings ask for.

        Raises:
            InputError: heads or lights are missing or damaged.
        """
        lights = held_out_lights(settings.lights, settings.split)
        return cls(lights, held_out_paths(settings.heads, settings.split, settings.count))

    def scored(self, bench_of: Callable[[HeldOutHead], Scores], report: Callable[[int, int], None]) -> dict[Any, Rows]:
        """Every relighting's figures, by what its score tells them apart by.

        Args:
            report: called with the number of finished and of all relightings.
        """
        textures, done, rows = held_out_textures(), 0, defaultdict(list)
        total = sum(len(cases_of(number, self.lights)) for number in range(len(self.paths)))
        for number, path in enumerate(self.paths):
            head = load_head(path, self.lights, textures)
            bench = bench_of(head)
            for case in cases_of(number, self.lights):
                for place, figures in bench.score(case).items():
                    rows[place].append((head.name, figures))
                done += 1
                report(done, total)
        return rows


def evaluate(
    bundle: NetworkBundle,
    settings: Settings,
    report: Callable[[int, int], None] = lambda done, total: None,
) -> Evaluation:
    """Measure networks on a held-out split.

    Args:
        bundle: made ready by `for_inference`.
        report: called with the number of finished and of all relightings.

    Raises:
        InputError: heads or lights are missing or damaged.
    """
    started = time.monotonic()
    held_out = HeldOut.of(settings)
    editor = Editor(bundle, ReflectionTable(), settings.tier, "cpu")
    bench_of = lambda head: Bench(editor, head, held_out.lights, settings.photos)  # noqa: E731
    rows = held_out.scored(bench_of, report)
    intervals = {group: intervals_over_heads(scored) for group, scored in rows.items()}
    samples = {group: len(scored) for group, scored in rows.items()}
    panoramas, size = sum(not light.lamp for light in held_out.lights), shard_size(held_out.paths[-1])
    seconds = time.monotonic() - started
    return Evaluation(intervals, samples, len(held_out.paths), panoramas, size, seconds, settings)


def intervals_over_heads(rows: Rows) -> dict[str, Interval]:
    """Means of every figure with their confidence intervals, and errors relative to a channel's own size.

    Args:
        rows: the head and the figures of every picture; all have the same names.
    """
    heads = np.array([head for head, _ in rows])
    intervals: dict[str, Interval] = {}
    for name in rows[0][1]:
        values = np.array([figures[name] for _, figures in rows])
        if name.endswith(".rmse") and name.replace(".rmse", ".true_power") in rows[0][1]:
            intervals[name.replace(".rmse", ".relative")] = _relative(rows, heads, name.removesuffix(".rmse"))
        if not name.endswith("_power"):
            intervals[name] = interval_over_heads(values, heads)
    return {name: interval.within(*_possible(name)) for name, interval in intervals.items()}


def _possible(name: str) -> tuple[float, float]:
    """Between which values a figure lies, whatever the pictures: an interval over two or three heads reaches far."""
    return (-1.0, 1.0) if name.partition(".")[2].startswith("ssim") else (0.0, math.inf)


def _relative(rows: Rows, heads: np.ndarray, channel: str) -> Interval:
    """RMSE over the channel's own root mean square, both pooled over a head's pictures; 1 is "none seen"."""
    names = np.unique(heads)
    error, true = (
        np.array([np.mean([f[f"{channel}.{kind}"] for h, f in rows if h == head]) for head in names])
        for kind in ("error_power", "true_power")
    )
    return interval_over_heads(np.sqrt(error / np.maximum(true, 1e-12)), names)
