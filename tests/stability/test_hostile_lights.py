"""Lights that try to break the pipeline, on the shipped networks: what comes out stays finite and lawful."""

import math
from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from relight_core.imaging.photo import Photo
from relight_core.imaging.view_transform import apply_view, expose
from relight_core.lighting.environment import Environment, network_light
from relight_core.lighting.panorama import rotate
from relight_core.lighting.reflection import ReflectionTable
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.relighter import Relighter

DRAFT = Edit(quality="draft")
few = settings(deadline=None, max_examples=6)


def sun(row, column, height=64, radiance=1e6, black=0.0):
    """One texel of light in the dark."""
    panorama = np.full((height, 2 * height, 3), black, np.float32)
    panorama[row, column] = radiance
    return panorama


def noise(height=16, seed=0):
    return np.random.default_rng(seed).gamma(0.3, 1, (height, 2 * height, 3)).astype(np.float32)


def with_broken_texels():
    panorama = noise()
    panorama[3, :4] = [np.nan, np.inf, -np.inf]
    panorama[5, 7] = -1e30
    return panorama


HOSTILE = {
    "black": np.zeros((16, 32, 3), np.float32),
    "a sun ahead": sun(32, 1),
    "a sun behind": sun(32, 64),
    "a sun at the pole": sun(0, 3),
    "a sun at the other pole": sun(63, 100),
    "a sun at the seam": sun(20, 127),
    "a sun 10^30 bright": sun(20, 40, radiance=1e30),
    "one colour only": sun(24, 10) * np.float32([0, 0, 1]),
    "grey": noise()[..., 0],
    "1 x 2": np.float32([[[4, 1, 0], [0, 1, 4]]]),
    "odd": noise(23),
    "broken": with_broken_texels(),
    "of least values": np.full((16, 32, 3), 1e-45, np.float32),
    "a sun between two texels": rotate(sun(20, 100), 360 / 256),
    "of levels from 1e-8 to 1e8": noise() * np.float32(10) ** np.linspace(-8, 8, 32, dtype=np.float32)[None, :, None],
    "of greatest values": np.full((16, 32, 3), 3e38, np.float32),
}


def assert_lawful(relit):
    assert np.isfinite(relit.image).all()
    assert relit.image.min() >= 0
    for name, channel in relit.channels.items():
        assert np.isfinite(channel).all(), name
        if name != "normal":
            assert channel.min() >= 0, name
    shown = apply_view(relit.image)
    assert shown.min() >= 0
    assert shown.max() <= 1


@pytest.mark.filterwarnings("ignore:.*values set to 0")
@pytest.mark.parametrize("name", HOSTILE)
def test_everything_stays_finite_and_in_range(relighter, name):
    environment = Environment.from_radiance(HOSTILE[name], name)
    extremes = replace(DRAFT, shadow=2.0, specular=2.0, background="light")
    assert_lawful(relighter.relight(environment, DRAFT))
    assert_lawful(relighter.relight(environment, extremes))


@few
@given(st.floats(-8, 8))
def test_level_acts_exactly_as_exposure(relighter, power):
    shape = Environment.from_radiance(noise(32)).shape
    one, other = Environment(shape, 1.0), Environment(shape, 10.0**power)
    expected = relighter.relight(one, DRAFT).channels["composition"].astype(np.float64) * 10.0**power
    scaled = relighter.relight(other, DRAFT).channels["composition"]
    np.testing.assert_allclose(scaled, expected, rtol=1e-6)
    stops = power * math.log2(10)
    np.testing.assert_allclose(
        expose(scaled, 0.0), expose(expected.astype(np.float32) / 10**power, stops), rtol=1e-5, atol=1e-7
    )


@pytest.mark.parametrize("turns", [2, 5, 16])
def test_parts_of_a_turn_make_a_whole_turn(relighter, turns):
    """As the hand turns a light: by adding to the angle, not by resampling what was turned before."""
    environment = Environment.from_radiance(sun(20, 127, black=1.0))
    first = relighter.relight(environment, DRAFT).image
    yaw_deg = 0.0
    for _ in range(turns):
        yaw_deg += 360.0 / turns
    np.testing.assert_allclose(
        relighter.relight(environment, replace(DRAFT, yaw_deg=yaw_deg)).image, first, rtol=1e-4, atol=1e-5
    )


@settings(deadline=None, max_examples=20)
@given(st.integers(1, 64), st.sampled_from([16, 32, 64]))
def test_whole_texel_turns_are_a_group(parts, height):
    """n turns by 360 / n degrees, n a divisor of the width, give back the map bit for bit."""
    count = math.gcd(parts, 2 * height)
    panorama = noise(height)
    turned = panorama
    for _ in range(count):
        turned = rotate(turned, 360.0 / count)
    np.testing.assert_array_equal(turned, panorama)


def test_a_turn_in_one_go_equals_the_turned_map(relighter):
    panorama = noise(16)
    turned = relighter.relight(Environment.from_radiance(rotate(panorama, 90)), DRAFT).image
    turning = relighter.relight(Environment.from_radiance(panorama), replace(DRAFT, yaw_deg=90)).image
    np.testing.assert_allclose(turning, turned, rtol=2e-2, atol=2e-3)


@pytest.mark.parametrize("place", [(30, 127), (15, 5)], ids=["seam", "above"])
def test_half_a_degree_never_pops(relighter, place):
    """A one-texel sun, the hardest light there is, at 0.5 of mean level, as the screen shows it (sRGB)."""
    environment = Environment(Environment.from_radiance(sun(*place)).shape, 0.5)
    before = None
    for yaw_deg in np.arange(-3, 3.5, 0.5):
        shown = apply_view(relighter.relight(environment, replace(DRAFT, yaw_deg=yaw_deg)).channels["composition"])
        if before is not None:
            step = np.abs(shown - before)
            assert step.max() < 0.2
            assert np.percentile(step, 99.9) < 0.08
            assert step.mean() < 0.01
        before = shown


def test_a_split_light_sums_to_the_whole_in_every_linear_stage():
    whole = network_light(Environment.from_radiance(noise(64)))
    mask = np.random.default_rng(1).random((16, 32, 1)) < 0.5
    table = ReflectionTable()
    parts = [table.tabulate(torch.from_numpy(np.where(keep, whole, 0))[None]) for keep in (mask, ~mask)]
    torch.testing.assert_close(parts[0] + parts[1], table.tabulate(torch.from_numpy(whole)[None]), rtol=1e-5, atol=1e-6)


def test_mirroring_the_portrait_mirrors_the_light(portrait):
    """Exact in the light and in what is looked up by the normal; as far as the networks commute in the rest."""
    light = noise(32, seed=4)
    mirrored_light = Environment.from_radiance(np.ascontiguousarray(light[:, ::-1]))
    np.testing.assert_allclose(
        network_light(mirrored_light, -33.0),
        network_light(Environment.from_radiance(light), 33.0)[:, ::-1],
        rtol=1e-4,
        atol=1e-5,
    )
    results = []
    for image, environment, yaw in (
        (portrait.linear, Environment.from_radiance(light), 33.0),
        (portrait.linear[:, ::-1], mirrored_light, -33.0),
    ):
        relighter = Relighter()
        relighter.set_portrait(Photo(np.ascontiguousarray(image)))
        results.append(apply_view(relighter.relight(environment, replace(DRAFT, yaw_deg=yaw)).image))
    difference = np.abs(results[0] - results[1][:, ::-1])
    assert difference.max() < 0.4
    assert difference.mean() < 0.02
    assert np.percentile(difference, 99) < 0.2


@pytest.mark.parametrize("quality", ["draft", "live"])
def test_relighting_with_its_own_light_returns_the_photo(relighter, portrait, quality):
    """Up to the photo's detail that the networks' size does not hold, in sRGB values of [0, 1]."""
    relit = relighter.relight(relighter.estimated_light(quality), Edit(quality=quality)).image
    difference = np.abs(apply_view(relit) - apply_view(portrait.linear))
    assert difference.mean() < 0.01
    assert np.percentile(difference, 99) < 0.06


@pytest.mark.parametrize("stops", [-2, 0, 1])
def test_the_photo_s_own_light_at_another_level_is_brought_back_to_the_photo_s(relighter, portrait, stops):
    relighter.set_portrait(portrait)
    own = relighter.estimated_light("draft")
    relit = relighter.relight(replace(own, level=own.level * 2.0**stops), Edit(quality="draft"), longest_side_px=0)
    assert relit.level_as_in_photo_ev() == pytest.approx(-stops, abs=0.1)


@pytest.mark.parametrize("level", [0.0, 1e-30, 1e30])
def test_levels_beyond_all_measure_leave_stops_that_a_slider_can_hold(relighter, portrait, level):
    relighter.set_portrait(portrait)
    own = relighter.estimated_light("draft")
    relit = relighter.relight(replace(own, level=level), Edit(quality="draft"), longest_side_px=0)
    assert -4.0 <= relit.level_as_in_photo_ev() <= 4.0
