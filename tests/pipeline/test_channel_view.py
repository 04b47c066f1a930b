"""Channels as they are shown: what is surface, and what is nothing."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import torch

from relight_core.imaging.view_transform import apply_view
from relight_core.pipeline.results.channel_view import channel_to_srgb
from relight_core.pipeline.results.channels import (
    ViewChange,
    at_level,
    effect_channels,
    fit_view,
    light_channels,
    materials_of,
    of_person,
    surface_channel,
)
from relight_core.pipeline.stages import Effects, Surface


def surface_of(person: np.ndarray) -> Surface:
    size = len(person)
    nothing = torch.zeros(1, 3, size, size)
    parsing, light = torch.zeros(1, 14, size, size), torch.ones(1, 16, 32, 3)
    share = torch.from_numpy(person.astype(np.float32))[None, None]
    return Surface(nothing, nothing, nothing, nothing[:, :1], parsing, share, light)


@pytest.mark.parametrize(
    ("normal", "shown"),
    [
        ((0.0, 0.0, 1.0), (0.5, 0.5, 1.0)),
        ((-1.0, 0.0, 0.0), (0.0, 0.5, 0.5)),
        ((0.6, 0.8, 0.0), (0.8, 0.9, 0.5)),
        ((0.0, 0.0, 0.5), (0.25, 0.25, 0.5)),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ((np.nan, np.inf, 0.0), None),
    ],
)
def test_normals_are_shown_in_colours_and_no_surface_as_black(normal, shown):
    picture = channel_to_srgb("normal", np.full((2, 3, 3), normal, np.float32))
    assert picture.shape == (2, 3, 3)
    assert np.isfinite(picture).all()
    assert picture.min() >= 0
    assert picture.max() <= 1
    if shown is not None:
        np.testing.assert_allclose(picture[1, 2], shown, atol=1e-6)


def test_channels_keep_the_person_and_nothing_behind():
    person = np.zeros((8, 8))
    person[:, 4:] = 1
    kept = of_person(np.full((32, 32, 3), (0.2, 0.4, 0.6), np.float32), surface_of(person))
    np.testing.assert_allclose(kept[:, 20:], np.broadcast_to(np.float32([0.2, 0.4, 0.6]), (32, 12, 3)), rtol=1e-6)
    assert not kept[:, :12].any()
    fading = kept[16, 12:20, 0]
    assert (np.diff(fading) >= 0).all()
    assert 0 < fading[3] < 0.2


def test_a_light_of_any_brightness_is_shown_short_of_white():
    light = np.float32([[[1.0, 0.0, 0.0], [3.0, 3.0, 3.0], [1e6, 1e6, 1e6]]])
    shown = channel_to_srgb("target_light", light)
    np.testing.assert_allclose(shown[0, :2], [[0.7354, 0.0, 0.0], [0.8808] * 3], atol=1e-3)
    assert shown.max() <= 1
    wild = channel_to_srgb("source_light", np.float32([[[np.nan, -3.0, 1.0], [-0.5, np.inf, 0.0]]]))
    np.testing.assert_allclose(wild[0, :, :2], [[0, 0], [0, 1]], atol=1e-3)


@pytest.mark.parametrize(("name", "times"), [("specular", 4.0), ("shadow", 2.0), ("composition", 1.0)])
def test_effects_are_amplified_to_be_seen(name, times):
    colour = np.broadcast_to(np.float32([0.02, 0.1, 0.2]), (2, 3, 3))
    np.testing.assert_allclose(channel_to_srgb(name, colour), apply_view(times * colour), atol=1e-6)
    np.testing.assert_allclose(channel_to_srgb(name, colour[..., 1])[1, 2], [apply_view(times * colour)[1, 2, 1]] * 3)


def shown(name, surface, photo):
    return surface_channel(name, surface, photo, np.full((8, 8, 3), 0.4, np.float32))


def test_the_albedo_channel_has_the_photo_s_detail_and_no_more_of_what_is_blown_out():
    """A mole, and a glint of many times white, on even skin."""
    surface = replace(surface_of(np.ones((8, 8))), albedo=torch.full((1, 3, 8, 8), 0.5))
    photo = np.full((64, 64, 3), 0.4, np.float32)
    photo[20, 20], photo[40, 40] = 0.2, 50.0
    albedo = shown("albedo", surface, photo)
    clipped = shown("albedo", surface, np.minimum(photo, 1))
    assert albedo[8, 50] == pytest.approx(0.5, abs=0.02)
    assert albedo[20, 20].max() < 0.4
    np.testing.assert_array_equal(albedo, clipped)
    assert albedo.max() <= 1


def test_normals_between_those_of_the_networks_are_of_unit_length():
    normal = torch.zeros(1, 3, 8, 8)
    normal[:, 0, :, :4], normal[:, 2, :, 4:] = 1, 1
    channel = shown("normal", replace(surface_of(np.ones((8, 8))), normal=normal), np.zeros((64, 64, 3), np.float32))
    np.testing.assert_allclose(np.linalg.norm(channel, axis=2), 1, atol=1e-5)
    np.testing.assert_allclose(channel[:, 4], np.tile([1, 0, 0], (64, 1)), atol=1e-5)


def test_each_place_belongs_to_the_likeliest_part():
    surface = surface_of(np.ones((8, 8)))
    surface.parsing[:, 3], surface.parsing[:, 7, :, 4:] = 0.4, 0.6
    labels = shown("parsing", surface, np.zeros((64, 64, 3), np.float32))
    assert labels.dtype == np.int32
    assert (labels[:, :28] == 3).all()
    assert (labels[:, 36:] == 7).all()


def change_of(gain, offset):
    one = np.ones((4, 4, 3), np.float32)
    return ViewChange(gain * one, offset * one, 1.0)


def test_an_exposure_is_part_of_what_multiplies_the_photo_and_of_nothing_else():
    change, photo = change_of(2.0, 0.1), np.full((4, 4, 3), 0.3, np.float32)
    assert change.of_photo_times(1.0) is change
    np.testing.assert_allclose(change.of_photo_times(1.5).apply(photo), change.apply(1.5 * photo), rtol=1e-6)
    assert change_of(1e19, 0.0).of_photo_times(1e4).gain.max() == np.float32(1e20)


def test_no_light_is_so_bright_or_dark_that_black_becomes_no_number():
    change = np.float32([-1.0, 0.0, 0.5, 1e38])
    np.testing.assert_allclose(at_level(change, 2.0), [0, 0, 1, 1e20], rtol=1e-6)
    assert at_level(change, 1e30).max() == np.float32(1e20)


@pytest.mark.parametrize(("grey", "tinted"), [(0.02, True), (5e-5, False)])
def test_what_a_light_adds_to_a_toned_photo_has_its_tone_unless_that_is_black(grey, tinted):
    """Of luminance 1, twice as red as blue."""
    tone = np.float32([1.4, 0.922, 0.65])
    photo = np.broadcast_to(np.float32(grey) * tone, (4, 4, 3))
    added = change_of(0.0, 0.1).toned(photo).apply(photo)[0, 0]
    assert added[0] / added[2] == pytest.approx(1.4 / 0.65 if tinted else 1, rel=0.02)


def effects_of(specular, shadow):
    one = torch.ones(1, 1, 8, 8)
    return Effects(specular * one, shadow * one)


def test_effects_are_shown_at_the_light_s_level_as_far_as_they_are_asked_for():
    effects = effect_channels(effects_of(0.2, 0.3), 16)
    assert {name: one.shape for name, one in effects.items()} == {"specular": (16, 16), "shadow": (16, 16)}
    change, photo = replace(change_of(2.0, 0.1), level=4.0), np.full((4, 4, 3), 0.3, np.float32)
    every = light_channels(effects, change, photo)
    assert every["specular"].max() == pytest.approx(0.8)
    assert every["shadow"].max() == pytest.approx(1.2)
    np.testing.assert_allclose(every["composition"], 0.7, rtol=1e-5)
    assert set(light_channels(effects, change, photo, ("shadow",))) == {"shadow"}
    assert set(light_channels(effects, change, photo, ("composition",))) == {"composition"}


@pytest.mark.parametrize(
    ("labels", "is_made_up_of"),
    [
        ([1, 6, 9], {"textured", "skin"}),
        ([2, 3], {"patterned", "textured", "worn"}),
        ([4, 5], {"patterned", "evenly_lit"}),
        ([7], {"patterned", "evenly_lit", "mouth"}),
        ([8], {"patterned", "evenly_lit", "textured", "mouth"}),
        ([10, 11, 13], {"patterned", "textured", "worn"}),
        ([12], {"patterned"}),
        ([0], {"textured"}),
    ],
    ids=["skin", "brows", "eyes", "inner mouth", "lips", "hair, hat, cloth", "glasses", "background"],
)
def test_what_each_part_of_a_person_does_with_light(labels, is_made_up_of):
    kinds = {"patterned", "evenly_lit", "textured", "skin", "mouth", "worn"}
    for label in labels:
        materials = materials_of(np.eye(14, dtype=np.float32)[None, label : label + 1])
        assert {name: getattr(materials, name).item() for name in kinds} == {
            n: float(n in is_made_up_of) for n in kinds
        }


@pytest.mark.parametrize(("more", "expected"), [(0.2, 0.5), (-0.2, 0.1), (-0.7, 0.0)])
def test_finer_edges_add_to_a_shadow_and_take_no_more_from_it_than_there_is(more, expected):
    edges = SimpleNamespace(more_shadow=lambda: np.full((32, 32), more, np.float32))
    shadow = effect_channels(effects_of(0.2, 0.3), 16, edges)["shadow"]
    np.testing.assert_allclose(shadow, expected, atol=1e-6)


def test_gloss_is_as_bright_as_the_specular_channel_and_of_the_light_s_colour():
    reflected = torch.tensor([0.9, 0.1, 0.1, 1.0, 0.5, 0.25])[None, :, None, None].expand(1, 6, 8, 8)
    view = SimpleNamespace(change_to=lambda relit, gloss: gloss)
    gloss = fit_view(view, reflected, effects_of(0.3, 0.0), torch.ones(1, 3, 8, 8))[4, 4]
    assert gloss[0] / gloss[2] == pytest.approx(4)
    assert float(gloss @ np.float32([0.2126, 0.7152, 0.0722])) == pytest.approx(0.3, rel=0.02)
