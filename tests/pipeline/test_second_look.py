"""A second look at skin: what the photo is turned into for it, and what is taken from it."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from relight_core.networks.bundle import load_bundle
from relight_core.pipeline.per_photo.second_look import evened_out, evenly_lit, take_apart, with_skin_of
from relight_core.pipeline.quality import Tier
from relight_core.pipeline.stages import Surface

SIZE = 32
SKIN, HAIR = 1, 10
TIER = Tier(64, 64, 32, 16, False, precision="fp32")


def ball_lit_from(x, albedo=0.4):
    """The front of a ball of one colour in a lamp's light: the upper half is hair, all around is background."""
    places = (np.arange(SIZE) + 0.5) / SIZE * 2.4 - 1.2
    across, up = np.meshgrid(places, -places)
    inside = across**2 + up**2 < 1
    ahead = np.sqrt(np.clip(1 - across**2 - up**2, 0.02, 1))
    normal = torch.from_numpy(np.stack([across, up, ahead]) / np.sqrt(across**2 + up**2 + ahead**2)).float()[None]
    shade = (0.3 + 0.7 * (normal[:, :1] * x + normal[:, 2:] * (1 - abs(x))).clamp_min(0)) * torch.from_numpy(inside)
    parsing = torch.zeros(1, 14, SIZE, SIZE)
    parsing[0, SKIN] = torch.from_numpy(inside & (up < 0)).float()
    parsing[0, HAIR] = torch.from_numpy(inside & (up >= 0)).float()
    parsing[:, 0] = 1 - parsing.sum(1)
    return Surface(
        photo=(albedo * shade).float().expand(1, 3, SIZE, SIZE) + 0.2 * parsing[:, :1],
        albedo=torch.full((1, 3, SIZE, SIZE), albedo),
        normal=normal,
        relief=torch.zeros(1, 1, SIZE, SIZE),
        parsing=parsing,
        person=1 - parsing[:, :1],
        source_light=torch.ones(1, 16, 32, 3),
    )


def image(tensor):
    return np.ascontiguousarray(tensor[0].permute(1, 2, 0).numpy())


def test_little_of_the_shading_is_left_and_nothing_happens_behind_the_person():
    surface = ball_lit_from(0.9)
    photo = image(surface.photo)
    evened = evenly_lit(photo, surface)
    person = surface.person[0, 0].numpy() > 0.5
    left, right = np.array_split(np.log(evened[..., 0]), 2, axis=1), np.array_split(np.log(photo[..., 0]), 2, axis=1)
    sides = np.array_split(person, 2, axis=1)
    before = right[1][sides[1]].mean() - right[0][sides[0]].mean()
    after = left[1][sides[1]].mean() - left[0][sides[0]].mean()
    assert before > 0.3
    assert abs(after) < 0.4 * before
    np.testing.assert_array_equal(evened[~person], photo[~person])


@pytest.mark.parametrize("level", [0.0, 1.0])
def test_black_and_blown_photos_stay_in_range(level):
    surface = replace(ball_lit_from(0.5), photo=torch.full((1, 3, SIZE, SIZE), level))
    evened = evenly_lit(np.full((2 * SIZE, 2 * SIZE, 3), level, np.float32), surface)
    assert np.isfinite(evened).all()
    assert evened.min() >= 0
    assert evened.max() <= 1


def test_skin_takes_the_second_look_s_variation_at_its_own_level_and_hair_nothing():
    first = ball_lit_from(0.0)
    ramp = torch.linspace(0.5, 2.0, SIZE).expand(1, 3, SIZE, SIZE)
    both = with_skin_of(first, replace(first, albedo=0.1 * ramp))
    skin, hair = (first.parsing[:, label, None].expand(1, 3, SIZE, SIZE) > 0.5 for label in (SKIN, HAIR))
    torch.testing.assert_close(both.albedo[hair], first.albedo[hair])
    assert float(both.albedo[skin].log().mean()) == pytest.approx(float(np.log(0.4)), abs=1e-3)
    row = both.albedo[0, 0, 3 * SIZE // 4]
    assert float(row[20] / row[12]) == pytest.approx(float(ramp[0, 0, 0, 20] / ramp[0, 0, 0, 12]), rel=1e-3)


def test_only_a_tier_that_looks_twice_does(weights):
    bundle = load_bundle(weights).for_inference()
    photo = np.random.default_rng(3).random((64, 64, 3), np.float32)
    once, twice = (take_apart(bundle, photo, replace(TIER, looks_twice=again), "cpu") for again in (False, True))
    assert not torch.equal(once.albedo, twice.albedo)
    assert torch.equal(once.normal, twice.normal)
    assert once.albedo.isfinite().all()
    assert twice.albedo.isfinite().all()


def test_tiers_that_look_differently_share_no_surface():
    assert TIER.surface_key != replace(TIER, looks_twice=True).surface_key


def test_many_views_at_once_are_evened_out_as_each_of_them_alone():
    surfaces = [ball_lit_from(x, albedo) for x, albedo in ((0.9, 0.4), (-0.5, 0.7))]
    names = ("albedo", "normal", "photo", "person")
    parts = {name: torch.cat([getattr(surface, name) for surface in surfaces]) for name in names}
    together = evened_out(parts["photo"], **parts)
    for number, surface in enumerate(surfaces):
        alone = evenly_lit(image(surface.photo), surface)
        np.testing.assert_allclose(image(together[number : number + 1]), alone, atol=1e-6)
