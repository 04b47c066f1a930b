"""How good the networks are on people and lights they have never seen (paper, Table 2, "Full").

A photo of a held-out head under a held-out light is taken apart and relit with another held-out light by
the very stages that the editor runs, and every channel is compared with the true one.
"""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from relight_core.evaluation.bench import Bench, Editor
from relight_core.evaluation.held_out import (
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


@dataclass(frozen=True)
class Settings:
    """What is evaluated.

    Attributes:
        heads: folder of baked shards.
        lights: the light library (.npz).
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


class _Tally:
    """Figures of every picture, by group, and whose picture it is."""

    def __init__(self) -> None:
        self._rows: dict[str, list[tuple[str, Figures]]] = defaultdict(list)

    def add(self, group: str, head: str, figures: Figures) -> None:
        self._rows[group].append((head, figures))

    def samples(self) -> dict[str, int]:
        return {group: len(rows) for group, rows in self._rows.items()}

    def intervals(self) -> dict[str, dict[str, Interval]]:
        return {group: intervals_over_heads(rows) for group, rows in self._rows.items()}


def evaluate(
    bundle: NetworkBundle,
    settings: Settings,
    report: Callable[[int, int], None] = lambda done, total: None,
    device: str = "cpu",
) -> Evaluation:
    """Measure networks on a held-out split.

    Args:
        bundle: made ready by `for_inference`, on `device`.
        report: called with the number of finished and of all relightings.

    Raises:
        InputError: heads or lights are missing or damaged.
    """
    started = time.monotonic()
    lights = held_out_lights(settings.lights, settings.split)
    paths = held_out_paths(settings.heads, settings.split, settings.count)
    table, tally, textures = ReflectionTable().to(device), _Tally(), held_out_textures()
    total, done, size = sum(len(cases_of(n, lights)) for n in range(len(paths))), 0, 0
    for number, path in enumerate(paths):
        head = load_head(path, lights, textures)
        size = head.lit.head.size
        bench = Bench(Editor(bundle, table, settings.tier, device), head, lights, settings.photos)
        for case in cases_of(number, lights):
            for group, figures in bench.score(case).items():
                tally.add(group, head.name, figures)
            done += 1
            report(done, total)
    panoramas = sum(not light.lamp for light in lights)
    seconds = time.monotonic() - started
    return Evaluation(tally.intervals(), tally.samples(), len(paths), panoramas, size, seconds, settings)


def intervals_over_heads(rows: list[tuple[str, Figures]]) -> dict[str, Interval]:
    """Means of every figure with their confidence intervals, and errors relative to a channel's own size.

    Args:
        rows: the head and the figures of every picture; all have the same names.
    """
    heads = np.array([head for head, _ in rows])
    intervals = {}
    for name in rows[0][1]:
        values = np.array([figures[name] for _, figures in rows])
        if name.endswith(".rmse") and name.replace(".rmse", ".true_power") in rows[0][1]:
            intervals[name.replace(".rmse", ".relative")] = _relative(rows, heads, name.removesuffix(".rmse"))
        if not name.endswith("_power"):
            intervals[name] = interval_over_heads(values, heads)
    return intervals


def _relative(rows: list[tuple[str, Figures]], heads: np.ndarray, channel: str) -> Interval:
    """RMSE over the channel's own root mean square, both pooled over a head's pictures; 1 is "none seen"."""
    names = np.unique(heads)
    error, true = (
        np.array([np.mean([f[f"{channel}.{kind}"] for h, f in rows if h == head]) for head in names])
        for kind in ("error_power", "true_power")
    )
    return interval_over_heads(np.sqrt(error / np.maximum(true, 1e-12)), names)
