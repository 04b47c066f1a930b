"""Light on a baked head, against closed forms."""

import numpy as np
import pytest
from synthetic_heads import ball

from relight_core.dataset.lighting.illumination import blocked_by_itself, illuminate, reflect
from relight_core.dataset.lighting.interreflection import bounced
from relight_core.dataset.samples import channels_of, light_head, mirrored, subsample, surface_of
from relight_core.lighting.reflection import Gloss

GREY = np.array([0.2126, 0.7152, 0.0722])


def lights(*seeds):
    return np.stack([np.random.default_rng(s).gamma(0.5, 1, (16, 32, 3)).astype(np.float32) for s in seeds])


def albedo_of(head, seed=0):
    return np.random.default_rng(seed).uniform(0.05, 0.9, (len(head.normal), 3)).astype(np.float32)


def test_uniform_light_on_a_ball_gives_one_everywhere():
    head = ball()
    lit = illuminate(head, head.normal, np.ones((1, 16, 32, 3), np.float32))
    np.testing.assert_allclose(lit.irradiance_open, 1, atol=0.02)
    np.testing.assert_array_equal(lit.irradiance, lit.irradiance_open)
    np.testing.assert_array_equal(lit.specular, lit.specular_open)


def test_half_the_sky_leaves_the_middle_half_the_light():
    head = ball(dark_side="right")
    lit = illuminate(head, head.normal, np.ones((1, 16, 32, 3), np.float32))
    middle = np.abs(head.normal[:, 0]) < 0.1
    np.testing.assert_allclose(lit.irradiance[0, middle], 0.5, atol=0.1)
    assert (lit.irradiance <= lit.irradiance_open + 1e-6).all()


def test_is_linear_in_the_light():
    head = ball(dark_side="right")
    one, other = lights(1, 2)
    lit = illuminate(head, head.normal, np.stack([one, other, 2 * one + 0.5 * other]))
    for name in ("irradiance", "irradiance_open", "specular", "specular_open"):
        a, b, both = getattr(lit, name)
        np.testing.assert_allclose(both, 2 * a + 0.5 * b, rtol=1e-4, atol=1e-5)


def test_colours_do_not_mix():
    head = ball()
    red = lights(3) * np.float32([1, 0, 0])
    lit = illuminate(head, head.normal, red)
    assert lit.irradiance[..., 0].min() > 0
    assert np.abs(lit.irradiance[..., 1:]).max() == 0


def test_a_lamp_on_the_right_lights_the_right():
    head = ball()
    light = np.zeros((1, 16, 32, 3), np.float32)
    light[:, 7:9, 24] = 30
    irradiance = illuminate(head, head.normal, light).irradiance[0, :, 0]
    assert irradiance[head.normal[:, 0] > 0.5].min() > 5 * irradiance[head.normal[:, 0] < -0.3].max()


def test_reflect_with_the_paper_s_gloss_is_the_specular_of_illuminate():
    head = ball(dark_side="right")
    np.testing.assert_allclose(
        reflect(head, head.normal, lights(4), Gloss(0.6, 0.5)),
        illuminate(head, head.normal, lights(4)).specular,
        rtol=1e-5,
        atol=1e-6,
    )


@pytest.mark.parametrize("dark_side", ["", "right"])
def test_channels_add_up(dark_side):
    """image = albedo * (irradiance + bounce) + specular, and shadow = gray(unshadowed - image) where it darkens."""
    head = ball(dark_side=dark_side)
    albedo = albedo_of(head)
    lit = light_head(head, head.normal, lights(5, 6))
    for k in range(2):
        channels = channels_of(lit, albedo, k)
        light = lit.illumination
        image = channels["image"][head.covered]
        bounce = bounced(head, lit.own, albedo, light.irradiance[k])
        assert (bounce.max() > 0.01) == bool(dark_side)
        expected = albedo * (light.irradiance[k] + bounce) + light.specular[k]
        np.testing.assert_allclose(image, expected, rtol=1e-5, atol=1e-6)
        unshadowed = albedo * light.irradiance_open[k] + light.specular_open[k]
        np.testing.assert_allclose(
            channels["shadow"][head.covered], np.maximum((unshadowed - image) @ GREY, 0), rtol=1e-3, atol=1e-5
        )
        np.testing.assert_allclose(channels["specular"][head.covered], light.specular[k] @ GREY, rtol=1e-4, atol=1e-6)
        assert all((channels[name] >= 0).all() for name in ("image", "specular", "shadow"))
        assert all(
            ((channels[name] >= 0) & (channels[name] <= 1)).all() for name in ("shadow_fraction", "gloss_fraction")
        )


def test_a_ball_fills_none_of_its_sky_and_a_wall_half_of_it():
    clear, walled = ball(), ball(dark_side="right")
    np.testing.assert_array_equal(blocked_by_itself(clear, clear.normal), 0)
    blocked = blocked_by_itself(walled, walled.normal)
    np.testing.assert_allclose(blocked[np.abs(walled.normal[:, 0]) < 0.1], 0.5, atol=0.1)


def test_a_ball_has_no_shadow_and_a_blocked_one_has():
    clear, blocked = ball(), ball(dark_side="right")
    for head, least, most in ((clear, 0, 1e-5), (blocked, 0.05, 10)):
        lit = light_head(head, head.normal, lights(7))
        shadow = channels_of(lit, albedo_of(head), 0)["shadow"][head.covered].mean()
        assert least <= shadow <= most


def test_outside_the_head_everything_is_black():
    head = ball()
    lit = light_head(head, head.normal, lights(8))
    sample = channels_of(lit, albedo_of(head), 0) | surface_of(lit, albedo_of(head))
    for name, image in sample.items():
        if name != "light":
            assert np.abs(image[~head.covered]).max() == 0


def sample_of_a_ball():
    head = ball(dark_side="right")
    lit = light_head(head, head.normal, lights(9))
    albedo = albedo_of(head)
    sample = channels_of(lit, albedo, 0) | surface_of(lit, albedo)
    label = sample["label"].copy()
    label[6, 3], label[6, 12] = 2, 3  # the person's left and right brow
    return sample | {"label": label}


def test_mirrored_twice_is_the_sample_itself():
    sample = sample_of_a_ball()
    twice = mirrored(mirrored(sample))
    for name, image in sample.items():
        np.testing.assert_array_equal(twice[name], image)


def test_a_mirror_swaps_sides_of_labels_normals_and_light():
    sample = sample_of_a_ball()
    flipped = mirrored(sample)
    assert flipped["label"][6, 12] == 3
    assert flipped["label"][6, 3] == 2
    np.testing.assert_array_equal(flipped["normal"][..., 0], -sample["normal"][:, ::-1, 0])
    np.testing.assert_array_equal(flipped["light"], sample["light"][:, ::-1])


def test_a_mirrored_head_in_mirrored_light_looks_mirrored():
    head = ball()
    albedo = np.full((len(head.normal), 3), 0.5, np.float32)
    light = lights(10)
    straight = channels_of(light_head(head, head.normal, light), albedo, 0)["image"]
    in_mirror = channels_of(light_head(head, head.normal, light[:, :, ::-1]), albedo, 0)["image"]
    np.testing.assert_allclose(in_mirror[:, ::-1], straight, rtol=1e-3, atol=1e-4)


def test_subsampling_keeps_whole_pixels():
    head = ball(32)
    small = subsample(head, 2, np.random.default_rng(0))
    assert small.covered.shape == (16, 16)
    assert small.covered.sum() == len(small.normal) == len(small.label) == len(small.uv)
    rows = {tuple(row) for row in np.round(head.normal, 5).tolist()}
    assert {tuple(row) for row in np.round(small.normal, 5).tolist()} <= rows
    assert small.visible().shape == (512, len(small.normal))
    assert subsample(head, 1, np.random.default_rng(0)) is head
