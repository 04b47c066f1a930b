"""Views into panoramas, and things that stand exactly behind a head."""

import numpy as np
import pytest

from relight_core.dataset.cutouts.scenery.behind import with_something_behind
from relight_core.dataset.cutouts.scenery.panoramas import look_around, read_places
from relight_core.dataset.cutouts.scenery.places import park, room, with_crowns
from relight_core.dataset.cutouts.scenery.pool import SceneryPool
from relight_core.dataset.cutouts.scenery.strokes import put
from relight_core.errors import InputError
from relight_core.imaging.write import write_image

SEEDS = range(12)


def sky_over_ground():
    panorama = np.full((64, 128, 3), 0.1, np.float32)
    panorama[:32] = [0.2, 0.4, 0.9]
    return panorama


@pytest.mark.parametrize("seed", SEEDS)
def test_the_sky_is_above_the_ground_wherever_one_looks(seed):
    view = look_around(sky_over_ground(), np.random.default_rng(seed))
    assert view[0].mean() >= view[-1].mean()


def test_one_sees_all_around_and_across_the_seam():
    columns = np.broadcast_to(np.arange(128, dtype=np.float32)[None, :, None], (64, 128, 3)).copy()
    seen = [look_around(columns, np.random.default_rng(seed)) for seed in range(60)]
    assert min(view.min() for view in seen) < 2
    assert max(view.max() for view in seen) > 125


def test_places_are_exposed_alike_whatever_their_units(tmp_path):
    for name, level in (("a", 0.01), ("b", 300.0)):
        write_image(tmp_path / f"{name}.exr", sky_over_ground() * level)
    medians = [np.median(place[16:-16]) for place in read_places(tmp_path)]
    assert medians == pytest.approx([0.25, 0.25], rel=0.01)


def test_places_in_sub_folders_are_found_as_lights_are(tmp_path):
    (tmp_path / "park").mkdir()
    write_image(tmp_path / "park" / "morning.exr", sky_over_ground())
    assert len(read_places(tmp_path)) == 1


def test_a_folder_without_panoramas_is_refused(tmp_path):
    (tmp_path / "notes.txt").write_text("none here")
    with pytest.raises(InputError, match="no panoramas"):
        read_places(tmp_path)


@pytest.mark.parametrize("seed", SEEDS)
def test_what_stands_behind_a_head_is_near_it(seed):
    size, centre, face_px = 64, np.array([40.0, 30.0]), 12.0
    nothing, stuff = np.zeros((size, size, 3)), np.ones((size, size, 3))
    image = with_something_behind(nothing, stuff, centre, face_px, np.random.default_rng(seed))
    assert 0 <= image.min() <= image.max() <= 1 + 1e-6
    _, columns = np.nonzero(image[..., 0] > 0.5)
    assert columns.size
    assert abs(columns - centre[0]).min() < 2 * face_px


@pytest.mark.parametrize("draw", [room, park])
def test_places_are_radiance_and_follow_from_their_seed(draw, pool):
    for seed in SEEDS:
        first, again = (draw(pool, np.random.default_rng(seed)) for _ in range(2))
        np.testing.assert_array_equal(first, again)
        assert first.shape == (384, 384, 3)
        assert np.isfinite(first).all()
        assert first.min() >= 0


def test_crowns_hang_from_above(pool):
    sky = np.ones((384, 384, 3), np.float32)
    covered = np.mean([1 - with_crowns(sky, pool, np.random.default_rng(seed)).mean((1, 2)) for seed in SEEDS], 0)
    assert covered[:96].mean() > 2 * covered[-96:].mean()


def test_panoramas_are_among_the_scenes(pool):
    places = [np.full((8, 16, 3), 3.0, np.float32)]
    scenes = [
        SceneryPool(pool, np.random.default_rng(seed), 1, given).view(16, np.random.default_rng(5))
        for seed in SEEDS
        for given in ((), places)
    ]
    assert any(not np.array_equal(without, beside) for without, beside in zip(scenes[::2], scenes[1::2], strict=True))


@pytest.mark.parametrize(("x", "y"), [(-9, 0), (8, 8), (40, 40), (0, -40), (6, -2)])
def test_pictures_are_laid_over_each_other_as_far_as_they_fit(x, y):
    image = np.zeros((12, 12, 3))
    put(image, np.ones((5, 7, 3)), x, y)
    wanted = np.zeros((60, 60))
    if abs(x) < 40 and abs(y) < 40:
        wanted[y + 20 : y + 25, x + 20 : x + 27] = 1
    np.testing.assert_array_equal(image[..., 0], wanted[20:32, 20:32])
