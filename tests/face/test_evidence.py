import numpy as np
import pytest

from relight_core.face.crop import Crop
from relight_core.face.evidence import evidence_of_face
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


def test_a_crop_outside_the_view_has_no_evidence():
    assert evidence_of_face(parsed(lips=40, left_eye=20), VIEW, Crop(900, 100, 64)) == 0
