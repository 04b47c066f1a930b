"""Soft boxes, the lamps that a user adds to a light: their place on the sphere, outline, hit testing and radiance.

Angles are those of the rigs: azimuth 0 is the camera's side of the face, positive azimuth the right of the image,
positive elevation above. They are in the light's own frame, so that rotating the light moves its soft boxes too.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from relight_core.imaging.colour import REC709_LUMINANCE
from relight_core.lighting.colour_temperature import COOLEST_KELVIN, HOTTEST_KELVIN, WHITE_KELVIN, kelvin_to_rgb
from relight_core.lighting.rig_description import FORMS, WIDEST_HOLE, AreaLight
from relight_core.lighting.rig_render import area_light_radiance, direction_of
from relight_core.lighting.sphere import directions, solid_angles

SMALLEST_DEG, LARGEST_DEG = 3.0, 150.0

SOFT_BOX_RANGES = {
    "azimuth_deg": (-180.0, 180.0),
    "elevation_deg": (-90.0, 90.0),
    "width_deg": (SMALLEST_DEG, LARGEST_DEG),
    "height_deg": (SMALLEST_DEG, LARGEST_DEG),
    "softness": (0.0, 1.0),
    "kelvin": (COOLEST_KELVIN, HOTTEST_KELVIN),
    "intensity": (0.0, 16.0),
    "hole": (0.0, WIDEST_HOLE),
}


@dataclass(frozen=True)
class SoftBox:
    """A flat lamp that faces the subject.

    Attributes:
        azimuth_deg, elevation_deg: of its centre, [-180, 180] and [-90, 90].
        width_deg, height_deg: its angular size as seen from the face, [3, 150]; of a disc only the width counts.
        softness: share of its half size over which the edge fades, [0, 1].
        kelvin: its colour temperature, [1667, 25000]; 5600 is white.
        colour: linear Rec.709 of a coloured gel, which replaces the temperature, or None. Its luminance is divided
            out, so only hue and saturation count.
        intensity: radiance of a white card that faces the lamp, as a multiple of that of a card on the brightest side
            of the light that the box is added to, [0, 16].
        form: "rectangle" or "disc".
        hole: share of a disc's width that is dark in its middle, [0, 0.9], for a ring light.
        off: it is switched off and gives no light.
        name: if the box was one of the light's own lamps (see `own_lamps`), that lamp's name; otherwise empty.

    Raises:
        ValueError: another form.
    """

    azimuth_deg: float = -45.0
    elevation_deg: float = 35.0
    width_deg: float = 30.0
    height_deg: float = 30.0
    softness: float = 0.4
    kelvin: float = WHITE_KELVIN
    colour: tuple[float, float, float] | None = None
    intensity: float = 1.0
    form: str = "rectangle"
    hole: float = 0.0
    off: bool = False
    name: str = ""

    def __post_init__(self) -> None:
        if self.form not in FORMS:
            raise ValueError(f"a soft box is a {' or a '.join(FORMS)}, no {self.form!r}")

    @property
    def is_round(self) -> bool:
        """Whether it is a disc or a ring."""
        return self.form == "disc"

    @property
    def direction(self) -> np.ndarray:
        """(3,) unit vector from the face toward its centre, in the light's frame."""
        return direction_of(self.azimuth_deg, self.elevation_deg).astype(np.float64)

    @property
    def rgb(self) -> np.ndarray:
        """Its colour, (3,) linear Rec.709 of luminance 1; a black gel counts as white."""
        if self.colour is None:
            return kelvin_to_rgb(self.kelvin)
        luminance = float(np.dot(self.colour, REC709_LUMINANCE))
        return np.array(self.colour) / luminance if luminance > 0 else np.ones(3)


def box_title(boxes: Sequence[SoftBox], index: int) -> str:
    """A title for one of a light's boxes: its name, or its number among the boxes that the user added."""
    if boxes[index].name:
        return boxes[index].name.capitalize()
    return f"Soft box {sum(not box.name for box in boxes[: index + 1])}"


def soft_box_radiance(box: SoftBox, height: int, unit: float = 1.0) -> np.ndarray:
    """A panorama with only the box. Its irradiance on a card that faces it is exactly pi * intensity * unit.

    Args:
        box: the lamp.
        height: rows of the map.
        unit: luminance of a white card that an intensity of 1 stands for.

    Returns:
        (height, 2 * height, 3) float32 linear radiance; 0 if the box is switched off.
    """
    lamp = AreaLight(
        azimuth_deg=box.azimuth_deg,
        elevation_deg=box.elevation_deg,
        width_deg=box.width_deg,
        height_deg=box.height_deg,
        colour=tuple(float(value) for value in box.rgb),
        intensity=0.0 if box.off else box.intensity * unit,
        softness=box.softness,
        hole_deg=box.hole * box.width_deg if box.is_round else 0.0,
        form=box.form,
    )
    return area_light_radiance(lamp, directions(height, 2 * height), solid_angles(height, 2 * height))


def moved_to(box: SoftBox, direction: np.ndarray) -> SoftBox:
    """The box with its centre in a direction (3,) of any length; straight up or down, its azimuth stays."""
    x, y, z = (float(value) for value in direction)
    level = math.hypot(x, z)
    azimuth_deg = math.degrees(math.atan2(x, z)) if level > 1e-9 else box.azimuth_deg
    return replace(box, azimuth_deg=azimuth_deg, elevation_deg=math.degrees(math.atan2(y, level)))


def resized_to(box: SoftBox, direction: np.ndarray) -> SoftBox:
    """The box with the same centre, and so large that a corner, or a disc's edge, lies in a direction (3,)."""
    if box.is_round:
        size = possible_size_deg(2 * _from_centre_deg(box, direction))
        return replace(box, width_deg=size, height_deg=size)
    across, along, _ = _angles(box, direction)
    return replace(box, width_deg=possible_size_deg(2 * abs(across)), height_deg=possible_size_deg(2 * abs(along)))


def possible_size_deg(degrees: float) -> float:
    """An angle clamped to the widths and heights that a soft box may have."""
    return min(max(degrees, SMALLEST_DEG), LARGEST_DEG)


def contains(box: SoftBox, direction: np.ndarray) -> bool:
    """Whether a direction (3,) hits the box, also across the panorama's seam and near its poles."""
    if box.is_round:
        return _from_centre_deg(box, direction) <= box.width_deg / 2
    across, along, ahead = _angles(box, direction)
    return ahead > 0 and abs(across) <= box.width_deg / 2 and abs(along) <= box.height_deg / 2


def corners(box: SoftBox) -> np.ndarray:
    """(4, 3) unit vectors toward its corners, in order around it; for a disc, toward its edge on the diagonals."""
    signs = np.array([(-1, 1), (1, 1), (1, -1), (-1, -1)])
    if box.is_round:
        signs = signs / np.sqrt(2)
    return _toward(box, signs[:, 0], signs[:, 1])


def outline(box: SoftBox, per_side: int = 12) -> np.ndarray:
    """(4 * per_side, 3) unit vectors along its edge, in order around it."""
    if box.is_round:
        angle = np.linspace(0.0, 2 * np.pi, 4 * per_side, endpoint=False)
        return _toward(box, np.cos(angle), np.sin(angle))
    run = np.linspace(-1.0, 1.0, per_side, endpoint=False)
    one = np.ones_like(run)
    across = np.concatenate([run, one, -run, -one])
    along = np.concatenate([one, -run, -one, run])
    return _toward(box, across, along)


def lamp_direction(normal: np.ndarray, aim: str) -> np.ndarray:
    """The direction of a lamp that makes a point of a face bright, or puts a highlight there.

    Args:
        normal: (3,) unit, camera space.
        aim: "bright" puts the lamp in the direction of the normal; "highlight" in the direction that the surface
            mirrors toward a distant camera, the reflection of +z about the normal.

    Returns:
        (3,) float64 unit, camera space.

    Raises:
        ValueError: another aim, or a normal of length 0.
    """
    length = float(np.linalg.norm(normal))
    if aim not in ("bright", "highlight") or not length > 0:
        raise ValueError(f"no lamp for {aim!r} at a normal of length {length}")
    unit = np.asarray(normal, np.float64) / length
    return unit if aim == "bright" else 2 * unit[2] * unit - np.array([0.0, 0.0, 1.0])


def _axes(box: SoftBox) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The box's orthonormal frame: unit vectors (3,) to the right, up, and from the face to its centre."""
    azimuth = math.radians(box.azimuth_deg)
    forward = box.direction
    right = np.array([math.cos(azimuth), 0.0, -math.sin(azimuth)])
    return right, np.cross(forward, right), forward


def _angles(box: SoftBox, direction: np.ndarray) -> tuple[float, float, float]:
    """A direction's angles in degrees along the box's width and height, and its component toward the centre."""
    right, up, forward = _axes(box)
    ahead = float(direction @ forward)
    across = math.degrees(math.atan2(float(direction @ right), ahead))
    return across, math.degrees(math.atan2(float(direction @ up), ahead)), ahead


def _from_centre_deg(box: SoftBox, direction: np.ndarray) -> float:
    across, ahead = np.linalg.norm(np.cross(box.direction, direction)), float(direction @ box.direction)
    return math.degrees(math.atan2(float(across), ahead))


def _toward(box: SoftBox, across: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Unit vectors (n, 3) toward points of the box's plane, (n,) and (n,) in half widths and half heights."""
    right, up, forward = _axes(box)
    sizes = (box.width_deg, box.width_deg if box.is_round else box.height_deg)
    half_width, half_height = (math.tan(math.radians(size / 2)) for size in sizes)
    points = forward + np.outer(across * half_width, right) + np.outer(along * half_height, up)
    return points / np.linalg.norm(points, axis=1, keepdims=True)
