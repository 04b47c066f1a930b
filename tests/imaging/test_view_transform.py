"""From radiance to the screen."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from relight_core.imaging.view_transform import apply_view, expose
from tests.hostile_colours import hostile_colours


def test_displayable_colours_are_exactly_srgb():
    codes = np.arange(256) / 255
    linear = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
    shown = apply_view(np.repeat(linear[:, None], 3, 1))
    np.testing.assert_allclose(shown[:, 0], codes, atol=1e-5)
    assert apply_view(np.array([[1.0, 0.0, 0.3]]))[0, 0] == pytest.approx(1.0)


def test_one_stop_doubles_the_light():
    np.testing.assert_allclose(apply_view(np.full((1, 3), 0.2), 1.0), apply_view(np.full((1, 3), 0.4)))


def decode(srgb):
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


@given(st.tuples(*[st.floats(0.01, 1.0)] * 3), st.floats(1.0, 50.0))
def test_over_range_colours_keep_hue_and_grow_whiter(colour, gain):
    colour = np.array(colour) / max(colour)
    before = decode(apply_view(colour[None])[0])
    after = decode(apply_view(gain * colour[None])[0])
    assert after.max() == pytest.approx(1.0, abs=1e-5)
    assert (after >= before - 1e-4).all()
    # Distances from white shrink together: the mix with white keeps the hue.
    distance_before, distance_after = 1.0 - before, 1.0 - after
    if distance_before.max() > 0.05:
        share = distance_after.max() / distance_before.max()
        np.testing.assert_allclose(distance_after, share * distance_before, atol=2e-4)


def test_bright_skin_does_not_turn_yellow():
    skin = np.array([[1.0, 0.72, 0.55]]) * 1.6
    shown = decode(apply_view(skin))[0]
    clipped = np.minimum(skin[0], 1.0)
    assert shown[1] - shown[2] < 0.6 * (clipped[1] - clipped[2])


def test_the_step_past_one_is_continuous_and_brightness_never_falls():
    gains = np.linspace(0.5, 6.0, 4000)
    ramp = apply_view(gains[:, None] * np.array([1.0, 0.6, 0.3]))
    assert (np.diff(ramp, axis=0) > -1e-6).all()
    assert np.abs(np.diff(ramp, axis=0)).max() < 2.5e-3


def test_hostile_values_show_as_something():
    shown = apply_view(hostile_colours())
    assert np.isfinite(shown).all()
    assert shown.min() >= 0.0
    assert shown.max() <= 1.0
    np.testing.assert_array_equal(apply_view(np.array([[np.nan, -1.0, -np.inf]])), 0.0)
    np.testing.assert_allclose(apply_view(np.full((1, 3), np.inf)), 1.0)


def test_the_input_is_not_changed():
    linear = np.array([[np.nan, 5.0, -1.0]], np.float32)
    apply_view(linear, 1.0)
    np.testing.assert_array_equal(linear, np.array([[np.nan, 5.0, -1.0]], np.float32))


def test_exposed_radiance_stays_within_what_a_half_float_holds():
    exposed = expose(np.array([[1e-3, 3e4, np.inf]], np.float32), 8.0)
    np.testing.assert_allclose(exposed, [[0.256, 65504, 65504]], rtol=1e-6)
