"""Hair which parsing takes for a scalp: hair where it has the colours of the head's other hair, and of no skin."""

import numpy as np
import pytest
import torch

from relight_core.pipeline.per_photo.hair_on_scalp import with_hair_on_scalp
from relight_core.pipeline.stages import Surface

SIZE, SKIN, LEFT_EYE, NECK, HAIR = 48, 1, 4, 9, 10
BROWN, PALE, SHADED = (0.03, 0.02, 0.015), (0.6, 0.42, 0.34), (0.12, 0.085, 0.07)


def head(side, skin=PALE, eyes=True, hair=True):
    """A face below hair, the right half of which is parsed as scalp and has the colour `side`; linear."""
    parsing, photo = torch.zeros(1, 14, SIZE, SIZE), torch.empty(1, 3, SIZE, SIZE)
    parsing[:, SKIN, 16:] = 1
    parsing[:, HAIR if hair else SKIN, :16, :24] = 1
    parsing[:, NECK, :16, 24:] = 0.9
    parsing[:, SKIN, :16, 24:] = 0.1
    if eyes:
        parsing[:, :, 24, 8:20] = 0
        parsing[:, LEFT_EYE, 24, 8:20] = 1
    for rows, columns, colour in ((slice(16, None), slice(None), skin), (slice(16), slice(24), BROWN)):
        photo[:, :, rows, columns] = torch.tensor(colour)[None, :, None, None]
    photo[:, :, :16, 24:] = torch.tensor(side)[None, :, None, None]
    photo = photo * torch.from_numpy(np.random.default_rng(0).normal(1, 0.03, photo.shape)).float()
    one = torch.ones(1, 1, SIZE, SIZE)
    normal, albedo = one.repeat(1, 3, 1, 1), torch.tensor(PALE)[None, :, None, None] * one
    return Surface(photo.clamp(0, 1), albedo, normal, one, parsing, one, torch.ones(1, 16, 32, 3))


def test_scalp_of_the_hair_s_colour_is_hair():
    found = with_hair_on_scalp(head(BROWN)).parsing
    assert found[0, HAIR, 2:14, 27:46].min() > 0.89
    assert found[0, NECK, 2:14, 27:46].max() < 0.01
    torch.testing.assert_close(found.sum(1), torch.ones(1, SIZE, SIZE))


@pytest.mark.parametrize("side", [PALE, SHADED])
def test_scalp_of_the_skin_s_colour_or_of_neither_stays(side):
    before = head(side)
    assert torch.equal(with_hair_on_scalp(before).parsing[0, HAIR, 2:14, 27:46], before.parsing[0, HAIR, 2:14, 27:46])


def test_where_skin_is_as_dark_as_hair_colours_say_nothing():
    before = head(BROWN, skin=BROWN)
    torch.testing.assert_close(with_hair_on_scalp(before).parsing, before.parsing)


def test_necks_below_the_eyes_stay_whatever_their_colour():
    before = head(BROWN)
    before.parsing[:, :, 30:, 24:] = 0
    before.parsing[:, NECK, 30:, 24:] = 1
    before.photo[:, :, 30:, 24:] = torch.tensor(BROWN)[:, None, None]
    assert with_hair_on_scalp(before).parsing[0, NECK, 30:, 24:].min() == 1


@pytest.mark.parametrize("missing", ["eyes", "hair"])
def test_without_eyes_or_known_hair_nothing_changes(missing):
    before = head(BROWN, **{missing: False})
    assert torch.equal(with_hair_on_scalp(before).parsing, before.parsing)


def test_a_few_pixels_of_hair_tell_nothing_of_its_colours():
    before = head(BROWN)
    before.parsing[0, HAIR], before.parsing[0, 0, :16, :24] = 0, 1
    before.parsing[0, 0, 4:8, 4:9], before.parsing[0, HAIR, 4:8, 4:9] = 0, 1
    assert torch.equal(with_hair_on_scalp(before).parsing, before.parsing)


def test_of_what_may_be_hair_or_not_no_colours_are_learnt():
    before = head(BROWN)
    before.parsing[0, HAIR, :16, :24] = before.parsing[0, 0, :16, :24] = 0.5
    assert torch.equal(with_hair_on_scalp(before).parsing, before.parsing)


def test_a_single_dark_pixel_of_a_scalp_is_no_hair():
    before = head(PALE)
    before.photo[0, :, 8, 36] = torch.tensor(BROWN)
    assert with_hair_on_scalp(before).parsing[0, HAIR, 2:14, 27:46].max() == 0
