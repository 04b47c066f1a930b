"""Rows of a lat-long map averaged to texels of even width."""

import numpy as np
import pytest

from relight_core.lighting.sphere import even_rows


@pytest.mark.parametrize(("height", "width"), [(16, 32), (8, 16), (3, 6)])
def test_rows_keep_their_mean_and_turn_with_the_map(height, width):
    light = np.random.default_rng(0).random((height, width)).astype(np.float32)
    average = even_rows(height, width)
    averaged = np.einsum("ru,ruv->rv", light, average)
    assert np.allclose(averaged.mean(1), light.mean(1), atol=1e-6)
    turned = np.einsum("ru,ruv->rv", np.roll(light, 1, axis=1), average)
    assert np.allclose(turned, np.roll(averaged, 1, axis=1), atol=1e-6)


def test_a_sliver_at_the_pole_is_spread_over_a_third_of_its_row_and_one_at_the_equator_stays():
    """At the top of 16 rows a texel has sin(pi / 32) = 0.098 of the equator's width: ten of them make one."""
    light = np.zeros((16, 32), np.float32)
    light[0, 7] = light[8, 7] = 1
    averaged = np.einsum("ru,ruv->rv", light, even_rows(16, 32))
    assert averaged[0, 7] == pytest.approx(0.098, abs=1e-3)
    assert np.count_nonzero(averaged[0] > 1e-6) == 11
    assert averaged[8, 7] == pytest.approx(0.995, abs=1e-3)
