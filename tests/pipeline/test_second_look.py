"""A second look at skin: what the photo is turned into for it, and what is taken from it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import test_cropped_hair
import test_hair_on_scalp
import test_white_hair
import torch

from relight_core.networks.bundle import load_bundle
from relight_core.pipeline import stages
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


def evened(normal, photo, albedo):
    """What becomes of a view of one colour."""
    views, of_one = torch.full((1, 3, 8, 8), photo), torch.ones(1, 1, 8, 8)
    parts = {"albedo": albedo + 0 * views, "normal": torch.tensor(normal)[None, :, None, None] * of_one}
    return float(evened_out(views, **parts, photo=views, person=of_one)[0, 0, 4, 4])


@pytest.mark.parametrize(
    ("normal", "received"),
    [
        ((0.0, 0.0, 1.0), 1.65),
        ((0.0, 0.0, -1.0), 0.35),
        ((0.0, 1.0, 0.0), 1.2),
        ((0.0, -1.0, 0.0), 0.8),
        ((1.0, 0.0, 0.0), 1.0),
    ],
)
def test_the_light_it_goes_most_of_the_way_to_comes_from_ahead_and_above(normal, received):
    # What faces the light is as bright as its albedo.
    wanted = 0.4 * received / 1.68007
    assert evened(normal, 0.2, 0.4) == pytest.approx(0.2 * (wanted / 0.2) ** 0.7, rel=1e-4)


def test_nothing_is_brightened_or_darkened_more_than_ten_times():
    ahead = (0.0, 0.0, 1.0)
    assert evened(ahead, 0.01, 0.9) == pytest.approx(0.01 * 10**0.7, rel=1e-4)
    assert evened(ahead, 1.0, 0.01) == pytest.approx(10**-0.7, rel=1e-4)
    # What a camera tells of black is mostly its noise: it counts as 0.004.
    wanted = 0.02 * 1.65 / 1.68007
    assert evened(ahead, 0.001, 0.02) == pytest.approx(0.001 * (wanted / 0.004) ** 0.7, rel=1e-4)


def test_a_cheek_loses_the_colour_of_its_light_but_a_small_patch_keeps_its_own():
    tone, blue = (torch.tensor(colour)[:, None, None] for colour in ((0.4, 0.25, 0.2), (0.1, 0.15, 0.3)))
    lit = torch.tensor((0.6, 1.0, 1.4))[:, None, None]
    photo = (0.5 * tone * lit).expand(3, 128, 128).clone()
    photo[:, 40:46, 40:46] = 0.5 * blue * lit
    parts = {
        "albedo": tone.expand(1, 3, 128, 128),
        "normal": torch.tensor((0.0, 0, 1))[:, None, None].expand(1, 3, 128, 128),
    }
    even = evened_out(photo[None], **parts, photo=photo[None], person=torch.ones(1, 1, 128, 128))[0].log()
    cheek, patch = even[:, 90, 90], even[:, 43, 43]
    # Three tenths of the light's colour are left, of ratios of 1.4 and 0.6.
    assert float((cheek[2] - cheek[0]) - (tone[2] / tone[0]).log()) == pytest.approx(0.3 * 0.8473, rel=0.01)
    # Of the patch's colour, ratios of 3 to 0.5, nearly all is.
    assert float((patch - cheek)[2] - (patch - cheek)[0]) > 0.75 * 1.7918


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


def test_without_skin_the_first_look_s_albedo_stays():
    nobody = ball_lit_from(0.0)
    nobody = replace(nobody, parsing=torch.zeros_like(nobody.parsing))
    both = with_skin_of(nobody, replace(nobody, albedo=0.1 + 0.5 * torch.rand(1, 3, SIZE, SIZE)))
    torch.testing.assert_close(both.albedo, nobody.albedo)


def test_no_skin_reflects_more_than_all_light():
    first = ball_lit_from(0.0, 0.9)
    both = with_skin_of(first, replace(first, albedo=torch.linspace(0.1, 0.9, SIZE).expand(1, 3, SIZE, SIZE)))
    assert float(both.albedo.max()) == 1


@pytest.mark.parametrize(
    "head",
    [
        test_white_hair.head(0.6),
        test_hair_on_scalp.head(test_hair_on_scalp.BROWN),
        test_cropped_hair.head((0.12, 0.06, 0.05)),
    ],
    ids=["white", "brown", "cropped"],
)
def test_hair_that_parsing_takes_for_a_scalp_is_hair_in_what_is_found(monkeypatch, head):
    monkeypatch.setattr(stages, "delight", lambda *view, **how: head)
    found = take_apart(SimpleNamespace(foreign_shadow=None), np.full((64, 64, 3), 0.3, np.float32), TIER, "cpu")
    assert float(found.parsing[:, HAIR].mean()) > float(head.parsing[:, HAIR].mean()) + 0.1


@pytest.mark.parametrize("again", [False, True])
def test_a_tier_that_looks_in_a_mirror_sees_the_same_either_way_round(weights, again):
    bundle = load_bundle(weights).for_inference()
    photo = np.random.default_rng(3).random((64, 64, 3), np.float32)
    one, other = (
        take_apart(bundle, view, replace(TIER, mirrored=True, looks_twice=again), "cpu")
        for view in (photo, np.ascontiguousarray(photo[:, ::-1]))
    )
    torch.testing.assert_close(other.albedo.flip(-1), one.albedo, rtol=1e-3, atol=1e-4)


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
