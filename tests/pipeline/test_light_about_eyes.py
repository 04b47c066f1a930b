"""How much of a light reaches an eye: what relief and network agree on, at the iris and nowhere else."""

import numpy as np
import pytest
import torch

from relight_core.face.crop import Crop
from relight_core.face.irises import Iris
from relight_core.lighting.panorama import mean_radiance
from relight_core.lighting.relief import march_relief
from relight_core.pipeline.per_light.catchlights import light_about, sky_over, unoccluded
from relight_core.pipeline.per_light.hints import Effects
from relight_core.pipeline.per_photo.corneas import find_cornea
from relight_core.pipeline.stages import Surface

SIZE = 64
VIEW = Crop(100.0, 90.0, 400.0, 0.0)
IRISES = slice(28, 36)
"""Rows and columns of the view about the iris."""
EVEN = torch.ones(1, 16, 32, 3)


@pytest.fixture(scope="module")
def cornea():
    y, x = np.mgrid[0:180, 0:200] + 0.5
    photo = np.where(np.hypot(x - 100, y - 90) < 12, 0.03, 0.5)[..., None] * np.ones(3, np.float32)
    return find_cornea(photo.astype(np.float32), 1.0, Iris(100.0, 90.0, 12.0))


def sky(cornea, relief=None, view=VIEW):
    relief = torch.zeros(SIZE, SIZE) if relief is None else relief
    facing = torch.zeros(3, SIZE, SIZE)
    facing[2] = 1
    return sky_over(cornea, view, march_relief(relief, facing, torch.ones(SIZE, SIZE)), SIZE)


def lit(eye_sky, hidden, light=EVEN, gloss=0.3):
    """An eye under a light of which the networks take `hidden` (SIZE, SIZE) of the diffuse part for hidden."""
    albedo = torch.full((1, 3, SIZE, SIZE), 0.4)
    one = torch.ones(1, 1, SIZE, SIZE)
    surface = Surface(albedo, albedo, one.expand(1, 3, -1, -1), one, one.expand(1, 14, -1, -1), one, light)
    reflected = torch.cat([torch.full((1, 3, SIZE, SIZE), 2.0), torch.full((1, 3, SIZE, SIZE), gloss)], 1)
    effects = Effects(gloss * one, 0.4 * 2.0 * hidden[None, None])
    return light_about(eye_sky, surface, effects, reflected, light)


def test_what_the_network_takes_for_hidden_reaches_no_eye(cornea):
    plane = sky(cornea)
    for share in (0.0, 0.3, 1.0):
        eye = lit(plane, torch.full((SIZE, SIZE), share))
        np.testing.assert_allclose(eye.seen, (1 - share) * plane.seen, atol=2e-3)
        np.testing.assert_allclose(eye.evenly, 1.0, rtol=0.02)


def test_shadows_beside_the_iris_take_nothing_from_it(cornea):
    beside = torch.ones(SIZE, SIZE)
    beside[IRISES, IRISES] = 0
    plane = sky(cornea)
    np.testing.assert_allclose(lit(plane, beside).seen, plane.seen, atol=1e-4)
    assert lit(plane, 1 - beside).seen.max() < 1e-4


def test_what_relief_and_network_both_hide_is_hidden_once(cornea):
    wall = torch.zeros(SIZE, SIZE)
    wall[:, 40:] = 0.5
    walled = sky(cornea, wall)
    share = float(1 - walled.shadowed.sum() / walled.unshadowed.sum())
    assert 0.1 < share < 0.6
    np.testing.assert_allclose(lit(walled, torch.full((SIZE, SIZE), share)).seen, walled.seen, atol=1e-3)
    assert lit(walled, torch.zeros(SIZE, SIZE)).seen.max() <= 1 + 1e-6
    deeper = lit(walled, torch.full((SIZE, SIZE), 1 - (1 - share) / 2)).seen
    np.testing.assert_allclose(deeper, walled.seen / 2, atol=1e-3)


def test_of_coloured_light_each_colour_reaches_an_eye_as_far_as_it_is_there(cornea):
    light = EVEN * torch.tensor([0.5, 1.0, 2.0])
    np.testing.assert_allclose(lit(sky(cornea), torch.zeros(SIZE, SIZE), light).evenly, (0.5, 1.0, 2.0), rtol=0.02)


def test_no_light_and_an_eye_beyond_the_view_are_no_fault(cornea):
    assert np.isfinite(lit(sky(cornea), torch.zeros(SIZE, SIZE), 0 * EVEN).seen).all()
    beyond = sky(cornea, view=Crop(1000.0, 90.0, 400.0, 0.0))
    eye = lit(beyond, torch.zeros(SIZE, SIZE))
    assert not eye.seen.any()
    assert not eye.evenly.any()


def test_in_the_open_all_is_seen_and_what_comes_evenly_is_the_mean_over_the_sphere():
    light = torch.from_numpy(np.random.default_rng(0).exponential(size=(1, 16, 32, 3)).astype(np.float32))
    light[:, 0] *= 20
    eye = unoccluded(light)
    np.testing.assert_array_equal(eye.seen, np.ones((16, 32)))
    np.testing.assert_allclose(eye.evenly, mean_radiance(light[0].numpy()), rtol=1e-5)
