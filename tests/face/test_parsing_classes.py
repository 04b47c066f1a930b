"""The classes of a parsing, and shares of several."""

import torch

from relight_core.face.parsing import (
    CLASSES,
    FACE_LABELS,
    KINDS,
    MIRRORED,
    PALETTE_SRGB,
    PAPER_CLASSES,
    likely,
    share_of,
    skin_share,
    with_neck_as,
)

SKIN, NOSE, LIPS, NECK, HAIR = 1, 6, 8, 9, 10


def test_the_face_is_the_papers_eight_regions():
    paper = {"skin", "left_brow", "right_brow", "left_eye", "right_eye", "nose", "inner_mouth", "lips"}
    assert set(PAPER_CLASSES) == paper
    assert {CLASSES[label] for label in FACE_LABELS} == paper
    assert CLASSES.index("left_brow") == 2
    assert CLASSES.index("left_eye") == 4


def test_a_mirror_swaps_left_and_right_and_nothing_else():
    for label, mirrored in enumerate(MIRRORED):
        assert MIRRORED[mirrored] == label
        name, other = CLASSES[label], CLASSES[mirrored]
        if name.startswith(("left_", "right_")):
            assert other.partition("_")[2] == name.partition("_")[2]
        assert (other != name) == name.startswith(("left_", "right_"))


def test_every_class_but_the_background_is_of_one_kind_and_each_has_a_colour():
    assert sorted(name for kind in KINDS for name in kind) == sorted(CLASSES[1:])
    assert len(set(PALETTE_SRGB)) == len(CLASSES)


def test_skin_is_that_of_face_nose_and_neck_and_never_more_than_all():
    parsing = torch.zeros(1, 14, 1, 3)
    parsing[0, [SKIN, NOSE, NECK], 0, 0] = torch.tensor([0.5, 0.2, 0.1])
    parsing[0, [LIPS, HAIR], 0, 1] = 0.5
    parsing[0, [SKIN, NOSE], 0, 2] = 0.5001
    torch.testing.assert_close(skin_share(parsing), torch.tensor([[[[0.8, 0.0, 1.0]]]]))
    torch.testing.assert_close(share_of(parsing, ("lips", "hair")), torch.tensor([[[[0.0, 1.0, 0.0]]]]))


def test_a_class_is_likely_from_half_of_all_to_three_times_the_rest():
    told = likely(torch.tensor([0.0, 0.5, 0.625, 0.75, 1.0]))
    torch.testing.assert_close(told, torch.tensor([0.0, 0.0, 0.5, 1.0, 1.0]))


def test_neck_becomes_another_class_in_a_copy_and_probabilities_sum_to_one():
    parsing = torch.zeros(1, 14, 2, 2)
    parsing[:, NECK], parsing[:, HAIR] = 0.9, 0.1
    changed = with_neck_as(parsing, "hair", torch.full((1, 1, 2, 2), 0.6))
    torch.testing.assert_close(changed[:, NECK], torch.full((1, 2, 2), 0.3))
    torch.testing.assert_close(changed[:, HAIR], torch.full((1, 2, 2), 0.7))
    torch.testing.assert_close(changed.sum(1), torch.ones(1, 2, 2))
    torch.testing.assert_close(parsing[:, NECK], torch.full((1, 2, 2), 0.9))
