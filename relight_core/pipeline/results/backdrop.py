"""What is behind the person in the finished picture."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from relight_core.imaging.black_level import Black
from relight_core.imaging.colour import srgb_decode
from relight_core.imaging.photo import without_black
from relight_core.imaging.resampling import resize_area, shrunk_size
from relight_core.lighting.background import panorama_view
from relight_core.lighting.environment import Environment
from relight_core.pipeline.edit import Edit, check_background
from relight_core.pipeline.results.channels import at_level

OWN_BACKGROUNDS = ("keep", "match")
"""Those that are the photo's own; of a photo with alpha, that is none."""

_DIMMEST, _BRIGHTEST = 0.1, 2.0
_SOFT_SIDE = 48
_SOFTNESS = 0.1


@dataclass(frozen=True, eq=False)
class Backdrop:
    """A background.

    Attributes:
        kept: the photo's own stays as it is.
        transparent: there is none.
        gain: (3,) of the photo's own, or None.
        picture, soft: (h, w, 3) over the whole picture or (3,), linear radiance, and the same blurred; None
            where the photo's own stays, and where there is none.
    """

    kept: bool = False
    transparent: bool = False
    gain: np.ndarray | None = None
    picture: np.ndarray | None = None
    soft: np.ndarray | None = None


def make_backdrop(
    background: str,
    panorama: np.ndarray | None,
    person_gain: Callable[[], np.ndarray] = lambda: np.ones(3),
    exposure: float = 1.0,
    black: Black | None = None,
) -> Backdrop:
    """The background of a name.

    Args:
        background: as in `Edit`.
        panorama: (h, w, 3) linear, for "light".
        person_gain: gives (3,), by how much the light changes the person; called for "match" only.
        exposure: of the portrait, by which a gain may be larger or smaller than one.
        black: what will lie over all of the picture, and over a panorama too; a colour stays as it was chosen.

    Raises:
        InputError: a background that is none.
    """
    check_background(background)
    if background == "keep":
        return Backdrop(kept=True)
    if background == "transparent":
        return Backdrop(transparent=True)
    if background == "match":
        # A light may be in the photo's units, as its own is, or in those of bundled ones.
        least, most = _DIMMEST * min(exposure, 1.0), _BRIGHTEST * max(exposure, 1.0)
        return Backdrop(gain=np.clip(person_gain(), least, most).astype(np.float32))
    if background == "light":
        return Backdrop(picture=panorama, soft=_softened(panorama))
    codes = np.array([int(background[i : i + 2], 16) for i in (1, 3, 5)], np.float32)
    colour = srgb_decode(codes / 255)
    return Backdrop(picture=without_black(colour, black), soft=colour)


def backdrop_panorama(edit: Edit, environment: Environment, size: tuple[int, int]) -> np.ndarray:
    """What the camera sees of the light behind the person, (h, w, 3) linear at the light's level.

    Args:
        size: (height, width) of the photo.
    """
    view = panorama_view(environment, edit.yaw_deg, *size, edit.background_fov_deg, edit.background_blur_deg)
    return at_level(view, environment.level)


def _softened(picture: np.ndarray) -> np.ndarray:
    small = resize_area(picture, shrunk_size(picture.shape[:2], _SOFT_SIDE))
    return cv2.GaussianBlur(small, (0, 0), max(_SOFTNESS * max(small.shape[:2]), 0.5)).reshape(small.shape)
