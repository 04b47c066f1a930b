"""Milliseconds of every configuration, measured in one process, in turns and in random order."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter

import numpy as np

from relight_core.evaluation.bench_configurations import Configuration
from relight_core.evaluation.bench_machine import peak_memory_mib, reset_peak_memory, wait_for
from relight_core.imaging.photo import Photo
from relight_core.lighting.environment import Environment
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.relighter import Relighter
from relight_core.pipeline.results.relit import Relit

ACTIONS = ("delight", "rotation", "slider")
"""De-lighting alone; all of an update after the light turned; all of one after a slider moved."""

_WARM_UPS = 2
_SCREEN_PX = 1600


@dataclass(frozen=True)
class Spread:
    """Milliseconds over all runs."""

    median: float
    p95: float


@dataclass
class Timing:
    """One configuration's times.

    Attributes:
        actions: by name of ACTIONS.
        stages: every stage that an update after a turn of the light runs, "delight" and "display" besides.
        memory_mib: most memory the process used while it ran; None where the system does not tell.
    """

    actions: dict[str, Spread]
    stages: dict[str, Spread]
    memory_mib: float | None


@dataclass
class _Runs:
    ms: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    stages: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    memory_mib: float | None = None


def time_configurations(
    relighter: Relighter,
    photos: Sequence[Photo],
    environment: Environment,
    configurations: Sequence[Configuration],
    *,
    rounds: int,
    display: Callable[[Relit], object] = lambda relit: None,
    report: Callable[[int, int], None] = lambda done, total: None,
    device: str = "cpu",
) -> dict[str, Timing]:
    """Time all portraits, one after the other, as one spread.

    Every configuration warms up; then in each round all of them take their turn, in a new random order, so
    that whatever else the machine does falls on all alike. No channel but the picture is looked at.

    Args:
        photos: at least one; the last stays set.
        rounds: turns of each configuration with all photos together, of each photo at least one.
        display: what a picture goes through before the viewport's shader draws it; counted with every update.

    Returns:
        by the configuration's name.
    """
    rng = np.random.default_rng(0)
    runs = {configuration.name: _Runs() for configuration in configurations}
    hand = _Hand(relighter, environment, display, device, rng)
    each = _WARM_UPS + math.ceil(rounds / len(photos))
    for place, photo in enumerate(photos):
        relighter.set_portrait(photo)
        for number in range(each):
            for index in rng.permutation(len(configurations)):
                configuration = configurations[index]
                into = runs[configuration.name] if number >= _WARM_UPS else _Runs()
                hand.turn(configuration, into)
            report(place * each + number + 1, len(photos) * each)
    return {name: _summary(found) for name, found in runs.items()}


@dataclass
class _Hand:
    """A user who turns the light by a random angle and moves a slider to a random place."""

    relighter: Relighter
    environment: Environment
    display: Callable[[Relit], object]
    device: str
    rng: np.random.Generator

    def turn(self, configuration: Configuration, runs: _Runs) -> None:
        edit = Edit(yaw_deg=float(self.rng.uniform(-180, 180)), quality=configuration.tier, channels=())
        reset_peak_memory()
        self._update(edit, runs, "rotation")
        self.relighter.forget("delight")
        opened = self.relighter.relight(self.environment, edit, _SCREEN_PX, for_shader=True)
        runs.ms["delight"].append(opened.stages["delight"].ms)
        runs.stages["delight"].append(opened.stages["delight"].ms)
        self._update(replace(edit, shadow=float(self.rng.uniform(0.1, 0.9))), runs, "slider")
        memory = peak_memory_mib(self.device)
        runs.memory_mib = None if memory is None else max(memory, runs.memory_mib or 0.0)

    def _update(self, edit: Edit, runs: _Runs, action: str) -> None:
        wait_for(self.device)
        started = perf_counter()
        relit = self.relighter.relight(self.environment, edit, _SCREEN_PX, for_shader=True)
        relit_at = perf_counter()
        self.display(relit)
        ended = perf_counter()
        # A first visit also takes the portrait apart, which is the photo's cost and not the light's.
        once = sum(stage.ms for stage in relit.stages.values() if stage.is_of_photo)
        runs.ms[action].append(1e3 * (ended - started) - once)
        if action == "rotation":
            for name, stage in relit.stages.items():
                if stage.state == "computed" and not stage.is_of_photo:
                    runs.stages[name].append(stage.ms)
            runs.stages["display"].append(1e3 * (ended - relit_at))


def _summary(runs: _Runs) -> Timing:
    return Timing(
        {name: _spread(runs.ms[name]) for name in ACTIONS},
        {name: _spread(times) for name, times in runs.stages.items()},
        runs.memory_mib,
    )


def _spread(times: list[float]) -> Spread:
    return Spread(float(np.median(times)), float(np.percentile(times, 95)))
