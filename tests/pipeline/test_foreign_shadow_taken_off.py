"""Shadows from outside: taken off the photo, told of, and back where the light is the photo's own."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from drawn_shadows import Says
from tiny_relighter import some_light, some_photo

from relight_core.imaging.photo import Photo
from relight_core.lighting.environment import Environment
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.per_light.residual import Residual, add_residual
from relight_core.pipeline.per_photo.foreign_shadow import without_shadow
from relight_core.pipeline.per_photo.second_look import take_apart
from relight_core.pipeline.quality import Tier
from relight_core.pipeline.stages import Composed, Effects, without_colour

TIER = Tier(64, 64, 32, 16, False, precision="fp32")


def test_what_is_taken_off_is_what_fell_and_black_stays_black():
    lit = torch.rand(1, 3, 16, 16, generator=torch.Generator().manual_seed(0))
    logs = torch.full((1, 3, 16, 16), -1.5)
    shaded = ((lit + 0.005) * logs.exp() - 0.005).clamp_min(0)
    torch.testing.assert_close(without_shadow(shaded, logs)[lit > 0.02], lit[lit > 0.02])
    assert float(without_shadow(torch.zeros_like(lit), logs).max()) < 0.02
    torch.testing.assert_close(without_shadow(lit, torch.zeros_like(logs)), lit)


@pytest.mark.parametrize("again", [False, True])
def test_a_person_is_taken_apart_as_without_it(bundle, again):
    tier = replace(TIER, looks_twice=again)
    lit = np.random.default_rng(3).uniform(0.3, 0.5, (64, 64, 3)).astype(np.float32)
    expected = take_apart(bundle, lit, tier, "cpu")
    shaded = lit.copy()
    shaded[:, :32] = (lit[:, :32] + 0.005) * np.float32(np.exp(-1)) - 0.005
    bundle.foreign_shadow = Says()
    found = take_apart(bundle, shaded, tier, "cpu")
    for name in ("photo", "albedo", "normal", "source_light"):
        torch.testing.assert_close(getattr(found, name), getattr(expected, name), rtol=1e-3, atol=1e-4)
    assert found.foreign_shadow is not None
    left = take_apart(bundle, shaded, replace(tier, takes_foreign_shadow_off=False), "cpu")
    assert left.foreign_shadow is None
    assert float((left.photo - found.photo).abs().max()) > 0.1


def test_tiers_that_treat_it_differently_share_no_surface():
    assert TIER.surface_key != replace(TIER, takes_foreign_shadow_off=False).surface_key


def test_a_grey_photo_has_a_grey_one(bundle):
    bundle.foreign_shadow = Says(-1.2, -1.0, -0.8)
    found = without_colour(take_apart(bundle, np.full((64, 64, 3), 0.3, np.float32), TIER, "cpu"))
    torch.testing.assert_close(found.foreign_shadow[0, :, 0, 0], torch.full((3,), -1.0))


def lamp(column):
    light = torch.full((1, 16, 32, 3), 0.005)
    light[:, 8, column] = 20.0
    return light


def test_it_is_back_in_the_photos_light_and_gone_in_another():
    zero, one = torch.zeros(1, 3, 4, 4), torch.zeros(1, 1, 4, 4)
    shadow = torch.full_like(zero, -1.0)
    none = Residual(zero, one + 0.2, one, one + 1, one, zero, 2.0, zero, zero, lamp(2), 1.0)
    residual, composed = replace(none, foreign_shadow=shadow), Composed(zero + 0.2, zero + 0.2)
    darker = []
    for column in (2, 3, 18):
        with_it, without = (
            add_residual(each, composed, Effects(one, one), lamp(column))[0] for each in (residual, none)
        )
        darker.append(float(((with_it + 0.005) / (without + 0.005)).log().mean()))
    assert darker[0] == pytest.approx(-1, abs=1e-4)
    # Of a lamp eleven degrees further on a tenth is left.
    assert -0.2 < darker[1] < -0.05
    assert darker[1] <= darker[2]
    assert darker[2] > -0.02


def give(relighter, network):
    relighter._shop.bundle.foreign_shadow = network
    relighter._shop.bundle.rounded().foreign_shadow = network


@pytest.fixture
def shaded(relighter):
    """The relighter with a photo whose left half lies in a shadow that its network sees."""
    give(relighter, Says())
    relighter.set_portrait(some_photo())
    return relighter


def test_the_plan_says_whether_there_is_one_and_it_can_be_left_on(shaded):
    effects = lambda edit: {effect.name: effect for effect in shaded.relight(some_light(), edit).plan}  # noqa: E731
    found = effects(Edit())["foreign_shadow"]
    assert found.state != "skipped"
    assert "taken off" in found.why
    left = effects(Edit(forced_off=frozenset({"foreign_shadow"})))["foreign_shadow"]
    assert (left.state, left.why) == ("skipped", "turned off by you")
    give(shaded, None)
    shaded.set_portrait(some_photo(1))
    none = effects(Edit())["foreign_shadow"]
    assert (none.state, none.bound) == ("skipped", 0)


def test_turned_off_and_on_the_picture_changes_and_comes_back(shaded):
    def picture(edit):
        return shaded.relight(some_light(), edit).image

    first = picture(Edit())
    assert np.abs(picture(Edit(forced_off=frozenset({"foreign_shadow"}))) - first).max() > 0.01
    np.testing.assert_array_equal(picture(Edit()), first)


def test_what_was_taken_off_is_a_channel_of_its_own_where_there_is_something(shaded):
    channels = shaded.relight(some_light(), Edit()).channels
    taken_off = channels["foreign_shadow"]
    assert taken_off.shape == channels["albedo"].shape
    assert taken_off.min() >= 0
    # A shadow of one in logs.
    assert taken_off.max() == pytest.approx(1 - np.exp(-1), abs=0.02)
    left, right = np.split(taken_off, 2, axis=1)
    assert left.mean() > 0.1
    assert right.mean() < 0.1 * left.mean()
    assert "foreign_shadow" not in shaded.relight(some_light(), Edit(channels=("albedo",))).channels
    assert "foreign_shadow" not in shaded.relight(some_light(), Edit(forced_off=frozenset({"foreign_shadow"}))).channels
    give(shaded, None)
    shaded.set_portrait(some_photo(1))
    assert "foreign_shadow" not in shaded.relight(some_light(), Edit()).channels


def test_under_its_own_light_the_photo_is_the_photo_again(shaded):
    own = shaded.estimated_light("live")
    assert isinstance(own, Environment)
    photo: Photo = some_photo()
    shown = shaded.relight(own, Edit(background="keep")).image
    face = np.s_[30:66, 34:62]
    off = np.abs(np.log((shown[face] + 0.005) / (photo.linear[face] + 0.005)))
    assert float(np.median(off)) < 0.05
