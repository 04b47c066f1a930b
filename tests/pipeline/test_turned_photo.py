"""The filled corners of a turned photo: found where there are some, and nobody goes on into them."""

import cv2
import numpy as np
import pytest

from relight_core.face.crop import Crop
from relight_core.imaging.photo import Photo
from relight_core.pipeline.per_photo.first_matte import SeenPeople
from relight_core.pipeline.per_photo.matte import draft_matte
from relight_core.pipeline.per_photo.turned_photo import filled_corners

WALL, SKIN = (0.25, 0.35, 0.5), (0.6, 0.4, 0.3)


def half_figure():
    """Somebody before a mottled wall, cut off by the photo's lower border, and the mask."""
    y, x = np.mgrid[0:240, 0:200] + 0.5
    person = (np.hypot((x - 100) / 36, (y - 90) / 48) < 1) | (y > 150)
    picture = np.where(person[..., None], SKIN, WALL) + 0.06 * np.sin(x * y)[..., None]
    return picture.astype(np.float32), person.astype(np.float32)


def turned(image, angle_deg, fill):
    """An image turned in a picture that holds all of it."""
    height, width = image.shape[:2]
    matrix = cv2.getRotationMatrix2D((width / 2, height / 2), angle_deg, 1)
    cosine, sine = np.abs(matrix[0, :2])
    size = int(width * cosine + height * sine), int(width * sine + height * cosine)
    matrix[:, 2] += (np.array(size) - (width, height)) / 2
    return cv2.warpAffine(image, matrix, size, borderValue=(fill,) * 3)


@pytest.mark.parametrize("fill", [0.0, 0.78, 1.0])
@pytest.mark.parametrize("angle_deg", [-25, 4, 10, 45])
def test_the_filled_corners_of_a_turned_photo_are_found(angle_deg, fill):
    picture, person = half_figure()
    filled = turned(np.ones_like(person), angle_deg, 0) < 0.5
    assert (filled_corners(turned(picture, angle_deg, fill)) == filled).mean() > 0.96


def test_a_photo_that_was_not_turned_has_none():
    picture, _ = half_figure()
    assert filled_corners(picture) is None
    assert filled_corners(np.full_like(picture, 0.5)) is None


def test_a_slope_in_one_corner_is_no_turned_photo():
    picture, _ = half_figure()
    y, x = np.mgrid[0:240, 0:200]
    picture[y + 0.5 * x < 70] = 0.9
    assert filled_corners(picture) is None
    picture[(239 - y) + 1.2 * x < 70] = 0.9
    assert filled_corners(picture) is None


def with_corners(*corners, colours=((0.9,) * 3, (0.9,) * 3)):
    """A picture with triangles in some corners: of each whether it is below and to the right, and its legs."""
    picture, _ = half_figure()
    y, x = np.mgrid[0:240, 0:200] + 0.5
    for (below, right, down, across), colour in zip(corners, colours, strict=True):
        from_row, from_column = (240 - y if below else y), (200 - x if right else x)
        picture[from_row / down + from_column / across < 1] = colour
    return picture


def test_corners_at_right_angles_are_of_one_turned_photo_wherever_they_are():
    for corners in (
        [(False, False, 60, 40), (True, True, 60, 40)],
        [(False, False, 60, 40), (False, True, 40, 60)],
        [(False, True, 40, 60), (True, False, 40, 60)],
        [(True, False, 40, 60), (True, True, 60, 40)],
        # Along all of the left and the right border.
        [(False, False, 300, 60), (True, True, 300, 60)],
    ):
        found = filled_corners(with_corners(*corners))
        covered = sum(across * min(down, 240) * (1 - min(down, 240) / down / 2) for _, _, down, across in corners)
        assert found.sum() == pytest.approx(covered, rel=0.25), corners


def test_corners_of_two_colours_or_at_other_angles_are_of_no_turned_photo():
    corners = [(False, False, 60, 40), (True, True, 60, 40)]
    assert filled_corners(with_corners(*corners, colours=((0.9, 0.9, 0.9), (0.9, 0.9, 0.6)))) is None
    assert filled_corners(with_corners(corners[0], (True, True, 40, 60))) is None
    assert filled_corners(with_corners(corners[0], (True, True, 60, 48))) is None
    assert filled_corners(with_corners(corners[0], (False, True, 60, 40))) is None


def test_corners_that_are_speckled_within_are_part_of_the_picture():
    picture = with_corners((False, False, 60, 40), (True, True, 60, 40))
    assert filled_corners(picture) is not None
    picture[10:14, 4:14] = picture[225:230, 180:190] = 0.3
    assert filled_corners(picture) is None


def test_nobody_goes_on_into_a_filled_corner():
    picture, person = half_figure()
    shown, mask, filled = turned(picture, 10, 0.78), turned(person, 10, 0), turned(np.ones_like(person), 10, 0) < 0.5
    height, width = filled.shape
    # A view of a body shows it going on.
    below = filled * (np.mgrid[0:height, 0:width][0] > 180).astype(np.float32)
    crop = Crop(width / 2, height / 2, float(max(height, width)))
    share = draft_matte(
        Photo(shown**2.2), lambda: SeenPeople([[(crop.extract(np.maximum(mask, below), 64), crop)]])
    ).share
    assert share[filled].max() == 0
    assert share[200:225, 100:140].min() > 0.9
