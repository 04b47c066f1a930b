"""Whatever was asked for before, a picture is the one that a Relighter makes that was asked for nothing else."""

from dataclasses import replace

import numpy as np
import pytest
from tiny_relighter import EDIT, some_photo

from relight_core.lighting.environment import Environment
from relight_core.pipeline.quality import Tier

pytestmark = pytest.mark.usefixtures("small_and_seeing_faces")

PLAIN = Tier(64, 32, 32, 16, False, shadow_network=False, correction=False)


def sun(level=1.0):
    radiance = np.full((64, 128, 3), 0.05, np.float32)
    radiance[24:26, 84:86] = 500
    return Environment(Environment.from_radiance(radiance).shape, level, "sun")


def without(*effects, **settings):
    return replace(EDIT, forced_off=frozenset(effects), **settings)


def all_of(relit):
    return {"image": relit.image, **relit.channels}


def differ(one, other):
    return one.keys() != other.keys() or any(not np.allclose(one[name], other[name], atol=1e-6) for name in one)


@pytest.mark.parametrize(
    ("before", "after"),
    [
        pytest.param(without("flattening"), EDIT, id="flattening"),
        pytest.param(without("residual"), EDIT, id="residual"),
        pytest.param(without("hard_shadow"), EDIT, id="edges of shadows"),
        pytest.param(without("relief"), EDIT, id="relief"),
        pytest.param(without("correction"), EDIT, id="correction"),
        pytest.param(without("specular"), without("shadow"), id="specular for shadow"),
        pytest.param(without("sliders", shadow=0.5), replace(EDIT, shadow=0.5), id="sliders"),
        pytest.param(
            replace(EDIT, quality=PLAIN), replace(EDIT, quality=PLAIN, forced_on=frozenset({"shadow"})), id="network"
        ),
        pytest.param(replace(EDIT, channels=("shadow",)), replace(EDIT, channels=("specular",)), id="channels"),
        pytest.param(
            *(replace(EDIT, background="match", strength=strength) for strength in (0.5, 1.0)), id="strength behind"
        ),
    ],
)
def test_nothing_of_the_edit_before_is_seen(relighter, before, after):
    first, second = (all_of(relighter.relight(sun(), edit)) for edit in (before, after))
    relighter.set_portrait(some_photo())
    afresh = all_of(relighter.relight(sun(), after))
    assert differ(first, afresh)
    assert not differ(second, afresh)


def test_nothing_of_the_same_light_at_another_level_is_seen(relighter):
    first, second = (all_of(relighter.relight(sun(level), EDIT)) for level in (1.0, 2.0))
    relighter.set_portrait(some_photo())
    afresh = all_of(relighter.relight(sun(2.0), EDIT))
    assert differ(first, afresh)
    assert not differ(second, afresh)


def test_no_light_of_the_photo_before_serves_in_place_of_one_that_is_nearly_the_same(relighter):
    tolerant = replace(EDIT, tolerance=2 / 255)
    relighter.relight(sun(), tolerant)
    relighter.set_portrait(some_photo(1))
    near = Environment(sun().shape * np.float32(1.00001), 1.0, "near")
    assert not any(effect.bound for effect in relighter.relight(near, tolerant).plan)
