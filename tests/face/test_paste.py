"""Maps of crops at the photo's pixels, band by band."""

import numpy as np
import pytest

from relight_core.face.crop import Crop
from relight_core.face.paste import (
    Band,
    across_and_down,
    bands,
    fade,
    places_of,
    spread_crop,
    spread_window,
    whole_photo,
)

RNG = np.random.default_rng(5)
SIZE = (180, 220)


def smooth_photo():
    y, x = np.mgrid[0 : SIZE[0], 0 : SIZE[1]] / 40.0
    return np.dstack([np.sin(x) + 1.5, np.cos(y) + 1.5, np.sin(x + y) + 1.5]).astype(np.float32)


def inside(crop, margin=4.0):
    """Pixels well within a crop."""
    y, x = np.mgrid[0 : SIZE[0], 0 : SIZE[1]] + 0.5
    local = crop.from_photo(np.stack([x, y], -1), 1) * crop.side
    return ((local > margin) & (local < crop.side - margin)).all(-1)


@pytest.mark.parametrize(
    "crop",
    [
        Crop(100.0, 90.0, 64.0),
        Crop(101.0, 88.0, 150.0),
        Crop(5.0, 170.0, 90.0),
        Crop(100.0, 90.0, 90.0, 30.0),
        Crop(110.0, 80.0, 120.0, -45.0),
    ],
)
def test_extract_and_spread_gives_a_smooth_photo_back(crop):
    photo = smooth_photo()
    whole = Band(0, SIZE[0], SIZE, SIZE)
    back = spread_crop(crop.extract(photo, 96), crop, whole)
    assert back.shape == photo.shape
    assert np.abs(back - photo)[inside(crop)].max() < 0.04


@pytest.mark.parametrize("crop", [Crop(100.0, 90.0, 150.0), Crop(100.0, 90.0, 90.0, 20.0), Crop(3.0, 4.0, 300.0)])
@pytest.mark.parametrize("rows", [1, 7, 64, 500])
def test_cutting_into_bands_changes_nothing(crop, rows):
    maps = RNG.random((32, 32, 3), np.float32)
    whole = spread_crop(maps, crop, Band(0, SIZE[0], SIZE, SIZE))
    cut = np.concatenate([spread_crop(maps, crop, band) for band in bands(SIZE, SIZE, rows)])
    np.testing.assert_allclose(cut, whole, atol=1e-3)


@pytest.mark.parametrize("columns", [(0, 220), (0, 1), (60, 130), (200, 220)])
@pytest.mark.parametrize("crop", [Crop(100.0, 90.0, 150.0), Crop(100.0, 90.0, 90.0, 20.0), Crop(150.0, 60.0, 60.0)])
def test_some_columns_are_those_of_all(crop, columns):
    maps, first, last = RNG.random((32, 32, 3), np.float32), *columns
    whole, part = (spread_crop(maps, crop, Band(20, 70, SIZE, SIZE, chosen)) for chosen in (None, columns))
    np.testing.assert_array_equal(part, whole[:, first:last])


def test_bands_cover_every_row_once():
    rows = [row for band in bands((130, 10), (130, 10), 64) for row in range(band.top, band.bottom)]
    assert rows == list(range(130))


def test_maps_of_the_whole_photo_are_enlarged_to_it():
    maps = RNG.random((18, 22), np.float32)
    large = spread_window(maps, whole_photo(SIZE), Band(0, SIZE[0], SIZE, SIZE))
    assert large.shape == SIZE
    assert large.min() >= maps.min() - 1e-6
    assert large.max() <= maps.max() + 1e-6
    np.testing.assert_allclose(large[5::10, 5::10], maps, atol=0.25)
    assert abs(float(large.mean()) - float(maps.mean())) < 0.01


def test_beyond_a_window_its_edges_go_on():
    maps = np.arange(4, dtype=np.float32)[None].repeat(4, 0)
    row = spread_window(maps, (10, 10, 20, 20), Band(0, 30, (30, 40), (30, 40)))[3]
    assert (row[:10] == 0).all()
    assert (row[20:] == 3).all()


def test_a_smaller_picture_shows_the_same_at_half_the_size():
    maps = RNG.random((8, 8, 3), np.float32)
    crop = Crop(100.0, 90.0, 80.0)
    full = spread_crop(maps, crop, Band(0, 180, (180, 220), (180, 220)))
    half = spread_crop(maps, crop, Band(0, 90, (90, 110), (180, 220)))
    shrunk = full.reshape(90, 2, 110, 2, 3).mean((1, 3))
    np.testing.assert_allclose(half, shrunk, atol=0.1)


def test_fading_falls_to_nothing_and_never_rises():
    weight = fade(np.linspace(0, 0.5, 50), 0.2)
    assert weight[-1] == 1
    assert weight[0] == 0
    assert (np.diff(weight) >= 0).all()


def test_fading_only_where_it_is_asked_for():
    position = np.array([-0.5, 0.01, 0.5, 0.99, 1.5])
    assert fade(position, 0.1).tolist()[2] == 1
    assert fade(position, 0.1)[0] == 0
    assert fade(position, 0.1)[4] == 0
    np.testing.assert_array_equal(fade(position, 0.1, before=0)[:3], 1)
    np.testing.assert_array_equal(fade(position, 0.1, after=0)[2:], 1)


def test_fading_comes_by_degrees_with_what_there_is_beyond():
    position = np.linspace(0, 1, 501)
    beyond = np.arange(0, 0.05, 0.002)
    for end in ("before", "after"):
        weights = np.array([fade(position, 0.1, **{end: share}) for share in beyond])
        assert np.abs(np.diff(weights.mean(1))).max() < 0.006
        assert np.diff(weights.mean(1)).max() <= 0
        np.testing.assert_array_equal(weights[-1], fade(position, 0.1, **{end: np.inf}))


def test_how_far_across_and_down_a_leaning_crop_a_photos_pixels_are():
    crop = Crop(30.0, 50.0, 40.0, 25.0)
    across, down = across_and_down(crop, (20, 30), (80, 120))
    places = crop.from_photo(places_of((20, 30), (80, 120)), 1)
    np.testing.assert_allclose(np.dstack([across, down]), places, atol=1e-12)
