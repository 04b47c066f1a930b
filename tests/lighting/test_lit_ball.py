"""The ball that shows a light: matt where a card is, shiny as varnish, and its highlights where a mirror has them."""

import numpy as np
import pytest

from relight_core.lighting.environment import Environment
from relight_core.lighting.preview import ball_tables, lit_ball
from relight_core.lighting.sphere import directions, solid_angles

SIZE = 96
REC709 = np.array([0.2126, 0.7152, 0.0722])


def lamp(toward, rows=64, radius_deg=4.0):
    toward = np.array(toward) / np.linalg.norm(toward)
    lit = directions(rows, 2 * rows) @ toward > np.cos(np.radians(radius_deg))
    return Environment.from_radiance(lit[..., None] * np.ones(3, np.float32))


def in_units_of_its_radius():
    """(SIZE, SIZE) to the right and up of the ball's middle, and how far from it."""
    steps = (np.arange(SIZE) + 0.5) * 2 / SIZE - 1
    x, y = np.meshgrid(steps, -steps)
    return x, y, np.hypot(x, y)


def test_even_light_makes_it_brighter_toward_its_rim_as_varnish_is():
    """A card of albedo 0.7 under a coat that mirrors 5 % straight ahead and everything at the rim."""
    even = Environment.from_radiance(np.ones((16, 32, 3), np.float32))
    row = lit_ball(even, SIZE)[SIZE // 2, :, 1]
    _, _, radius = (part[SIZE // 2] for part in in_units_of_its_radius())
    mirrored = 0.05 + 0.95 * (1 - np.sqrt(np.clip(1 - radius**2, 0, 1))) ** 5
    inside = radius < 0.97
    np.testing.assert_allclose((row / row[SIZE // 2])[inside], ((0.7 + mirrored) / 0.75)[inside], rtol=0.02)


@pytest.mark.parametrize("toward", [(1, 0, 0), (-0.8, 0, 0.6), (0, 0.9, 0.5), (0.5, -0.5, 0.7)])
def test_a_lamp_shines_in_it_halfway_to_the_camera(toward):
    image = lit_ball(lamp(toward), SIZE)[..., 1]
    halfway = np.array(toward) / np.linalg.norm(toward) + (0, 0, 1)
    halfway /= np.linalg.norm(halfway)
    x, y, radius = in_units_of_its_radius()
    bright = (image > 0.7 * image.max()) & (radius < 0.97)
    assert (x[bright].mean(), y[bright].mean()) == pytest.approx(tuple(halfway[:2]), abs=0.06)
    assert 0 < bright.sum() < 0.03 * np.pi * SIZE**2 / 4


def test_a_card_that_faces_the_light_is_as_bright_wherever_the_light_is():
    for toward in ((0, 0, 1), (1, 0, 0), (0.2, 0.3, -1)):
        matt, _ = ball_tables(lamp(toward))
        at = directions(*matt.shape[:2])
        brightest = np.unravel_index((matt @ REC709).argmax(), matt.shape[:2])
        assert (matt @ REC709).max() == pytest.approx(0.85, rel=1e-4)
        assert at[brightest] @ toward > 0.97 * np.linalg.norm(toward)
        assert matt[at @ np.array(toward) < -0.3].max() < 1e-3


def test_varnish_mirrors_a_lamp_as_a_spot_and_even_light_as_it_is():
    _, gloss = ball_tables(lamp((0.4, 0.3, 1)))
    spot = (gloss[..., 1] > 0.5 * gloss[..., 1].max()) * solid_angles(*gloss.shape[:2])
    assert spot.sum() / (4 * np.pi) < 0.03
    matt, gloss = ball_tables(Environment.from_radiance(np.ones((16, 32, 3), np.float32)))
    np.testing.assert_allclose(matt, 0.85, rtol=0.02)
    np.testing.assert_allclose(gloss, 0.85 / 0.7, rtol=0.02)
