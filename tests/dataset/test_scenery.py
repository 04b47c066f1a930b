"""Drawn scenes."""

import numpy as np

from relight_core.dataset.cutouts.scenery.pool import SceneryPool


def test_scenes_follow_from_their_seed(pool):
    views = [SceneryPool(pool, np.random.default_rng(4), 3).view(40, np.random.default_rng(5)) for _ in range(2)]
    np.testing.assert_array_equal(*views)


def test_views_are_radiance_and_differ(pool):
    rng = np.random.default_rng(1)
    scenery = SceneryPool(pool, rng, 20)
    views = [scenery.view(48, rng) for _ in range(30)]
    for view in views:
        assert view.shape == (48, 48, 3)
        assert view.dtype == np.float32
        assert np.isfinite(view).all()
        assert view.min() >= 0
    assert len({float(view.mean()) for view in views}) == 30
    contrast = [float(view.std() / view.mean()) for view in views]
    assert max(contrast) > 3 * min(contrast)
