"""A scalp that is darker and greyer than the face's skin has cropped hair on it; a bald head in shade is not grey."""

import numpy as np
import pytest
import torch

from relight_core.pipeline.per_photo.cropped_hair import shading, with_cropped_hair
from relight_core.pipeline.stages import Surface

SIZE, SKIN, LEFT_EYE, NECK, HAIR, HAT = 64, 1, 4, 9, 10, 11
BROWN_SKIN, HAIR_ON_IT, GLOSS_ON_IT = (0.36, 0.13, 0.09), (0.07, 0.042, 0.036), (0.5, 0.36, 0.33)
IN_SHADE = tuple(0.3 * value for value in BROWN_SKIN)
ON_SCALP = np.s_[0, :, 6:18, 6:58]


def head(scalp, eyes=True, tilted=False, cover=0.95, face=SKIN):
    """A face below a scalp of this colour, linear; all of it faces an even light ahead, or the scalp a dark back."""
    parsing, photo = torch.zeros(1, 14, SIZE, SIZE), torch.empty(1, 3, SIZE, SIZE)
    parsing[:, NECK, :24], parsing[:, SKIN, :24], parsing[:, face, 24:] = cover, 1 - cover, 1
    if eyes:
        parsing[:, face, 34, 10:26], parsing[:, LEFT_EYE, 34, 10:26] = 0, 1
    photo[:, :, 24:] = torch.tensor(BROWN_SKIN)[:, None, None]
    photo[:, :, :24] = torch.tensor(scalp)[:, None, None]
    photo = photo * torch.from_numpy(np.random.default_rng(0).normal(1, 0.03, photo.shape)).float()
    normal = torch.tensor([0.0, 0, 1])[None, :, None, None].repeat(1, 1, SIZE, SIZE)
    light, one = torch.full((1, 16, 32, 3), 0.02), torch.ones(1, 1, SIZE, SIZE)
    light[:, 4:12, :4] = light[:, 4:12, 28:] = 4
    if tilted:
        normal[:, :, :24] = torch.tensor([0.0, 0.97, 0.243])[:, None, None]
    return Surface(photo.clamp(0, 1), photo, normal, one, parsing, one, light)


def hair_on(surface):
    return with_cropped_hair(surface).parsing[ON_SCALP][HAIR]


def assert_degrees(scalps):
    shares = [float(hair_on(head(scalp)).mean()) for scalp in scalps]
    assert shares[0] == 0
    assert shares[-1] > 0.9
    assert np.abs(np.diff(shares)).max() < 0.3


def test_a_scalp_that_is_darker_and_greyer_than_skin_has_hair():
    found = with_cropped_hair(head(HAIR_ON_IT)).parsing
    assert found[ON_SCALP][HAIR].min() > 0.9
    assert found[ON_SCALP][NECK].max() < 0.05
    torch.testing.assert_close(found.sum(1), torch.ones(1, SIZE, SIZE))
    assert found[0, HAIR, 30:].max() == 0


@pytest.mark.parametrize("scalp", [BROWN_SKIN, IN_SHADE, GLOSS_ON_IT])
def test_skin_shade_and_gloss_are_no_hair(scalp):
    assert hair_on(head(scalp)).max() == 0


def test_what_the_light_hardly_reaches_may_be_dark_and_somewhat_grey():
    dim = (0.12, 0.052, 0.041)
    assert hair_on(head(dim, tilted=True)).max() == 0
    assert hair_on(head(dim)).min() > 0.8


def test_it_comes_in_by_degrees():
    bare, hair = np.log(BROWN_SKIN), np.log(HAIR_ON_IT)
    assert_degrees(np.exp(bare + part * (hair - bare)) for part in np.linspace(0, 1, 41))


def test_what_is_a_little_darker_and_much_greyer_is_hair():
    assert hair_on(head((0.16, 0.15, 0.145))).min() > 0.8


def test_what_is_dark_is_hair_by_degrees_of_how_grey_it_is():
    skin, hair = np.log(IN_SHADE), np.log(np.full(3, 0.052))
    assert_degrees(np.exp(skin + part * (hair - skin)) for part in np.linspace(0, 0.4, 41))


def test_skin_that_shows_between_stays_skin():
    before = head(HAIR_ON_IT)
    before.photo[:, :, :24, 20:44] = torch.tensor(BROWN_SKIN)[:, None, None]
    found = with_cropped_hair(before).parsing
    assert found[0, HAIR, 6:18, 29:35].max() < 0.2
    assert found[0, HAIR, 6:18, 6:14].min() > 0.9


def test_only_the_scalp_above_the_eyes_becomes_hair():
    before = head(HAIR_ON_IT)
    before.parsing[:, :, 44:], before.parsing[:, NECK, 44:] = 0, 1
    before.photo[:, :, 44:] = torch.tensor(HAIR_ON_IT)[:, None, None]
    assert with_cropped_hair(before).parsing[0, NECK, 44:].min() == 1


@pytest.mark.parametrize("missing", [{"eyes": False}, {"cover": 0.5}, {"face": HAT}])
def test_without_eyes_a_sure_scalp_or_skin_nothing_changes(missing):
    before = head(HAIR_ON_IT, **missing)
    assert torch.equal(with_cropped_hair(before).parsing, before.parsing)


@pytest.mark.parametrize("radiance", [0.0, 1.0])
def test_black_photos_and_black_lights_give_shares_in_range(radiance):
    black = head((0.0, 0.0, 0.0))
    black.photo.zero_()
    black.source_light.mul_(radiance)
    found = with_cropped_hair(black).parsing
    assert torch.isfinite(found).all()
    assert found.min() >= 0


def test_shading_is_irradiance_over_pi():
    even = head(BROWN_SKIN)
    even.source_light.fill_(2)
    torch.testing.assert_close(shading(even), torch.full((SIZE, SIZE), 2.0), rtol=0.01, atol=0)


def test_no_more_than_passed_for_scalp_becomes_hair():
    before = head(HAIR_ON_IT)
    before.parsing[:, :, :24, 20:44] = 0
    before.parsing[:, SKIN, :24, 20:44] = 1
    found = with_cropped_hair(before).parsing
    assert found[0, HAIR, 6:18, 6:14].min() > 0.8
    assert found[0, HAIR, :24, 20:44].max() == 0
    assert found.min() >= 0


def test_hair_ends_softly_below_the_eyes():
    before = head(HAIR_ON_IT)
    before.parsing[:, :, 24:, 48:] = 0
    before.parsing[:, NECK, 24:, 48:] = 1
    before.photo[:, :, 24:, 48:] = torch.tensor(HAIR_ON_IT)[:, None, None]
    down = with_cropped_hair(before).parsing[0, HAIR, :, 56]
    assert down[28] > 0.9
    assert down[36] > 0.3
    assert down[44:].max() == 0
    assert down[28:45].diff().abs().max() < 0.25


def test_a_speck_that_shines_among_hair_is_hair():
    before = head(HAIR_ON_IT)
    before.photo[:, :, 12, 32] = torch.tensor(BROWN_SKIN)
    assert hair_on(with_cropped_hair(before))[6, 26] > 0.8
