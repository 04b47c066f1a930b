import numpy as np
import pytest

from relight_core.face.crop import Crop
from relight_core.face.paste import paste_crop, soft_edge

RNG = np.random.default_rng(5)


def smooth_photo(height=180, width=220):
    y, x = np.mgrid[0:height, 0:width] / 40.0
    return np.dstack([np.sin(x) + 1.5, np.cos(y) + 1.5, np.sin(x + y) + 1.5]).astype(np.float32)


@pytest.mark.parametrize(
    ("crop", "size"),
    [
        (Crop(100.0, 90.0, 64.0), 64),
        (Crop(100.3, 90.7, 71.5), 128),
        (Crop(101.7, 88.2, 150.0), 100),
        (Crop(5.0, 170.0, 90.0), 64),
    ],
)
def test_extract_and_paste_gives_a_smooth_photo_back(crop, size):
    photo = smooth_photo()
    back = paste_crop(photo, crop.extract(photo, size), crop, np.ones((size, size)))
    assert np.abs(back - photo).max() < 0.02


def test_a_crop_on_whole_pixels_is_pasted_pixel_by_pixel():
    photo = RNG.random((60, 70, 3)).astype(np.float32)
    relit = RNG.random((20, 20, 3)).astype(np.float32)
    pasted = paste_crop(photo, relit, Crop(30.0, 25.0, 20.0), np.ones((20, 20)))
    np.testing.assert_array_equal(pasted[15:35, 20:40], relit)
    pasted[15:35, 20:40] = photo[15:35, 20:40]
    np.testing.assert_array_equal(pasted, photo)


def test_outside_the_crop_nothing_changes_and_the_base_is_kept():
    photo = smooth_photo()
    before = photo.copy()
    crop = Crop(100.5, 90.5, 40.0)
    pasted = paste_crop(photo, np.full((32, 32, 3), 9.0), crop)
    np.testing.assert_array_equal(photo, before)
    changed = np.abs(pasted - photo).max(axis=2) > 0
    assert changed[90, 100]
    rows, columns = np.flatnonzero(changed.any(axis=1)), np.flatnonzero(changed.any(axis=0))
    assert rows.min() >= 70
    assert rows.max() <= 110
    assert columns.min() >= 80
    assert columns.max() <= 120


def test_the_default_edge_is_soft():
    pasted = paste_crop(np.zeros((100, 100)), np.ones((64, 64)), Crop(50.0, 50.0, 80.0))
    middle_row = pasted[50]
    assert middle_row[50] == pytest.approx(1.0)
    assert middle_row[10] < 0.05
    assert np.abs(np.diff(middle_row)).max() < 0.25


def test_the_weight_decides_and_may_have_its_own_size():
    base, relit = np.zeros((40, 40, 3)), np.ones((32, 32, 3))
    weight = np.zeros((8, 8))
    weight[:, 4:] = 1.0
    pasted = paste_crop(base, relit, Crop(20.0, 20.0, 40.0), weight)
    np.testing.assert_allclose(pasted[:, :14], 0.0)
    np.testing.assert_allclose(pasted[:, 27:], 1.0, atol=1e-6)
    np.testing.assert_allclose(paste_crop(base, relit, Crop(20.0, 20.0, 40.0), np.full((4, 4), 0.25)), 0.25)


def test_a_crop_beside_the_photo_changes_nothing():
    photo = smooth_photo(20, 30)
    for crop in (Crop(-50.0, 10.0, 20.0), Crop(10.0, 500.0, 100.0), Crop(30.0 + 10.0, 10.0, 20.0)):
        np.testing.assert_array_equal(paste_crop(photo, np.ones((8, 8, 3)), crop), photo)


def test_partly_covered_pixels_are_partly_changed():
    pasted = paste_crop(np.zeros((10, 10)), np.ones((8, 8)), Crop(5.0, 5.0, 5.0), np.ones((8, 8)))
    assert pasted[5, 2] == pytest.approx(0.5, abs=1e-6)
    assert pasted.sum() == pytest.approx(25.0, abs=1e-4)


def test_the_soft_edge_is_whole_inside_and_nothing_at_the_rim():
    edge = soft_edge(100, 0.1)
    assert edge[50, 50] == 1.0
    assert edge[20:80, 20:80].min() == 1.0
    assert edge[0].max() < 0.02
    assert edge[:, -1].max() < 0.02
    np.testing.assert_array_equal(edge, edge[::-1, ::-1])
