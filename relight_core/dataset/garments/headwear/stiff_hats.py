"""Hats with a crown and a brim that keep a shape of their own: swept around the ring they sit on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from relight_core.dataset.garments.garment import Garment
from relight_core.dataset.garments.garment_binding import HeadSurface
from relight_core.dataset.garments.garment_mesh import fractal, smoothstep
from relight_core.dataset.garments.headwear.ring import AZIMUTH_DEG, COLUMNS, HatRing, cut, sheet

_CROWN_ROWS, _BRIM_ROWS, _BAND_ROWS = 36, 18, 5
_OVER_SKIN_CM = 0.35


@dataclass(frozen=True)
class HatShape:
    """One make of hat, in cm.

    Attributes:
        crown_cm: height, at least what the skull needs.
        roundness: exponent of the crown's superellipse: 1 a cone, 2 a dome, 9 a cylinder.
        taper: how much wider (or, negative, narrower) the crown's top is than its foot, as a share.
        crease_cm, pinch: depth of the furrow along the crown's top; of the dents at its front, as a share.
        front_cm, side_cm, back_cm: width of the brim.
        dip: how far the brim falls for each cm outward.
        curl_cm: how far the brim's edge is turned up at `corners` places around it; 0 corners: all round.
        wave_cm: unevenness of the brim.
        slump_cm: unevenness of the crown, as of soft cloth.
    """

    crown_cm: float
    roundness: float
    taper: float = 0.0
    crease_cm: float = 0.0
    pinch: float = 0.0
    front_cm: float = 0.0
    side_cm: float = 0.0
    back_cm: float = 0.0
    dip: float = 0.0
    curl_cm: float = 0.0
    corners: int = 0
    wave_cm: float = 0.0
    slump_cm: float = 0.08


# Ranges by attribute; a plain number is fixed. A brim's three widths are one draw, each varied a little.
_MAKES: dict[str, dict[str, tuple[float, float] | float]] = {
    "fedora": {"crown_cm": (9, 13), "roundness": (3, 5), "taper": (-0.18, -0.05), "crease_cm": (1, 3),
               "pinch": (0.05, 0.2), "brim_cm": (4.5, 8), "dip": (-0.1, 0.35), "curl_cm": (0, 1.5), "corners": 2},
    "cowboy": {"crown_cm": (10, 14), "roundness": (3, 5), "taper": (-0.2, -0.08), "crease_cm": (2, 4),
               "pinch": (0.1, 0.25), "brim_cm": (8, 12), "dip": (0.0, 0.3), "curl_cm": (3, 7), "corners": 2},
    "sun hat": {"crown_cm": (8, 11), "roundness": (2.2, 3.5), "taper": (-0.1, 0.0), "brim_cm": (9, 19),
                "dip": (-0.1, 0.55), "wave_cm": (0.2, 2.2), "slump_cm": (0.1, 0.5)},
    "straw hat": {"crown_cm": (8, 11), "roundness": (2.5, 6), "taper": (-0.12, 0.0), "brim_cm": (6, 13),
                  "dip": (-0.1, 0.3), "wave_cm": (0.0, 0.5)},
    "top hat": {"crown_cm": (12, 19), "roundness": 9, "taper": (-0.05, 0.1), "brim_cm": (4, 6),
                "curl_cm": (0.5, 2.5), "corners": 2},
    "bowler": {"crown_cm": (9, 12), "roundness": (2.1, 2.8), "brim_cm": (3, 5), "curl_cm": (0.5, 2)},
    "boater": {"crown_cm": (8, 10), "roundness": 9, "brim_cm": (5, 8), "dip": (-0.05, 0.1)},
    "bucket": {"crown_cm": (8, 10), "roundness": (3.5, 7), "taper": (-0.2, -0.05), "brim_cm": (4.5, 8),
               "dip": (0.6, 1.4), "wave_cm": (0.0, 0.6), "slump_cm": (0.1, 0.4)},
    "sombrero": {"crown_cm": (12, 19), "roundness": (1.8, 2.6), "taper": (-0.2, 0.0), "brim_cm": (14, 22),
                 "dip": (0.0, 0.3), "curl_cm": (2, 8)},
    "tricorne": {"crown_cm": (8, 10), "roundness": (2.2, 3), "brim_cm": (8, 11), "curl_cm": (6, 10), "corners": 3},
    "cone": {"crown_cm": (14, 19), "roundness": 1.25, "brim_cm": (7, 14), "dip": (0.5, 0.9)},
    "fez": {"crown_cm": (9, 14), "roundness": 9, "taper": (-0.25, 0.0)},
    "pillbox": {"crown_cm": (8, 9), "roundness": 9, "taper": (-0.05, 0.15)},
    "toque": {"crown_cm": (14, 24), "roundness": (2.5, 4), "taper": (0.1, 0.5), "slump_cm": (0.6, 1.6)},
}  # fmt: skip
STIFF_HATS = tuple(_MAKES)
"""Names of the makes."""


def sample_shape(name: str, rng: np.random.Generator) -> HatShape:
    """A hat of one of `STIFF_HATS`."""
    drawn = {key: rng.uniform(*value) if isinstance(value, tuple) else value for key, value in _MAKES[name].items()}
    brim = drawn.pop("brim_cm", 0.0)
    widths = {side: brim * rng.uniform(0.85, 1.15) for side in ("front_cm", "side_cm", "back_cm")}
    return HatShape(**drawn, **widths)


def make_stiff_hat(ring: HatRing, skin: HeadSurface, shape: HatShape, rng: np.random.Generator) -> list[Garment]:
    """Crown and brim in one piece, at times with a band and a badge."""
    foot = ring.radius
    brim = _brim(ring, foot, shape, rng)
    radius, height = _crown(ring, foot, shape)
    crown = ring.place(radius, height)
    flat = crown.reshape(-1, 3)
    bulge = fractal(flat, rng, 7.0, 3).reshape(height.shape) * shape.slump_cm * smoothstep(0, 4, height)
    crown = ring.place(radius + bulge, height + 0.5 * bulge)
    crown = skin.push_out(crown.reshape(-1, 3), _OVER_SKIN_CM).reshape(crown.shape)
    worn = [sheet(np.concatenate([brim, crown]) if shape.front_cm > 0 else crown, "hat")]
    if rng.random() < 0.6:
        worn.append(band(ring, crown, rng.uniform(1.2, 4.5)))
    if rng.random() < 0.2:
        worn.append(badge(ring, crown, rng))
    return worn


def _crown(ring: HatRing, foot: np.ndarray, shape: HatShape) -> tuple[np.ndarray, np.ndarray]:
    """Radius and height (rows, COLUMNS + 1) from the foot to the middle of the top."""
    total = max(shape.crown_cm, ring.top_cm + 0.8 + 0.8 * shape.crease_cm)
    angle = np.linspace(0, np.pi / 2, _CROWN_ROWS)[:, None]
    across = np.cos(angle) ** (2 / shape.roundness)
    up = np.sin(angle) ** (2 / shape.roundness)
    azimuth = np.radians(AZIMUTH_DEG)
    dents = np.exp(-(((np.abs(AZIMUTH_DEG) - 38) / 22) ** 2)) * smoothstep(0.3, 0.9, up)
    radius = foot * across * (1 + shape.taper * up) * (1 - shape.pinch * dents)
    sideways = radius * np.sin(azimuth)
    furrow = np.exp(-((sideways / 2.6) ** 2)) * smoothstep(0.7, 1.0, up)
    return radius, total * up - shape.crease_cm * furrow


def _brim(ring: HatRing, foot: np.ndarray, shape: HatShape, rng: np.random.Generator) -> np.ndarray:
    """(rows, COLUMNS + 1, 3) from the brim's edge to the crown's foot."""
    out = np.linspace(1, 0, _BRIM_ROWS)[:-1, None]
    azimuth = np.radians(AZIMUTH_DEG)
    ends = np.where(np.cos(azimuth) > 0, shape.front_cm, shape.back_cm)
    width = shape.side_cm + (ends - shape.side_cm) * np.cos(azimuth) ** 2
    # Two corners leave front and back level; three leave points in front and at both sides of the back.
    turned = 1.0 if shape.corners == 0 else (0.5 - 0.5 * np.cos(shape.corners * azimuth)) ** 1.3
    reach = width * out
    height = -shape.dip * reach + shape.curl_cm * turned * out**2.2
    outer = ring.place(foot + reach - 0.35 * shape.curl_cm * turned * out**2.2, height)
    uneven = fractal(outer.reshape(-1, 3), rng, 13.0, 2).reshape(reach.shape)
    return outer + (uneven * shape.wave_cm * out)[..., None] * ring.axes[1]


def band(ring: HatRing, crown: np.ndarray, width_cm: float) -> Garment:
    """A ribbon of another stuff around the foot of a crown (rows, COLUMNS + 1, 3)."""
    height = ring.local(crown.reshape(-1, 3))[:, 1].reshape(crown.shape[:2])
    radius = np.linalg.norm(ring.local(crown.reshape(-1, 3))[:, [0, 2]], axis=1).reshape(crown.shape[:2])
    levels = np.linspace(0, width_cm, _BAND_ROWS)
    around = np.stack([np.interp(levels, height[:20, k], radius[:20, k]) for k in range(COLUMNS + 1)], 1)
    return sheet(ring.place(around + 0.18, np.repeat(levels[:, None], COLUMNS + 1, 1)), "hatband", made_of="trim")


def badge(ring: HatRing, crown: np.ndarray, rng: np.random.Generator) -> Garment:
    """A round or pointed patch on the front of a crown (rows, COLUMNS + 1, 3), of another stuff."""
    local = ring.local(crown.reshape(-1, 3))
    outward = local * [1, 0, 1] / np.maximum(np.hypot(local[:, 0], local[:, 2]), 1e-6)[:, None]
    lifted = crown.reshape(-1, 3) + 0.15 * outward @ ring.axes
    middle, size = rng.uniform(2.5, 5.0), rng.uniform(1.2, 3.5)
    power = rng.uniform(1.0, 4.0)
    across = (
        np.abs(local[:, 0] / size) ** power + np.abs((local[:, 1] - middle) / (size * rng.uniform(0.6, 1.3))) ** power
    )
    return cut(sheet(lifted.reshape(crown.shape), "badge", made_of="trim"), np.where(local[:, 2] > 0, 1 - across, -1.0))
