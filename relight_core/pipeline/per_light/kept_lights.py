"""The lights whose results are cached, for finding one that is nearly equal to a new light."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable
from dataclasses import dataclass, field

import numpy as np

from relight_core.lighting.lamps import Lamp
from relight_core.pipeline.plan import displayed_change, light_change


@dataclass(frozen=True, eq=False)
class ServingLight:
    """The light that results are computed for, which may differ slightly from the requested one.

    Attributes:
        name: a key made from its contents.
        radiance: (16, 32, 3) normalised.
        bound: on the difference of a displayed value in [0, 1] from that under the requested light.
        lamps: the small lamps of the requested light.
    """

    name: Hashable
    radiance: np.ndarray
    bound: float
    lamps: tuple[Lamp, ...] = ()


@dataclass
class KeptLights:
    """The newest lights of every group. Results of a group were computed in the same way.

    Attributes:
        most: lights kept in a group.
    """

    most: int
    _groups: dict[Hashable, OrderedDict[bytes, np.ndarray]] = field(default_factory=dict)

    def clear(self) -> None:
        """Forget all lights."""
        self._groups.clear()

    def match(self, group: Hashable, light: np.ndarray, tolerance: float) -> ServingLight:
        """The light to compute results for: the same if it is kept, else the nearest within the tolerance, else itself.

        Nothing is kept by this. Kept results belong to the light they were computed for, so small changes don't add up.

        Args:
            group: to search in.
            light: (16, 32, 3) normalised radiance.
            tolerance: of displayed values in [0, 1].
        """
        lights, name = self._groups.get(group, {}), light.tobytes()
        if name not in lights:
            changes = {kept: displayed_change(light_change(other, light)) for kept, other in lights.items()}
            nearest = min(changes, key=changes.get, default=None)
            if nearest is not None and changes[nearest] <= tolerance:
                return ServingLight(nearest, lights[nearest], changes[nearest])
        return ServingLight(name, light.copy(), 0.0)

    def keep(self, group: Hashable, serving: ServingLight) -> None:
        """Keep a light, whose results are about to be computed, as the newest of its group."""
        lights = self._groups.setdefault(group, OrderedDict())
        lights[serving.name] = serving.radiance
        lights.move_to_end(serving.name)
        while len(lights) > self.most:
            lights.popitem(last=False)
