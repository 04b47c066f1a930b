"""Values that have alpha in them, without it."""

import numpy as np
import pytest

from relight_core.imaging.formats.raster import Raster


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_integers_are_rounded_and_never_brighter_than_white(kind):
    white = np.iinfo(kind).max
    alpha = np.float32([[0.0, 0.25, 0.25, 1.0, 0.3]])
    values = np.array([0, white // 5, white // 2, 100, 11], kind)[None, :, None].repeat(3, -1)
    straight = Raster(values, alpha, premultiplied=True).straight
    assert straight.dtype == kind
    assert straight[0, :, 0].tolist() == [0, round((white // 5) / 0.25), white, 100, 37]


def test_floats_may_be_brighter_and_what_has_no_alpha_in_it_is_itself():
    values, alpha = np.full((1, 2, 3), 0.6, np.float32), np.float32([[0.25, 0.0]])
    np.testing.assert_allclose(Raster(values, alpha, premultiplied=True).straight[0, :, 0], [2.4, 0.6], rtol=1e-6)
    assert Raster(values, alpha).straight is values
    assert Raster(values, None, premultiplied=True).straight is values
