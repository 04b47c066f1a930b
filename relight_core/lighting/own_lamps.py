"""The lamps that a light has of its own, as soft boxes, and what is left of it without them.

Of a light that is drawn from lamps these are known. In a panorama they are its small lamps, suns and bulbs: what
stands out there from what lies around it becomes a disc of the same irradiance, colour and spread.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from relight_core.imaging.colour import REC709_LUMINANCE
from relight_core.lighting.environment import Environment, shrink
from relight_core.lighting.lamps import AROUND_DEG, BEYOND_DEG, Lamp, lamps_of
from relight_core.lighting.rig_description import AreaLight
from relight_core.lighting.soft_box import SMALLEST_DEG, SoftBox, moved_to
from relight_core.lighting.sphere import directions, solid_angles
from relight_core.lighting.summary import meter_reading

_MEASURED_HEIGHT = 256


def own_lamps(light: Environment) -> tuple[SoftBox, ...]:
    """The light's lamps; of a panorama the brightest first, at most 4. Empty where it has none.

    Their intensities are multiples of the light's meter reading, as those of any soft box added to it.
    """
    if light.room is not None:
        return light.lamps
    lamps = lamps_of(light)
    return light.of_shape("own lamps", lambda shape: _boxes(shape, lamps, meter_reading(light))) if lamps else ()


def room_of(light: Environment) -> np.ndarray | None:
    """(H, 2H, 3) in the units of the light's shape: what is left without its lamps; None where it has none."""
    if light.room is not None:
        return light.room
    lamps = lamps_of(light)
    return light.of_shape("room", lambda shape: _without(shape, lamps)) if lamps else None


def box_of(lamp: AreaLight, unit: float) -> SoftBox:
    """A rig's lamp as a box, of the same irradiance where an intensity of 1 stands for `unit`."""
    box = SoftBox(
        azimuth_deg=lamp.azimuth_deg,
        elevation_deg=lamp.elevation_deg,
        width_deg=lamp.width_deg,
        height_deg=lamp.height_deg,
        softness=lamp.softness,
        colour=None if lamp.kelvin is not None else lamp.colour,
        intensity=float(np.dot(lamp.colour, REC709_LUMINANCE)) * lamp.intensity / unit,
        form=lamp.form,
        hole=lamp.hole_deg / lamp.width_deg,
        name=lamp.name or "lamp",
    )
    return box if lamp.kelvin is None else replace(box, kelvin=lamp.kelvin)


def _boxes(shape: np.ndarray, lamps: Sequence[Lamp], unit: float) -> tuple[SoftBox, ...]:
    small = shrink(shape, _MEASURED_HEIGHT) if len(shape) > _MEASURED_HEIGHT else shape
    toward, areas = directions(*small.shape[:2]), solid_angles(*small.shape[:2])
    boxes = []
    for number, lamp in enumerate(lamps, 1):
        around, kept = _behind(small, toward, areas, lamp)
        facing = (toward[around] @ np.array(lamp.toward, np.float32)) * areas[around]
        card = facing.astype(np.float64) @ (small[around] - kept) / np.pi
        luminance = float(card @ REC709_LUMINANCE)
        size = max(2 * lamp.radius_deg, SMALLEST_DEG)
        colour = tuple(float(part) for part in card / max(luminance, 1e-12))
        name = "lamp" if len(lamps) == 1 else f"lamp {number}"
        disc = SoftBox(0.0, 0.0, size, size, 0.2, colour=colour, intensity=luminance / unit, form="disc", name=name)
        boxes.append(moved_to(disc, np.array(lamp.toward)))
        small = small.copy()
        small[around] = kept
    return tuple(boxes)


def _without(shape: np.ndarray, lamps: Sequence[Lamp]) -> np.ndarray:
    toward, areas = directions(*shape.shape[:2]), solid_angles(*shape.shape[:2])
    left = shape.copy()
    for lamp in lamps:
        around, kept = _behind(left, toward, areas, lamp)
        left[around] = kept
    return left


def _behind(shape: np.ndarray, toward: np.ndarray, areas: np.ndarray, lamp: Lamp) -> tuple[np.ndarray, np.ndarray]:
    """Where a lamp stands out, (H, 2H) bool, and what is behind it there, (N, 3): no brighter than the surroundings."""
    apart = toward @ np.array(lamp.toward, np.float32)
    around, beyond = apart > math.cos(math.radians(AROUND_DEG)), apart > math.cos(math.radians(BEYOND_DEG))
    beyond &= ~around
    colour = areas[beyond] @ shape[beyond] / max(float(areas[beyond].sum()), 1e-12)
    return around, np.minimum(shape[around], colour)
