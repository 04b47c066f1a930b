"""How much gloss is left to what is dark, by itself and beside the face."""

import pytest
import torch

from relight_core.pipeline.per_photo.dull_black import gloss_of_black

SIZE = 20
SKIN, NECK, HAIR, CLOTH = 1, 9, 10, 13


def beside_a_face(label, dark, fair=None):
    """Parsing and albedo of a part of so much albedo, beside a face of so much; without one where that is None."""
    parsing, albedo = torch.zeros(1, 14, SIZE, SIZE), torch.full((1, 3, SIZE, SIZE), float(dark))
    parsing[:, label] = 1
    if fair is not None:
        parsing[:, label, 10:], parsing[:, SKIN, 10:] = 0, 1
        albedo[:, :, 10:] = fair
    return parsing, albedo


def share_of(label, dark, fair=None):
    parsing, albedo = beside_a_face(label, dark, fair)
    return float(gloss_of_black(albedo, parsing)[0, 0, 2, 2])


@pytest.mark.parametrize("label", [NECK, HAIR, CLOTH])
@pytest.mark.parametrize(("dark", "gloss"), [(0.0, 0.08), (0.015, 0.08), (0.03, 0.5), (0.045, 1.0), (0.8, 1.0)])
def test_without_a_face_what_is_darker_than_skin_has_little_gloss(label, dark, gloss):
    assert share_of(label, dark) == pytest.approx(gloss, abs=0.01)


@pytest.mark.parametrize(
    ("label", "dark", "gloss"),
    [(NECK, 0.15, 0.08), (NECK, 0.23, 0.5), (NECK, 0.3, 1.0), (HAIR, 0.04, 0.08), (HAIR, 0.07, 0.5), (CLOTH, 0.1, 1.0)],
)
def test_beside_a_fair_face_a_beard_and_dark_hair_have_little_gloss(label, dark, gloss):
    assert share_of(label, dark, 0.4) == pytest.approx(gloss, abs=0.02)


@pytest.mark.parametrize("label", [NECK, HAIR, CLOTH])
@pytest.mark.parametrize("dark", [0.005, 0.01, 0.02, 0.03, 0.05])
@pytest.mark.parametrize("fair", [0.01, 0.03, 0.06])
def test_beside_a_dark_face_nothing_has_more_gloss_than_by_itself(label, dark, fair):
    assert share_of(label, dark, fair) <= share_of(label, dark) + 1e-6


@pytest.mark.parametrize("dark", [0.02, 0.03, 0.04])
def test_a_dark_face_takes_no_gloss_from_a_neck_as_dark(dark):
    assert share_of(NECK, dark, dark) == pytest.approx(share_of(NECK, dark), abs=0.01)


def test_a_few_pale_spots_of_a_face_take_no_gloss_from_the_neck():
    parsing, albedo = beside_a_face(NECK, 0.3, 0.35)
    albedo[:, :, 12:14, 4:14] = 0.9
    assert float(gloss_of_black(albedo, parsing)[0, 0, 2, 2]) == 1


def test_every_share_is_above_none_and_at_most_all():
    noise = torch.rand(1, 3, SIZE, SIZE, generator=torch.Generator().manual_seed(0))
    parsing = torch.rand(1, 14, SIZE, SIZE, generator=torch.Generator().manual_seed(1)) ** 8
    parsing[:, SKIN, 10:] = 50
    shares = gloss_of_black(noise**4, parsing / parsing.sum(1, keepdim=True))
    assert 0.0799 < float(shares.min()) <= float(shares.max()) <= 1
