"""What a head throws on itself, against a groove of two walls and against nothing at all."""

import numpy as np
import pytest
from synthetic_heads import ball

from relight_core.dataset.baking.bake import BakedHead
from relight_core.dataset.lighting.interreflection import bounced, own_view
from relight_core.lighting.sphere import directions

SIZE = 64


def groove():
    """Two walls at right angles, open toward the camera; each pixel sees the other wall in half of its sky."""
    axis = ((np.arange(SIZE) + 0.5) / SIZE * 2 - 1).astype(np.float32)
    x = np.tile(axis, SIZE)
    side = np.sign(x)
    slope = np.sqrt(0.5)
    normal = np.stack([-side * slope, 0 * x, slope + 0 * x], 1).astype(np.float32)
    toward = directions(16, 32).reshape(-1, 3)
    other_wall = np.stack([side * slope, 0 * x, slope + 0 * x], 1)
    visible = (toward @ normal.T > 0) & (toward @ other_wall.T > 0)
    return BakedHead(
        covered=np.ones((SIZE, SIZE), bool),
        normal=normal,
        depth=np.abs(x),
        uv=np.zeros((SIZE * SIZE, 2), np.float32),
        material=np.zeros(SIZE * SIZE, np.uint8),
        label=np.ones(SIZE * SIZE, np.uint8),
        visibility=np.packbits(visible, axis=1),
    )


def thrown_back(head, albedo, irradiance):
    return bounced(head, own_view(head, head.normal), albedo, irradiance)


def test_what_sees_nothing_of_itself_gets_nothing():
    head = ball()
    white = np.ones((len(head.normal), 3), np.float32)
    np.testing.assert_array_equal(thrown_back(head, white, white), 0)


def test_a_dark_wall_is_lit_in_the_colour_of_the_one_it_faces():
    head = groove()
    left = head.normal[:, 0] > 0
    red = np.where(left[:, None], np.float32([0.8, 0.1, 0.1]), np.float32([0.5, 0.5, 0.5]))
    lit = np.repeat(left[:, None], 3, 1).astype(np.float32)
    bounce = thrown_back(head, red, lit).reshape(SIZE, SIZE, 3)
    middle = bounce[SIZE // 4 : 3 * SIZE // 4]
    near, far = middle[:, SIZE // 2 + 4], middle[:, -4]
    assert (near[:, 0] > 3 * near[:, 1]).all()
    assert near[:, 0].mean() > 2 * far[:, 0].mean()
    # A point beside an endless lit wall of albedo 0.8 gets 0.8 times the half of its sky that the wall fills.
    np.testing.assert_allclose(near[:, 0].mean(), 0.4, atol=0.12)
    # The lit wall looks at a black one.
    assert middle[:, SIZE // 2 - 4, 1].max() < 0.03


def test_is_linear_in_the_light_and_never_more_than_the_brightest_of_what_is_seen():
    head = groove()
    albedo = np.random.default_rng(0).uniform(0, 1, (SIZE * SIZE, 3)).astype(np.float32)
    one, other = np.random.default_rng(1).uniform(0, 2, (2, SIZE * SIZE, 3)).astype(np.float32)
    both = thrown_back(head, albedo, one) + thrown_back(head, albedo, other)
    np.testing.assert_allclose(thrown_back(head, albedo, one + other), both, rtol=1e-4, atol=1e-5)
    blocked = own_view(head, head.normal).blocked
    assert (thrown_back(head, albedo, one) <= blocked[:, None] * 2 + 1e-4).all()


@pytest.mark.parametrize("level", [0.0, 1e-12, 1e12])
def test_any_level_of_light_gives_finite_light(level):
    head = groove()
    albedo = np.full((SIZE * SIZE, 3), 0.5, np.float32)
    assert np.isfinite(thrown_back(head, albedo, np.full_like(albedo, level))).all()
