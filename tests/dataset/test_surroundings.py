"""Lights that reach a part of a head, and people beside it: in the photo, in no target."""

import numpy as np
import pytest

from relight_core.dataset.camera import photograph
from relight_core.dataset.surroundings import (
    LocalLight,
    Neighbour,
    sample_local_light,
    sample_neighbour,
    with_local_light,
    with_neighbour,
)

SIZE = 48


def head():
    """A bust in the middle that goes down to the lower border, and its radiance."""
    y, x = np.mgrid[:SIZE, :SIZE] / SIZE * 2 - 1
    covered = (np.hypot(x, y) < 0.5) | ((np.abs(x) < 0.6) & (y > 0.6))
    return covered[..., None] * np.float32([0.6, 0.4, 0.3]), covered


def test_a_local_light_adds_light_only_where_it_reaches():
    reach = np.zeros((4, 4, 1), np.float32)
    reach[:, :2] = 1
    lit = with_local_light(
        np.full((4, 4, 3), 0.2, np.float32), np.ones((4, 4, 3), np.float32), LocalLight(reach, np.float32([1, 0.5, 0]))
    )
    np.testing.assert_allclose(lit[:, 2:], 0.2)
    np.testing.assert_allclose(lit[0, 0], [1.2, 0.7, 0.2], rtol=1e-6)


@pytest.mark.parametrize("seed", range(12))
def test_sampled_local_lights_are_partial_somewhere_and_never_negative(pool, seed):
    local = sample_local_light(SIZE, pool, np.random.default_rng(seed))
    assert local.reach.shape == (SIZE, SIZE, 1)
    assert local.reach.min() >= 0
    assert local.reach.max() <= 1
    assert (local.colour > 0).all()
    assert np.isfinite(local.colour).all()


def test_local_lights_differ(pool):
    shares = [float(sample_local_light(SIZE, pool, np.random.default_rng(seed)).reach.mean()) for seed in range(20)]
    assert min(shares) < 0.3
    assert max(shares) > 0.5


@pytest.mark.parametrize("seed", range(12))
def test_a_neighbour_leaves_the_middle_to_the_sitter(seed):
    radiance, covered = head()
    neighbour = sample_neighbour(radiance, covered, np.random.default_rng(seed))
    assert neighbour.coverage.shape == (SIZE, SIZE, 1)
    assert neighbour.coverage.min() >= -1e-6
    assert neighbour.coverage.max() <= 1 + 1e-6
    assert neighbour.coverage[:, SIZE // 2].mean() < 0.6 * max(neighbour.coverage.mean(0).max(), 0.05)


def test_a_neighbours_bust_goes_on_to_the_lower_border():
    """Where the shrunk picture of them ends within ours, nobody is cut off in the air."""
    radiance, covered = head()
    seen = 0
    for seed in range(20):
        coverage = sample_neighbour(radiance, covered, np.random.default_rng(seed)).coverage[..., 0]
        columns = coverage.max(0) > 0.9
        seen += columns.any()
        assert (coverage[-1, columns] > 0.3).all() or not columns.any()
    assert seen > 5


def test_behind_is_the_background_where_nobody_is():
    background = np.full((2, 2, 3), 0.5, np.float32)
    gain = np.float32([2, 2, 2])
    assert with_neighbour(background, None, gain) is background
    coverage = np.float32([[[0], [1]], [[0.5], [0]]])
    mixed = with_neighbour(background, Neighbour(coverage * np.float32([0.1, 0.1, 0.1]), coverage), gain)
    np.testing.assert_allclose(mixed[..., 0], [[0.5, 0.2], [0.35, 0.5]], rtol=1e-6)


def test_a_neighbour_is_seen_in_the_photo_and_the_sitter_stays(pool):
    radiance, covered = head()
    everyone = Neighbour(np.zeros((SIZE, SIZE, 3), np.float32), np.ones((SIZE, SIZE, 1), np.float32))
    light = np.ones((16, 32, 3), np.float32)
    photos = [
        photograph(radiance, covered, light, 0.5, pool, np.random.default_rng(7), neighbour=neighbour)
        for neighbour in (None, everyone)
    ]
    middle = photos[1][20:28, 20:28]
    np.testing.assert_allclose(photos[0][20:28, 20:28], middle, atol=0.1)
    assert photos[1][2:6, 2:6].max() < 0.15
