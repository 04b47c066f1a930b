"""Which parts of a face a parsing shows, and whether they lie as in one."""

import numpy as np
import pytest

from relight_core.face.crop import Crop
from relight_core.face.evidence import certainty_of_face, evidence_of_face, glimpses_of_face
from relight_core.face.parsing import INDEX

VIEW, CROP = Crop(100, 100, 128), Crop(100, 100, 64)


def parsed(**rows):
    """A map of skin with a bar of each named part at the given row of the crop, 64 pixels high."""
    labels = np.full((128, 128), INDEX["skin"])
    for name, row in rows.items():
        labels[32 + row : 36 + row, 50:78] = INDEX[name]
    return labels


@pytest.mark.parametrize(
    ("rows", "expected"),
    [
        ({"left_brow": 14, "right_eye": 24, "lips": 46}, 3),
        ({"left_brow": 14, "glasses": 24, "inner_mouth": 46}, 3),
        ({"right_brow": 14, "left_eye": 24}, 2),
        ({"glasses": 24, "lips": 46}, 2),
        ({"lips": 46}, 1),
        ({}, 0),
        ({"lips": 14, "right_eye": 24, "left_brow": 46}, 0),
        ({"left_eye": 24, "lips": 26}, 0),
    ],
)
def test_parts_that_lie_as_in_a_face_count(rows, expected):
    assert evidence_of_face(parsed(**rows), VIEW, CROP) == expected


def test_parts_beside_the_crop_and_specks_do_not_count():
    labels = parsed()
    labels[4:8, 50:78] = INDEX["left_brow"]
    labels[60, 64] = INDEX["left_eye"]
    labels[120:124, 50:78] = INDEX["lips"]
    assert evidence_of_face(labels, VIEW, CROP) == 0


def test_parts_at_the_very_top_or_bottom_of_the_crop_do_not_count():
    assert evidence_of_face(parsed(left_brow=2, right_eye=24, lips=46), VIEW, CROP) == 2
    assert evidence_of_face(parsed(left_brow=14, right_eye=24, lips=59), VIEW, CROP) == 2


@pytest.mark.parametrize(("share", "expected"), [(0.3, 0), (0.6, 3)])
def test_parts_that_lie_in_something_else_than_a_face_do_not_count(share, expected):
    labels, seen = parsed(left_brow=14, right_eye=24, lips=46), suspected(left_brow=14, right_eye=24, lips=46)
    # Hair to one side of the crop's middle; the parts lie over it.
    elsewhere = np.broadcast_to(np.arange(128) > 50 + 28 * share, (128, 128))
    labels[elsewhere & (labels == INDEX["skin"])] = INDEX["hair"]
    seen[INDEX["hair"]] = np.where(elsewhere, seen[INDEX["skin"]], 0)
    seen[INDEX["skin"]] = np.where(elsewhere, 0, seen[INDEX["skin"]])
    assert evidence_of_face(labels, VIEW, CROP) == glimpses_of_face(seen, VIEW, CROP) == expected


def test_a_crop_outside_the_view_has_no_evidence():
    assert evidence_of_face(parsed(lips=40, left_eye=20), VIEW, Crop(900, 100, 64)) == 0


def suspected(**rows):
    """Skin nearly everywhere, and one chance in five of a bar of each named part, which wins no pixel."""
    probability = np.zeros((14, 128, 128), np.float32)
    probability[INDEX["skin"]] = 1
    for name, row in rows.items():
        probability[:, 32 + row : 36 + row, 50:78] = 0
        probability[INDEX["skin"], 32 + row : 36 + row, 50:78] = 0.8
        probability[INDEX[name], 32 + row : 36 + row, 50:78] = 0.2
    return probability


def test_what_wins_no_pixel_is_a_glimpse_and_no_evidence():
    face = suspected(left_brow=14, right_eye=24, lips=46)
    assert evidence_of_face(face.argmax(0), VIEW, CROP) == 0
    assert glimpses_of_face(face, VIEW, CROP) == 3


def test_glimpses_too_must_lie_as_in_a_face():
    assert glimpses_of_face(suspected(lips=14, right_eye=24, left_brow=46), VIEW, CROP) == 0
    assert glimpses_of_face(suspected(right_eye=24, lips=46), VIEW, CROP) == 2
    assert glimpses_of_face(suspected(), VIEW, CROP) == 0
    assert glimpses_of_face(suspected(lips=40), VIEW, Crop(900, 100, 64)) == 0


@pytest.mark.parametrize(("skin", "certainty"), [(0.9, 0.9), (0.2, 0.8)])
def test_the_likeliest_class_tells_how_certain_a_face_is(skin, certainty):
    seen = np.zeros((14, 128, 128), np.float32)
    seen[INDEX["skin"]], seen[INDEX["cloth"]] = skin, 1 - skin
    assert certainty_of_face(seen, VIEW, CROP) == pytest.approx(certainty)


def test_only_the_middle_of_the_crop_has_to_be_certain():
    seen = np.full((14, 128, 128), 1 / 14, np.float32)
    seen[:, 44:84, 44:84] = 0
    seen[INDEX["skin"], 44:84, 44:84] = 1
    assert certainty_of_face(seen, VIEW, CROP) == 1
    assert certainty_of_face(seen, VIEW, Crop(900, 100, 64)) == 0


def test_a_brow_below_its_eye_or_beside_the_mouth_makes_no_face():
    assert evidence_of_face(parsed(left_eye=16, right_brow=24), VIEW, CROP) == 0
    assert evidence_of_face(parsed(left_brow=28, lips=32), VIEW, CROP) == 0


def test_an_eye_of_next_to_no_pixels_does_not_count():
    labels = parsed(lips=46)
    labels[56:58, 60:63] = INDEX["left_eye"]
    assert evidence_of_face(labels, VIEW, CROP) == 1
    labels[56:60, 60:66] = INDEX["left_eye"]
    assert evidence_of_face(labels, VIEW, CROP) == 2


def test_certainty_is_that_of_the_crops_own_middle_also_where_the_view_ends():
    probability = np.full((14, 128, 128), 0.01, np.float32)
    probability[1], probability[2, 10:40, 90:120] = 0.5, 0.9
    assert certainty_of_face(probability, VIEW, Crop(141, 61, 50)) == pytest.approx(0.9)
    assert certainty_of_face(probability, VIEW, Crop(61, 141, 50)) == pytest.approx(0.5)
    assert certainty_of_face(probability, VIEW, Crop(40, 40, 64)) == pytest.approx(0.5)
    assert certainty_of_face(probability, VIEW, Crop(900, 900, 64)) == 0
