"""Which quality tier to use: the user's, or the most accurate one that keeps up with the hand."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from relight_core.imaging.view_transform import apply_view
from relight_core.lighting.environment import Environment
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.quality import TIERS

AUTO = "auto"
FRAME_BUDGET_MS = 33.0

_AT_REST, _UNMEASURED = "final", "live"
_YAWS_DEG = (-70.0, 40.0, 150.0, -130.0, 100.0)
_COMPARED = 2
_PREVIEW_PX = 1600


@dataclass(frozen=True)
class TierCost:
    """What a tier costs on this machine.

    Attributes:
        ms: median of an update after the light turned.
        error: RMSE of its pictures against the final tier's, of displayed values in [0, 1].
    """

    ms: float
    error: float


@dataclass(frozen=True)
class QualityChoice:
    """What the user wants.

    Attributes:
        wish: "auto" or a tier's name.
        budget_ms: what an update may take while the hand moves.
    """

    wish: str = AUTO
    budget_ms: float = FRAME_BUDGET_MS

    def at_rest(self) -> str:
        """The tier when nothing moves."""
        return _AT_REST if self.wish == AUTO else self.wish

    def surface_of(self) -> str | None:
        """The tier whose surface serves while the hand moves, where it is known: that of the picture at rest."""
        return _AT_REST if self.wish == AUTO else None

    def moving(self, costs: Mapping[str, TierCost]) -> str:
        """The tier while the hand moves: the most accurate within the budget, else the quickest.

        Args:
            costs: of the tiers that were measured; of none, and "live" has to do.
        """
        if self.wish != AUTO:
            return self.wish
        known = {name: costs[name] for name in TIERS if name in costs}
        if not known:
            return _UNMEASURED
        fitting = {name: cost for name, cost in known.items() if cost.ms <= self.budget_ms}
        if fitting:
            return min(fitting, key=lambda name: (fitting[name].error, fitting[name].ms))
        return min(known, key=lambda name: known[name].ms)


class Relights(Protocol):
    """The part of the Relighter that is measured."""

    def relight(
        self, environment: Environment, edit: Edit, longest_side_px: int | None = None, *, for_shader: bool = False
    ): ...

    def forget_lights(self) -> None: ...


class Calibration:
    """Measures the tiers on the portrait that is open, one tier a step, so that nobody waits long.

    All of them on the surface of the picture at rest, as "auto" uses them, and under one light: a tier's error is
    told by pictures of the same. Of another portrait another calibration has to be begun.
    """

    def __init__(self) -> None:
        self._begin(None)

    def _begin(self, light: Environment | None) -> None:
        self._light = light
        self._costs: dict[str, TierCost] = {}
        self._references: list[np.ndarray] = []
        self._pending = sorted(TIERS, key=lambda name: name != _AT_REST)

    @property
    def costs(self) -> dict[str, TierCost] | None:
        """What every tier costs, once all are measured."""
        return None if self._pending else dict(self._costs)

    def measure_next(self, relighter: Relights, environment: Environment) -> None:
        """Measure one more tier: one update to prepare it, then one for each of five angles.

        Under another light than the tier before, all of them are measured anew. Of no update is anything found in
        the caches: not where the light looks the same however it is turned, nor where the hand had turned it there.
        """
        if environment is not self._light:
            self._begin(environment)
        name = self._pending[0]
        prepared = Edit(quality=name, channels=(), surface_of=_AT_REST)
        relighter.relight(environment, prepared, _PREVIEW_PX, for_shader=True)
        times, pictures = [], []
        for yaw_deg in _YAWS_DEG:
            edit = replace(prepared, yaw_deg=yaw_deg, tolerance=0.0)
            relighter.forget_lights()
            started = time.perf_counter()
            relighter.relight(environment, edit, _PREVIEW_PX, for_shader=True)
            times.append(1e3 * (time.perf_counter() - started))
            if len(pictures) < _COMPARED:
                pictures.append(apply_view(relighter.relight(environment, edit, _PREVIEW_PX).image))
        if name == _AT_REST:
            self._references = pictures
        squares = [np.mean((a - b) ** 2) for a, b in zip(pictures, self._references, strict=True)]
        self._costs[name] = TierCost(float(np.median(times)), float(np.sqrt(np.mean(squares))))
        self._pending.remove(name)
        if not self._pending:
            self._references = []
