"""Lights whose results are kept."""

import numpy as np

from relight_core.pipeline.per_light.kept_lights import KeptLights

LIGHT = np.random.default_rng(0).exponential(size=(16, 32, 3)).astype(np.float32)


def test_a_callers_array_that_changes_later_changes_no_kept_light():
    lights, given = KeptLights(4), LIGHT.copy()
    lights.keep("tier", lights.match("tier", given, 0.0))
    given[:] = 7.0
    np.testing.assert_array_equal(lights.match("tier", LIGHT * np.float32(1.00001), 2 / 255).radiance, LIGHT)


def test_of_kept_lights_the_nearest_serves():
    lights = KeptLights(4)
    for factor in (1.00002, 0.99999, 1.00005):
        kept = LIGHT * np.float32(factor)
        lights.keep("tier", lights.match("tier", kept, 0.0))
    served = lights.match("tier", LIGHT, 0.1)
    np.testing.assert_array_equal(served.radiance, LIGHT * np.float32(0.99999))
    assert served.name == served.radiance.tobytes()


def test_lights_that_are_forgotten_serve_nothing():
    lights = KeptLights(4)
    lights.keep("tier", lights.match("tier", LIGHT, 0.0))
    lights.clear()
    near = LIGHT * np.float32(1.00001)
    assert lights.match("tier", near, 0.1).bound == 0
    np.testing.assert_array_equal(lights.match("tier", near, 0.1).radiance, near)
