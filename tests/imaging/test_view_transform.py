"""From radiance to the screen."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from relight_core.imaging.view_transform import apply_view, displayable, expose
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


def test_exposure_reaches_far_and_one_that_is_no_number_is_none():
    radiance = np.full((1, 3), 1e-9, np.float32)
    np.testing.assert_allclose(expose(radiance, 20.0), 1e-9 * 2.0**20, rtol=1e-6)
    np.testing.assert_allclose(expose(radiance, 99.0), 1e-9 * 2.0**32, rtol=1e-6)
    np.testing.assert_allclose(expose(np.ones((1, 3)), -99.0), 2.0**-32, rtol=1e-6)
    np.testing.assert_array_equal(expose(radiance, float("nan")), radiance)


def test_what_is_negative_is_nothing_unless_it_is_asked_for():
    radiance = np.float32([[-0.5, -3.0, 0.25]])
    assert expose(radiance, 1.0).tolist() == [[0.0, 0.0, 0.5]]
    assert expose(radiance, 1.0, darkest=-4.0).tolist() == [[-1.0, -4.0, 0.5]]


@pytest.mark.parametrize("colour", [(1.06, 0.2, 0.1), (0.1, 0.2, 1.06), (0.1, 1.06, 0.2)])
@pytest.mark.parametrize("weights", [(0.2126, 0.7152, 0.0722), (0.6, 0.3, 0.1)])
def test_a_colour_a_little_beyond_the_display_keeps_its_luminance(colour, weights):
    shown = displayable(np.float32([colour]), np.array(weights))
    assert shown.max() <= 1.0
    assert shown[0] @ weights == pytest.approx(np.dot(colour, weights), rel=0.005)


def test_every_grey_beyond_white_is_white():
    greys = np.geomspace(1, 65504, 3000, dtype=np.float32)[:, None].repeat(3, 1)
    with np.errstate(all="raise", under="ignore"):
        np.testing.assert_allclose(displayable(greys), 1.0, atol=1e-6)
