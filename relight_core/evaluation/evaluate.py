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
import torch

from relight_core.evaluation.held_out import (
    HeldOutHead,
    HeldOutLight,
    Photos,
    cases_of,
    held_out_lights,
    held_out_paths,
    held_out_textures,
    load_head,
)
from relight_core.evaluation.metrics import Interval, bootstrap_interval
from relight_core.evaluation.scoring import (
    Figures,
    as_image,
    score_effects,
    score_relit,
    score_surface,
    score_unchanged,
    true_surface,
)
from relight_core.face.parsing import INDEX, PAPER_CLASSES
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import NetworkBundle
from relight_core.pipeline import stages

RELIEF_SIZE = 64
"""As in the editor's "live" quality, at which the networks see 256 pixels."""


@dataclass(frozen=True)
class Settings:
    """What is evaluated.

    Attributes:
        heads: folder of baked shards.
        lights: the light library (.npz).
        split: "test"; "validation" for choices between variants, so that the test stays unseen.
        count: heads.
        photos: "clean" renderings on black, or through the "camera" on backgrounds.
    """

    heads: Path
    lights: Path
    split: str = "test"
    count: int = 8
    photos: Photos = "clean"
    relief_size: int = RELIEF_SIZE


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

    def add(self, group: str, head: str, *parts: Figures) -> None:
        self._rows[group].append((head, {name: value for part in parts for name, value in part.items()}))

    def samples(self) -> dict[str, int]:
        return {group: len(rows) for group, rows in self._rows.items()}

    def intervals(self) -> dict[str, dict[str, Interval]]:
        return {group: _intervals(rows) for group, rows in self._rows.items()}


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
        bench = _Bench(bundle, table, settings, head, lights, device)
        for case in cases_of(number, lights):
            bench.run(case.source, case.target, tally)
            done += 1
            report(done, total)
    panoramas = sum(not light.lamp for light in lights)
    seconds = time.monotonic() - started
    return Evaluation(tally.intervals(), tally.samples(), len(paths), panoramas, size, seconds, settings)


class _Bench:
    """One head under test; a photo is taken apart once, however many lights it is relit with."""

    def __init__(
        self,
        bundle: NetworkBundle,
        table: ReflectionTable,
        settings: Settings,
        head: HeldOutHead,
        lights: list[HeldOutLight],
        device: str,
    ):
        self._bundle, self._table, self._settings, self._device = bundle, table, settings, device
        self._head, self._lights, self._truth = head, lights, head.surface()
        self._covered = head.lit.head.covered
        labels = [INDEX[name] for name in PAPER_CLASSES]
        self._face = self._covered & np.isin(self._truth["label"], labels)
        self._found: dict[int, tuple] = {}
        perfect = true_surface(self._truth, np.zeros((*self._covered.shape, 3)), lights[0].radiance)
        self._perfect = stages.Surface(**{name: value.to(device) for name, value in vars(perfect).items()})
        self._perfect_relief = stages.march(self._perfect, settings.relief_size)

    def run(self, source: int, target: int, tally: _Tally) -> None:
        """Score one relighting, on the whole way and from the true surface."""
        photo, surface, relief = self._take_apart(source)
        truth, covered, name = self._head.channels(target), self._covered, self._head.name
        gain = self._head.exposure(target)
        group = "lamps" if self._lights[target].lamp else "panoramas"
        effects, relit = self._relight(surface, relief, target)
        of_surface = score_surface(surface, self._truth, self._lights[source].radiance, covered)
        tally.add(
            group,
            name,
            of_surface,
            score_effects(effects, truth, covered),
            score_relit(relit, truth["image"], gain, covered, covered),
            score_unchanged(photo, truth["image"], gain, covered, covered),
        )
        if group == "panoramas" and self._face.any():
            tally.add(
                "face",
                name,
                score_surface(surface, self._truth, self._lights[source].radiance, self._face),
                score_effects(effects, truth, self._face),
                score_relit(relit, truth["image"], gain, covered, self._face),
            )
        effects, relit = self._relight(self._perfect, self._perfect_relief, target)
        tally.add(
            f"true surface, {group}",
            name,
            score_effects(effects, truth, covered),
            score_relit(relit, truth["image"], gain, covered, covered),
        )

    def _take_apart(self, source: int):
        if source not in self._found:
            photo = self._head.photo(source, self._settings.photos)
            surface = stages.delight(self._bundle, photo, self._device)
            self._found[source] = photo, surface, stages.march(surface, self._settings.relief_size)
        return self._found[source]

    def _relight(self, surface: stages.Surface, relief, target: int):
        """The editor's stages: effects and the relit image (S, S, 3) in units of the normalised light."""
        light = torch.from_numpy(self._lights[target].radiance)[None].to(self._device)
        reflected = stages.reflect(self._table, surface, light)
        effects = stages.estimate_effects(self._bundle, surface, reflected, relief, light, self._device)
        composed = stages.compose(self._bundle, surface, reflected, effects, light, self._device)
        return effects, as_image(composed.image)


def _intervals(rows: list[tuple[str, Figures]]) -> dict[str, Interval]:
    heads = np.array([head for head, _ in rows])
    intervals = {}
    for name in rows[0][1]:
        values = np.array([figures[name] for _, figures in rows])
        if name.endswith(".rmse") and name.replace(".rmse", ".true_power") in rows[0][1]:
            intervals[name.replace(".rmse", ".relative")] = _relative(rows, heads, name.removesuffix(".rmse"))
        if not name.endswith("_power"):
            intervals[name] = bootstrap_interval(values, heads)
    return intervals


def _relative(rows: list[tuple[str, Figures]], heads: np.ndarray, channel: str) -> Interval:
    """RMSE over the channel's own root mean square, both pooled over a head's pictures; 1 is "none seen"."""
    names = np.unique(heads)
    error, true = (
        np.array([np.mean([f[f"{channel}.{kind}"] for h, f in rows if h == head]) for head in names])
        for kind in ("error_power", "true_power")
    )
    return bootstrap_interval(np.sqrt(error / np.maximum(true, 1e-12)), names)
