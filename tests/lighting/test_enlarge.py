"""A coarse light drawn finer."""

import numpy as np
import pytest

from relight_core.lighting.enlarge import enlarge
from relight_core.lighting.panorama import shrink
from relight_core.lighting.sphere import directions


def random_light(seed=0):
    return np.random.default_rng(seed).gamma(0.3, 4.0, (16, 32, 3)).astype(np.float32)


def test_averaged_over_the_old_texels_it_is_the_old_light():
    light = random_light()
    light[4, 7] = 5000.0
    light[9, 20:24] = 0.0
    fine = enlarge(light, 128)
    assert fine.shape == (128, 256, 3)
    assert fine.min() >= 0.0
    np.testing.assert_allclose(shrink(fine, 16), light, rtol=1e-4, atol=1e-6)


def test_no_blocks_are_left():
    rows, columns = np.mgrid[:16, :32]
    light = (1.2 + np.cos(2 * np.pi * columns / 32) * np.sin(np.pi * (rows + 0.5) / 16))[..., None].astype(np.float32)
    fine = enlarge(np.repeat(light, 3, axis=2), 256)[..., 0]
    steps = np.abs(np.diff(np.concatenate([fine, fine[:, :1]], axis=1), axis=1))
    # In blocks of 16 the largest step would be that between two old texels, 0.19.
    assert steps.max() < 0.03


def test_a_plain_light_stays_plain():
    np.testing.assert_allclose(enlarge(np.full((16, 32, 3), 0.7, np.float32), 64), 0.7, rtol=1e-5)


def test_a_lamp_at_the_seam_reaches_over_it():
    light = np.full((16, 32, 3), 0.01, np.float32)
    light[8, 0] = 1.0
    fine = enlarge(light, 128)
    assert fine[68, -2:].min() > 0.02
    np.testing.assert_allclose(fine[64:72, -3:, 0], fine[64:72, 10:7:-1, 0], rtol=1e-3)


@pytest.mark.parametrize("toward", [(0.8, 0.3, 0.5), (-0.1, -0.9, 0.3)])
def test_a_light_that_is_smooth_over_the_sphere_is_so_over_its_poles_too(toward):
    smooth = (2 + directions(256, 512) @ np.float32(toward))[..., None]
    np.testing.assert_allclose(enlarge(shrink(smooth, 16), 256), smooth, atol=0.01)


def test_only_whole_multiples():
    with pytest.raises(ValueError, match="multiple"):
        enlarge(random_light(), 100)
