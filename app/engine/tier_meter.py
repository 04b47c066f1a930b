"""What the quality tiers cost here: measured once, kept between runs, and corrected by every picture."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from statistics import median

from app.engine.calibration_file import machine_key, read_costs, write_costs
from app.engine.snapshot import Snapshot
from app.engine.sources import RelighterLike
from relight_core.lighting.environment import Environment
from relight_core.pipeline.auto_quality import Calibration, TierCost
from relight_core.pipeline.cache import computed_ms

_OBSERVED, _ENOUGH = 15, 5
"""How many of a tier's last pictures are remembered, and from how many on their median counts."""

_ANSWER_A_LIGHT = ("irradiance", "specular_shadow", "compose")
"""The stages that run anew for every new light. Under one that was seen before only the first does, which keeps the
fewest results; at a strength of 0 there is nothing for the second to find."""

_TAKE_APART = ("delight", "other_faces_delight")
"""A photo costs these once, and no light costs them again."""


class TierMeter:
    """Used by the engine's thread only.

    Args:
        path: where costs are kept; None neither measures nor keeps any.
    """

    def __init__(self, path: Path | None) -> None:
        self._path = path
        self._kept: Mapping[str, TierCost] | None = None
        self._calibration: Calibration | None = None
        self._observed: dict[str, deque[float]] = {}

    def read(self) -> None:
        """Take over what was measured in an earlier run, else begin to measure."""
        if self._path is None or self._calibration is not None or self._kept is not None:
            return
        self._kept = read_costs(self._path, machine_key())
        if self._kept is None:
            self._calibration = Calibration()

    @property
    def is_due(self) -> bool:
        """Whether a tier is still to be measured."""
        return self._calibration is not None

    def measure_next(self, relighter: RelighterLike, environment: Environment) -> None:
        """Measure one tier."""
        self._calibration.measure_next(relighter, environment)
        costs = self._calibration.costs
        if costs is not None:
            self._kept, self._calibration = costs, None
            write_costs(self._path, machine_key(), costs)

    def give_up(self, now: Snapshot) -> Snapshot:
        """Measure no more in this run."""
        self._calibration = None
        return now

    def observe(self, quality: str, stages: Mapping) -> None:
        """Learn from a picture whose light was new; `stages` as in Relit."""
        computed = {name for name, stage in stages.items() if stage.state == "computed"}
        if not computed.issuperset(_ANSWER_A_LIGHT) or not computed.isdisjoint(_TAKE_APART):
            return
        self._observed.setdefault(quality, deque(maxlen=_OBSERVED)).append(computed_ms(stages))

    def begin_again(self) -> None:
        """With other faces in sight, what is being measured is measured anew: its pictures show the ones before."""
        if self._calibration is not None:
            self._calibration = Calibration()

    def forget_photo(self) -> None:
        """Another photo has another size: what was observed no longer holds."""
        self._observed.clear()

    def costs(self) -> dict[str, TierCost]:
        """What each tier costs: as measured, or as seen lately with this photo."""
        return {name: self._corrected(name, cost) for name, cost in (self._kept or {}).items()}

    def _corrected(self, name: str, cost: TierCost) -> TierCost:
        seen = self._observed.get(name, ())
        return replace(cost, ms=float(median(seen))) if len(seen) >= _ENOUGH else cost
