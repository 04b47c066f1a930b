"""What the camera sees of the light behind the person (paper, sec. 5.2.2, after Sun et al. 2019)."""

from __future__ import annotations

import math

import cv2
import numpy as np

from relight_core.imaging.resampling import resize_area
from relight_core.lighting.environment import Environment
from relight_core.lighting.sphere import place_on_map, turn_fraction

_SMALLEST_SIDE = 64
"""Pixels that a view's longer side is drawn with at least, unless the picture is smaller."""
_WIDE_SIDE = 1024
"""Pixels that a view is drawn with at most just to show all texels in its middle; beyond that, and in small pictures,
the map is averaged first."""

_BLURRED_PX, _BLURRED_TEXELS = 6.0, 0.5
"""Standard deviations from which on a blur that is drawn at low resolution and upsampled looks as smooth as one drawn
at full resolution: in pixels, and in texels of the map at the picture's border, where they are widest."""

_WIDEST_BLUR_DEG = 20.0
_NARROWEST_DEG = 0.01
_WIDEST_BLUR_SIDES = 4
"""In sides of the picture. Blurred by that much it has one colour anyway; a wider kernel would only take longer."""


def panorama_view(
    environment: Environment,
    yaw_deg: float,
    height: int,
    width: int,
    field_of_view_deg: float = 50.0,
    blur_deg: float = 1.0,
) -> np.ndarray:
    """What a camera in the person's place sees looking along -z, at no higher resolution than the light has detail.

    The caller upsamples the result to the picture. A map coarser than the picture is drawn at a size that suits its
    texels and blurred by at least half a texel, so that no texel shows. A blurred one is drawn no larger than its
    blur needs.

    Args:
        environment: the light.
        yaw_deg: its rotation; positive moves the background to the right.
        height, width: pixels of the picture that it will be part of.
        field_of_view_deg: of the picture's longer side, in (0, 170]; below 0.01 counts as 0.01.
        blur_deg: standard deviation of the blur, in [0, 20].

    Returns:
        (h, w, 3) float32 linear radiance of the light's shape, h and w at most height and width: multiply
        by its level for the map's own units.

    Raises:
        ValueError: a field of view, a blur or a yaw out of range.
    """
    _check_view(field_of_view_deg, blur_deg, yaw_deg)
    longer = max(height, width)
    side, focal = _drawn_side(environment.height, longer, field_of_view_deg, blur_deg)
    drawn_height, drawn_width = (max(1, round(n * side / longer)) for n in (height, width))
    panorama = _no_finer_than_pixels(environment.shape, focal)
    sigma = _deviation_px(max(blur_deg, 90.0 / len(panorama)), focal, side)
    margin = min(math.ceil(3 * sigma), side)
    directions = _view_directions(drawn_height, drawn_width, longer * focal / side, height, width, margin)
    picture = _sample(panorama, directions, yaw_deg)
    picture = cv2.GaussianBlur(picture, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE)
    return np.ascontiguousarray(picture[margin : margin + drawn_height, margin : margin + drawn_width])


def _check_view(field_of_view_deg: float, blur_deg: float, yaw_deg: float) -> None:
    in_range = 0 < field_of_view_deg <= 170 and 0 <= blur_deg <= _WIDEST_BLUR_DEG
    if not in_range or not math.isfinite(yaw_deg):
        raise ValueError(f"no view of {field_of_view_deg} deg with blur {blur_deg} deg at yaw {yaw_deg} deg")


def _drawn_side(map_height: int, longer: int, field_of_view_deg: float, blur_deg: float) -> tuple[int, float]:
    """The longer side to draw, at most `longer`, and the focal length, both in pixels of that drawing."""
    texels = field_of_view_deg * map_height / 180.0
    sides_per_focal = 2 * math.tan(math.radians(max(field_of_view_deg, _NARROWEST_DEG) / 2))
    all_texels = min(math.ceil(sides_per_focal * map_height / math.pi), _WIDE_SIDE)
    side = max(math.ceil(2 * texels), all_texels)
    if blur_deg > 0:
        sigma = max(_BLURRED_PX, _BLURRED_TEXELS * (1 + (sides_per_focal / 2) ** 2))
        side = min(side, math.ceil(sides_per_focal * sigma / math.tan(math.radians(blur_deg))))
    side = min(longer, max(_SMALLEST_SIDE, side))
    return side, side / sides_per_focal


def _no_finer_than_pixels(panorama: np.ndarray, focal: float) -> np.ndarray:
    """The map, or a copy that is shrunk until its texels are as wide as the pixels in the middle of the view.

    Finer texels would fall between the directions that are sampled, and a sun would flicker while the light rotates.
    """
    height = max(math.ceil(focal * math.pi), 1)
    return panorama if height >= len(panorama) else resize_area(panorama, (height, 2 * height))


def _deviation_px(blur_deg: float, focal: float, side: int) -> float:
    """The blur's standard deviation in pixels of a drawing with that focal length and longer side."""
    wanted = focal * math.tan(math.radians(min(blur_deg, _WIDEST_BLUR_DEG)))
    return min(wanted, _WIDEST_BLUR_SIDES * side)


def _view_directions(
    drawn_height: int, drawn_width: int, focal: float, height: int, width: int, margin: int
) -> np.ndarray:
    """Directions (drawn_height + 2 margin, drawn_width + 2 margin, 3) through a grid over the picture.

    `focal` is in pixels of the picture, `margin` in steps of the grid.
    """
    x = ((np.arange(-margin, drawn_width + margin) + 0.5) / drawn_width - 0.5) * width / focal
    y = (0.5 - (np.arange(-margin, drawn_height + margin) + 0.5) / drawn_height) * height / focal
    across, up = np.meshgrid(x, y)
    return np.stack([across, up, -np.ones_like(across)], axis=-1)


def _sample(panorama: np.ndarray, directions: np.ndarray, yaw_deg: float) -> np.ndarray:
    """Bilinear look-up in a lat-long map, continued across its seam; directions may have any length."""
    height, width = panorama.shape[:2]
    x, y, z = np.moveaxis(directions, -1, 0)
    across, down = place_on_map(x, y, z)
    column = (across - turn_fraction(yaw_deg)) * width - 0.5
    row = np.clip(down * height - 0.5, 0, height - 1)
    left = np.floor(column).astype(np.intp)
    top = np.floor(row).astype(np.intp)
    right_share = (column - left)[..., None].astype(np.float32)
    bottom_share = (row - top)[..., None].astype(np.float32)
    bottom = np.minimum(top + 1, height - 1)
    left, right = left % width, (left + 1) % width
    upper = panorama[top, left] * (1 - right_share) + panorama[top, right] * right_share
    lower = panorama[bottom, left] * (1 - right_share) + panorama[bottom, right] * right_share
    return upper * (1 - bottom_share) + lower * bottom_share
