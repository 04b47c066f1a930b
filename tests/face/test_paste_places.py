"""Where a crop's maps lie in a photo, and where a photo's lie in a crop: positions come back as themselves."""

import numpy as np
import pytest

from relight_core.face.crop import Crop
from relight_core.face.paste import (
    Band,
    all_of,
    places_of,
    seen_across,
    seen_from,
    spread_crop,
    spread_window,
    unit_matrix,
    update_nearest,
    window_of,
)

SIZE = (80, 120)
CROPS = [Crop(60.0, 40.0, 40.0), Crop(60.0, 40.0, 40.0, 30.0), Crop(30.0, 50.0, 48.0, -70.0)]


def positions(size):
    """(size, size, 2) of a crop's cells: how far across and down their middles are, [0, 1]."""
    return places_of((size, size), (1, 1)).astype(np.float32)


@pytest.mark.parametrize("crop", CROPS)
def test_what_a_crop_has_at_a_place_is_seen_there_and_beyond_it_its_edge(crop):
    seen = spread_crop(positions(40), crop, all_of(SIZE, SIZE))
    expected = crop.from_photo(places_of(SIZE, SIZE), 1).clip(0.5 / 40, 1 - 0.5 / 40)
    np.testing.assert_allclose(seen, expected, atol=0.003)


@pytest.mark.parametrize("crop", CROPS)
def test_every_third_row_is_that_of_all(crop):
    whole, some = (spread_crop(positions(32), crop, Band(5, 71, SIZE, SIZE, step=step)) for step in (1, 3))
    np.testing.assert_allclose(some, whole[::3], atol=1e-3)


@pytest.mark.parametrize("columns", [None, (20, 90)])
@pytest.mark.parametrize("step", [1, 3])
@pytest.mark.parametrize(("rows", "across"), [((0, 9), (0, 70)), ((4, 13), (10, 31)), ((12, 13), (69, 70))])
def test_a_part_of_a_band_has_its_pixels(columns, step, rows, across):
    band, picture = Band(11, 60, SIZE, SIZE, columns, step), np.arange(80 * 120).reshape(SIZE)
    rows, across = slice(*rows), slice(*across)
    part = band.part(rows, across)
    np.testing.assert_array_equal(picture[part.pixels], picture[band.pixels][rows, across])
    window, maps = (10.0, 5.0, 100.0, 70.0), positions(16)
    np.testing.assert_array_equal(spread_window(maps, window, part), spread_window(maps, window, band)[rows, across])


@pytest.mark.parametrize("crop", CROPS)
@pytest.mark.parametrize("size", [(80, 120), (40, 60)])
def test_the_matrix_says_where_maps_lie(crop, size):
    places = places_of(size, size)
    (a, b, c), (d, e, f) = unit_matrix(crop, size, SIZE)
    told = np.stack([a * places[..., 0] + b * places[..., 1] + c, d * places[..., 0] + e * places[..., 1] + f], -1)
    np.testing.assert_allclose(told, crop.from_photo(places_of(size, SIZE), 1), atol=1e-6)


def test_the_window_about_a_crop_has_all_of_it_that_lies_in_the_photo():
    assert window_of(CROPS[0], SIZE, SIZE) == (slice(20, 60), slice(40, 80))
    assert window_of(CROPS[0], SIZE, (40, 60)) == (slice(10, 30), slice(20, 40))
    assert window_of(CROPS[0], SIZE, (40, 30)) == (slice(10, 30), slice(10, 20))
    assert window_of(Crop(100.0, 70.0, 60.0), SIZE, SIZE) == (slice(40, 80), slice(70, 120))
    assert window_of(Crop(60.0, 40.0, 40.0, 45.0), SIZE, SIZE) == (slice(12, 68), slice(32, 88))


@pytest.mark.parametrize("roll_deg", [0.0, 1e-9])
def test_each_pixel_is_of_the_view_whose_middle_is_nearest_in_its_sides(roll_deg):
    band, nearest = all_of(SIZE, SIZE), np.full(SIZE, np.inf, np.float32)
    assert update_nearest(Crop(40.0, 40.0, 40.0, roll_deg), band, nearest).all()
    np.testing.assert_allclose(nearest[[40, 40, 60], [40, 60, 45]], [0.0125, 0.5125, 0.5125], atol=1e-5)
    won = update_nearest(Crop(80.0, 40.0, 20.0, roll_deg), band, nearest)
    np.testing.assert_array_equal(np.flatnonzero(won[40]), np.arange(67, 120))
    assert nearest[40, 80] == pytest.approx(0.025, abs=1e-5)
    assert not update_nearest(Crop(80.0, 40.0, 20.0, roll_deg), band, nearest).any()


@pytest.mark.parametrize("view", CROPS)
def test_a_view_sees_the_photos_maps_and_another_views_at_its_own_places(view):
    photo, other = places_of((40, 30), SIZE).astype(np.float32), Crop(50.0, 44.0, 90.0, 10.0)
    there = view.to_photo(places_of((24, 24), (24, 24)), 24)
    within = there.clip([2, 1], [118, 79])
    np.testing.assert_allclose(seen_from(view, 24, photo, SIZE), within, atol=0.1)
    across = other.from_photo(there, 1).clip(0.5 / 48, 1 - 0.5 / 48)
    into = np.zeros((24, 24, 2), np.float32)
    np.testing.assert_allclose(seen_across(view, 24, positions(48), other, into), across, atol=0.003)
    np.testing.assert_allclose(into, across, atol=0.003)


def test_a_window_within_one_pixel_of_a_small_picture_is_that_pixel():
    seen = spread_window(np.float32([[1.0, 3.0], [5.0, 7.0]]), (61.0, 41.0, 62.0, 42.0), all_of((8, 12), SIZE))
    assert seen.shape == (8, 12)
    assert np.isfinite(seen).all()
    assert seen.min() >= 1
    assert seen.max() <= 7
