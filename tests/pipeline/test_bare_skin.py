"""Where a relief is trusted with a shadow's details: well within face and neck, and not in the mouth."""

import pytest
import torch

from relight_core.face.parsing import INDEX
from relight_core.pipeline.per_light.bare_skin import bare_skin

SIZE = 32


def parsed(*parts, fill="skin"):
    """A parsing of one class with rows of others, (name, rows)."""
    labels = torch.full((SIZE, SIZE), INDEX[fill])
    for name, rows in parts:
        labels[rows] = INDEX[name]
    return torch.nn.functional.one_hot(labels, len(INDEX)).permute(2, 0, 1)[None].float()


@pytest.mark.parametrize("name", ["skin", "nose", "neck", "left_eye", "right_brow"])
def test_face_and_neck_are_trusted_up_to_the_views_border(name):
    assert (bare_skin(parsed(fill=name)) == 1).all()


@pytest.mark.parametrize("name", ["background", "hair", "lips", "inner_mouth", "cloth"])
def test_mouth_and_all_that_is_not_skin_is_not(name):
    assert not bare_skin(parsed(fill=name)).any()


@pytest.mark.parametrize("name", ["hair", "lips", "cloth", "background"])
def test_within_two_pixels_of_its_edge_skin_is_trusted_less_and_less(name):
    column = bare_skin(parsed((name, slice(16, None))))[0, 0, :, 5]
    assert (column[:14] == 1).all()
    assert column[14:17].tolist() == pytest.approx([0.6, 0.2, 0.0], abs=1e-5)
    assert (column[16:] == 0).all()


def test_between_skin_nose_and_neck_there_is_no_edge():
    assert (bare_skin(parsed(("nose", slice(10, 14)), ("neck", slice(24, None)))) == 1).all()


def test_doubtful_skin_is_trusted_as_far_as_it_is_likelier_than_not():
    half = 0.75 * parsed() + 0.25 * parsed(fill="hair")
    torch.testing.assert_close(bare_skin(half), torch.full((1, 1, SIZE, SIZE), 0.5))
    assert not bare_skin(0.5 * parsed() + 0.5 * parsed(fill="hair")).any()
