"""Which headwear there is, how often each kind is worn, and what hair it leaves to be seen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from relight_core.dataset.garments.garment import Garment
from relight_core.dataset.garments.garment_binding import HeadSurface
from relight_core.dataset.garments.hair_shell import ScalpGrid
from relight_core.dataset.garments.headwear import caps, ornaments, soft_hats
from relight_core.dataset.garments.headwear.drapes import sample_drape, wrap_head
from relight_core.dataset.garments.headwear.ring import HatRing, fit_ring
from relight_core.dataset.garments.headwear.stiff_hats import STIFF_HATS, make_stiff_hat, sample_shape

_SOFT = {
    "beanie": soft_hats.knit_beanie,
    "brimmed": soft_hats.brimmed_hat,
    "turban": soft_hats.turban,
    "bandana": soft_hats.bandana,
    "fur hat": soft_hats.fur_hat,
}
_RINGED: dict[str, Callable[..., list[Garment]]] = {
    "peaked cap": caps.peaked_cap,
    "flat cap": caps.flat_cap,
    "beret": caps.beret,
    "sun visor": caps.sun_visor,
    "mortarboard": caps.mortarboard,
    "headband": ornaments.headband,
    "crown": ornaments.crown,
    "wreath": ornaments.wreath,
    "feathers": ornaments.feathers,
}
_DRAPES = ("headscarf", "hood", "balaclava", "helmet", "face helmet")
_OPEN = ("sun visor", "headband", "crown", "wreath", "headphones")
_SHARES = {
    "beanie": 0.09, "brimmed": 0.13, "turban": 0.05, "bandana": 0.04, "fur hat": 0.03,
    "stiff": 0.28,
    "peaked cap": 0.05, "flat cap": 0.03, "beret": 0.03, "sun visor": 0.01, "mortarboard": 0.03,
    "headband": 0.03, "crown": 0.02, "wreath": 0.02, "feathers": 0.03, "headphones": 0.02,
    "headscarf": 0.06, "hood": 0.025, "balaclava": 0.01, "helmet": 0.01, "face helmet": 0.005,
}  # fmt: skip
HEADWEAR = (*(name for name in _SHARES if name != "stiff"), *STIFF_HATS)
"""Names of all kinds."""


@dataclass(frozen=True)
class Headwear:
    """What is worn on one head.

    Attributes:
        kind: one of `HEADWEAR`.
        garments: its parts.
        hides_hair: nothing of the hair is to be seen.
        presses: all hair under it lies flat, not only where a band runs.
        ring: where it sits; None where it follows the scalp.
    """

    kind: str
    garments: list[Garment]
    hides_hair: bool
    presses: bool
    ring: HatRing | None = None

    def ceiling_cm(self, hair: np.ndarray) -> np.ndarray:
        """How far hair (N, 3) may stand from the skin."""
        if not self.presses:
            away = np.abs(hair[:, 2]) if self.ring is None else np.abs(self.ring.local(hair)[:, 1])
            return 0.6 + np.maximum(away - 3, 0)
        below = 3 - hair[:, 1] if self.ring is None else -self.ring.local(hair)[:, 1]
        return 0.25 + 0.6 * np.maximum(below, 0)


def sample_kind(rng: np.random.Generator) -> str:
    """One of `HEADWEAR`, by how often each is to be seen."""
    shares = np.array(list(_SHARES.values()))
    kind = str(rng.choice(list(_SHARES), p=shares / shares.sum()))
    return str(rng.choice(STIFF_HATS)) if kind == "stiff" else kind


def put_on(kind: str, head: np.ndarray, ears: np.ndarray, grid: ScalpGrid, skin: HeadSurface, rng) -> Headwear:
    """Headwear of a kind on a head.

    Args:
        head: (V, 3) vertices of the head model.
        ears: (2, 3) middles of the ears' outer sides.
        grid, skin: the scalp's grid, and the skin's surface on this head.
    """
    if kind in _SOFT:
        return Headwear(kind, [_SOFT[kind](grid, head, skin, rng)], False, True)
    if kind in _DRAPES:
        return Headwear(kind, wrap_head(skin.points, skin, sample_drape(kind, rng), rng), True, True)
    if kind == "headphones":
        return Headwear(kind, ornaments.headphones(ears, float(head[:, 1].max()) + 0.8, rng), False, False)
    ring = _sample_ring(kind, grid, head, rng)
    if kind in _RINGED:
        garments = _RINGED[kind](ring, skin, rng)
    else:
        garments = make_stiff_hat(ring, skin, sample_shape(kind, rng), rng)
    return Headwear(kind, garments, False, kind not in _OPEN, ring)


def _sample_ring(kind: str, grid: ScalpGrid, head: np.ndarray, rng: np.random.Generator) -> HatRing:
    """Low over the brows or pushed back, a little askew; a cone rests on a wide ring of its own.

    A mortarboard's band lies at the hairline and low at the back, so that the board is seen from below.
    """
    front = rng.uniform(55, 70) if rng.random() < 0.8 else rng.uniform(45, 56)
    back = rng.uniform(88, 104) - (8 if front < 56 else 0)
    roll = rng.normal(0, 4) if rng.random() < 0.8 else rng.uniform(-14, 14)
    ease = rng.uniform(0.7, 1.1)
    if kind == "cone":
        return fit_ring(grid, head, rng.uniform(48, 60), rng.uniform(70, 85), roll / 2, rng.uniform(2.5, 4.5))
    if kind == "mortarboard":
        front, back = rng.uniform(36, 58), rng.uniform(94, 114)
    if kind in ("headband", "crown", "wreath"):
        return fit_ring(grid, head, rng.uniform(40, 64), rng.uniform(70, 100), roll / 2, ease + rng.uniform(0, 0.6))
    return fit_ring(grid, head, front, back, roll, ease)
