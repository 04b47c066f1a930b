"""Drawn shadows with edges: what of a lamp gets past something to each pixel of a head."""

import numpy as np
import pytest

from relight_core.dataset.lighting.gobos import sample_gobo

SIZE = 64


def gobo(pool, seed, relief=None):
    relief = np.zeros((SIZE, SIZE), np.float32) if relief is None else relief
    return sample_gobo(relief, pool, np.random.default_rng(seed))


@pytest.mark.parametrize("seed", range(20))
def test_it_takes_some_share_of_a_lamp(pool, seed):
    passes = gobo(pool, seed)
    assert passes.shape == (SIZE, SIZE)
    assert passes.dtype == np.float32
    assert 0 <= passes.min() <= passes.max() <= 1


def test_most_have_a_shadow_and_a_lit_place_in_view_and_some_have_sharp_edges(pool):
    drawn = [gobo(pool, seed) for seed in range(60)]
    both = [passes.min() < 0.2 and passes.max() > 0.8 for passes in drawn]
    steepest = [max(np.abs(np.diff(passes, axis=axis)).max() for axis in (0, 1)) for passes in drawn]
    assert np.mean(both) > 0.7
    assert np.mean(np.array(steepest) > 0.6) > 0.3
    assert np.mean(np.array(steepest) < 0.4) > 0.15


def test_shadows_and_spots_are_as_frequent(pool):
    lit = np.mean([gobo(pool, seed).mean() for seed in range(100)])
    assert 0.35 < lit < 0.65


def test_what_stands_out_of_a_face_bends_a_shadow_and_nothing_else_does(pool):
    nose = np.zeros((SIZE, SIZE), np.float32)
    nose[24:40, 24:40] = 0.5
    moved = np.zeros(nose.shape)
    for seed in range(12):
        moved += np.abs(gobo(pool, seed, nose) - gobo(pool, seed))
    assert moved[28:36, 28:36].mean() > 0.5
    assert moved[:8].max() < 0.02
