"""With the shipped networks and without the rule: a light that nearly serves changes no pixel beyond its bound."""

import numpy as np
import pytest
from skimage import data

from relight_core.imaging.photo import Photo
from relight_core.imaging.view_transform import apply_view
from relight_core.lighting.environment import Environment, network_light
from relight_core.lighting.rigs import load_rig
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.relighter import Relighter


@pytest.fixture(scope="module")
def relighter():
    relighter = Relighter()
    relighter.set_portrait(Photo.from_srgb(data.astronaut().astype(np.float32) / 255))
    return relighter


@pytest.mark.parametrize("rig", ["split", "overcast", "neon"])
@pytest.mark.parametrize("size", [1e-6, 6e-5])
def test_the_bound_holds(relighter, rig, size):
    shape = Environment.from_radiance(network_light(load_rig(rig))).shape
    signs = np.random.default_rng(0).choice([-1, 1], (16, 32, 1))
    near = Environment((shape * np.exp(size / 2 * signs)).astype(np.float32), 1.0, "near")
    edit = Edit(channels=(), tolerance=2 / 255)
    relighter.relight(Environment(shape, 1.0, rig), edit)
    reused = relighter.relight(near, edit)
    bound = max(effect.bound or 0.0 for effect in reused.plan)
    assert 0 < bound <= 2 / 255
    computed = relighter.relight(near, Edit(channels=(), tolerance=0.0))
    assert computed.stages["compose"].state == "computed"
    assert np.abs(apply_view(reused.image) - apply_view(computed.image)).max() <= bound
