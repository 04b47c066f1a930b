"""Heights from normals, against surfaces in closed form."""

import numpy as np
import pytest

from relight_core.lighting.normal_integration import integrate_normals

SIZE = 64
AXIS = (np.arange(SIZE) + 0.5) / SIZE * 2 - 1
X, Y = np.meshgrid(AXIS, -AXIS)


def normals_of(height):
    """Normals (3, S, S) of a height over x right and y up."""
    down, right = np.gradient(height, 2 / SIZE)
    normal = np.stack([-right, down, np.ones_like(height)])
    return (normal / np.linalg.norm(normal, axis=0)).astype(np.float32)


def bump(x, y):
    return 0.3 * np.exp(-((X - x) ** 2 + (Y - y) ** 2) / 0.05)


@pytest.mark.parametrize(("x", "y"), [(0.0, 0.0), (0.3, -0.2)])
def test_a_bump_that_only_the_normals_know_comes_out(x, y):
    height = bump(x, y)
    found = integrate_normals(np.zeros((SIZE, SIZE)), normals_of(height), np.ones((SIZE, SIZE)))
    found -= found.min()
    assert np.corrcoef(found.ravel(), height.ravel())[0, 1] > 0.98
    assert np.unravel_index(found.argmax(), found.shape) == np.unravel_index(height.argmax(), height.shape)
    assert found.max() == pytest.approx(0.3, abs=0.06)


def test_a_relief_that_agrees_with_its_normals_stays():
    height = 0.2 * np.cos(2 * X) + 0.1 * Y
    found = integrate_normals(height, normals_of(height), np.ones((SIZE, SIZE)))
    np.testing.assert_allclose(found, height, atol=0.01)


def test_where_normals_are_not_trusted_the_relief_is_believed():
    height = bump(0.2, 0.1)
    toward_camera = np.stack([0 * X, 0 * X, 1 + 0 * X])
    np.testing.assert_allclose(integrate_normals(height, toward_camera, 0 * X), height, atol=1e-5)


def test_the_mean_height_is_kept():
    height = bump(0, 0)
    found = integrate_normals(height, normals_of(bump(0.4, 0.4)), np.ones((SIZE, SIZE)))
    assert found.mean() == pytest.approx(height.mean(), abs=1e-5)


def test_normals_that_look_away_stay_finite():
    normal = np.stack([0 * X + 1, 0 * X, 0 * X])
    found = integrate_normals(0 * X, normal, np.ones((SIZE, SIZE)))
    assert np.isfinite(found).all()
    assert np.abs(found).max() < 4


def test_a_slope_gain_makes_the_relief_stand_out_as_much_more():
    y, x = np.mgrid[-1:1:48j, -1:1:48j]
    bump = 0.2 * np.exp(-8 * (x**2 + y**2))
    down, right = np.gradient(bump, 2 / 47)
    normal = np.stack([-right, down, np.ones_like(bump)]) / np.sqrt(right**2 + down**2 + 1)
    trust = np.ones_like(bump)
    once, twice = (integrate_normals(np.zeros((48, 48)), normal, trust, gain) for gain in (1.0, 2.0))
    assert np.ptp(twice) == pytest.approx(2 * np.ptp(once), rel=0.02)
