"""The photo's own catchlights are told from the iris, the lids and the white of the eye."""

import numpy as np
import pytest
from drawn_eye import draw_eyes

from relight_core.face.crop import Crop
from relight_core.face.irises import Iris
from relight_core.pipeline.per_photo.corneas import Cornea, find_cornea

IRIS = Iris(100.0, 90.0, 24.0)
DRAWN = ((100.0, 90.0, 24.0),)


def cornea_of(exposure=1.0, **drawn):
    photo = draw_eyes(DRAWN, (180, 200), **drawn)
    return photo, find_cornea(photo * np.float32(1 / exposure), exposure, IRIS)


def without_catchlights(photo, cornea):
    x0, y0, x1, y1 = map(int, cornea.view.window)
    return photo[y0:y1, x0:x1] - cornea.mirrored


def test_an_eye_without_any_loses_nothing():
    _, cornea = cornea_of()
    assert np.abs(cornea.mirrored).max() < 1e-6


@pytest.mark.parametrize("iris", [0.03, 0.15])
def test_a_catchlight_makes_way_for_iris(iris):
    photo, cornea = cornea_of(iris=iris, pupil=iris, specks=((107, 82, 4),))
    left = without_catchlights(photo, cornea)
    y, x = np.mgrid[0 : len(left), 0 : len(left)] + 0.5
    middle = np.hypot(x - len(left) / 2, y - len(left) / 2) < 18
    np.testing.assert_allclose(left[middle], iris, atol=0.3 * iris)


def test_lids_and_the_white_of_the_eye_stay():
    photo, cornea = cornea_of(opened=0.6, specks=((100, 88, 3),))
    left = without_catchlights(photo, cornea)
    y, x = np.mgrid[0 : len(left), 0 : len(left)] + 0.5
    beside = np.hypot(x - len(left) / 2, y - len(left) / 2) > 24.5
    x0, y0, x1, y1 = map(int, cornea.view.window)
    np.testing.assert_allclose(left[beside], photo[y0:y1, x0:x1][beside], atol=1e-6)


def test_pale_flecks_between_a_wide_pupil_and_a_dark_rim_stay():
    photo = draw_eyes(DRAWN, (180, 200), iris=0.14, pupil=0.02)
    y, x = np.mgrid[:180, :200] + 0.5
    away, angle = np.hypot(x - 100, y - 90) / 24, np.degrees(np.arctan2(y - 90, x - 100))
    photo[(away < 0.6) | ((away > 0.9) & (away < 1.02))] = 0.02
    photo[(away > 0.6) & (away < 0.9) & (np.mod(angle, 40) < 12)] = 0.22
    assert np.abs(find_cornea(photo, 1.0, IRIS).mirrored).max() < 0.02


def test_gloss_of_a_lid_stays():
    _, cornea = cornea_of(opened=0.6, specks=((100, 109, 2),))
    assert np.abs(cornea.mirrored).max() < 0.01


def test_a_drawn_iris_as_white_as_its_eye_is_left_alone():
    _, cornea = cornea_of(iris=0.42, pupil=0.02)
    assert cornea is None


def test_only_what_is_open_is_bare():
    _, cornea = cornea_of(opened=0.6)
    middle = len(cornea.bare) // 2
    assert cornea.bare[middle, middle] > 0.9
    assert cornea.bare[middle - 20, middle] < 0.1
    assert cornea.bare[0].max() == 0
    assert cornea.bare[:, 0].max() == 0


def test_a_bright_bar_across_an_iris_leaves_it_alone():
    photo = draw_eyes(DRAWN, (180, 200))
    photo[60:120, 94:106] = 0.6
    assert find_cornea(photo, 1.0, IRIS) is None


def test_so_does_a_narrow_one_that_reaches_the_white_of_the_eye():
    photo = draw_eyes(DRAWN, (180, 200))
    photo[88:91, 60:140] = 0.6
    assert find_cornea(photo, 1.0, IRIS) is None


def test_flecks_that_are_far_darker_than_the_white_of_the_eye_stay():
    photo = draw_eyes(DRAWN, (180, 200), iris=0.02, pupil=0.02)
    photo[80:83, 92:95] = photo[95:98, 106:109] = 0.12
    assert np.abs(find_cornea(photo, 1.0, IRIS).mirrored).max() < 0.01


def test_a_catchlight_near_the_rim_takes_nothing_from_the_white_of_the_eye_and_nothing_is_made_brighter():
    photo, cornea = cornea_of(iris=0.15, pupil=0.01, specks=((118, 90, 2), (93, 84, 3)))
    assert cornea.mirrored.max() > 0.5
    assert cornea.mirrored.min() >= 0
    y, x = np.mgrid[0 : len(cornea.bare), 0 : len(cornea.bare)] + 0.5
    beside = np.hypot(x - len(cornea.bare) / 2, y - len(cornea.bare) / 2) > 24.5
    assert cornea.mirrored[beside].max() == 0


def test_a_catchlight_is_no_lid():
    _, cornea = cornea_of(specks=((107, 82, 4),))
    middle = len(cornea.bare) // 2
    assert cornea.bare[middle - 8, middle + 7] > 0.9


def test_an_eye_between_pixels_is_seen_in_the_pixels_of_the_photo():
    photo = draw_eyes(((100.4, 90.7, 23.6),), (180, 200))
    cornea = find_cornea(photo, 1.0, Iris(100.4, 90.7, 23.6))
    window = np.array(cornea.view.window)
    np.testing.assert_array_equal(window, window.round())
    assert len(cornea.bare) == cornea.view.side
    y, x = np.nonzero(cornea.bare > 0.5)
    assert [x.mean() + 0.5 + window[0], y.mean() + 0.5 + window[1]] == pytest.approx([100.4, 90.7], abs=0.5)


def test_units_do_not_matter():
    _, usual = cornea_of(specks=((107, 82, 4),))
    _, dark = cornea_of(exposure=1000.0, specks=((107, 82, 4),))
    np.testing.assert_allclose(dark.mirrored * 1000, usual.mirrored, rtol=1e-3, atol=1e-4)
    np.testing.assert_allclose(dark.bare, usual.bare, atol=1e-3)


def test_normals_are_those_of_a_ball_that_faces_the_camera():
    _, cornea = cornea_of()
    np.testing.assert_allclose((cornea.normal**2).sum(0), 1, atol=1e-5)
    size = len(cornea.bare)
    # The cornea's radius is 7.8 mm, that of the iris 5.9 mm.
    right = cornea.normal[:, size, size + 36]
    assert right[0] == pytest.approx(18.25 / 24 * 5.9 / 7.8, abs=0.01)
    assert cornea.normal[1, size - 36, size] > 0.5


@pytest.mark.parametrize("radius", [5.0, 300.0])
def test_eyes_of_any_size(radius):
    size = int(4 * radius)
    photo = draw_eyes(
        ((size / 2, size / 2, radius),), (size, size), specks=((size / 2, size / 2 - radius / 4, radius / 5),)
    )
    cornea = find_cornea(photo, 1.0, Iris(size / 2, size / 2, radius))
    assert len(cornea.bare) <= 384
    assert 96 <= cornea.normal.shape[1] <= 128
    assert cornea.mirrored.max() > 0.5


def test_what_is_taken_out_of_a_large_eye_is_as_sharp_as_the_photo():
    photo = draw_eyes(((200.0, 200.0, 100.0),), (400, 400), iris=0.05, pupil=0.05, specks=((230, 170, 15),))
    cornea = find_cornea(photo, 1.0, Iris(200.0, 200.0, 100.0))
    left = without_catchlights(photo, cornea)
    middle = len(left) // 2
    np.testing.assert_allclose(left[middle - 60 : middle + 60, middle - 60 : middle + 60], 0.05, atol=0.02)


def test_tears_mirror_more_of_what_grazes_them():
    """Schlick's 0.025 + 0.975 (1 - cos)^5: at 0, 60 and 72.5 degrees."""
    square, steep = np.zeros((3, 3), np.float32), np.float32([1.0, 0.5, 0.3])
    normal = np.stack([np.sqrt(1 - steep**2), 0 * steep, steep])[:, None]
    cornea = Cornea(IRIS, Crop(100.0, 90.0, 3.0), square, np.zeros((3, 3, 3), np.float32), normal)
    np.testing.assert_allclose(cornea.reflectance[0], [0.025, 0.05547, 0.18887], atol=1e-4)


def test_a_black_photo_has_nothing_to_mirror():
    cornea = find_cornea(np.zeros((180, 200, 3), np.float32), 1.0, IRIS)
    assert cornea is None or (np.isfinite(cornea.bare).all() and np.abs(cornea.mirrored).max() == 0)


def test_a_lamp_at_the_rim_is_brighter_than_the_white_of_the_eye_that_it_touches():
    photo = draw_eyes(((106.0, 90.0, 24.0),), (180, 200), white=0.3, skin=0.2, specks=((86, 86, 4),))
    cornea = find_cornea(photo, 1.0, IRIS)
    assert cornea.mirrored[30 - 4, 30 - 14].max() > 1.7
    left = without_catchlights(photo, cornea)
    assert left[30 - 4, 30 - 14].max() < 0.3
    np.testing.assert_allclose(left[30, 30 - 21], 0.3, atol=0.03)


def test_a_lid_beside_the_catchlight_of_a_small_eye_is_no_darker_without_it():
    photo = draw_eyes(((50.0, 50.0, 6.0),), (100, 100), opened=0.7, specks=((50, 48, 1),))
    cornea = find_cornea(photo, 1.0, Iris(50.0, 50.0, 6.0))
    assert cornea.mirrored.max() > 1.5
    left = without_catchlights(photo, cornea)
    np.testing.assert_allclose(left[3, 4:12], 0.4, atol=0.02)


def test_what_a_lid_shades_is_as_dark_where_a_catchlight_was():
    photo = draw_eyes(DRAWN, (180, 200), iris=0.2, pupil=0.2)
    x, y = np.meshgrid(np.arange(200) + 0.5, np.arange(180) + 0.5)
    photo[(np.hypot(x - 100, y - 90) < 24) & (y < 88)] = 0.02
    photo[np.hypot(x - 104, y - 82) < 4] = 2.0
    left = without_catchlights(photo, find_cornea(photo, 1.0, IRIS))
    assert left[30 - 8, 30 + 4].max() < 0.05
