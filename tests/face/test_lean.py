"""How far a head leans, read off its parsing map."""

import numpy as np
import pytest

from relight_core.face.lean import remaining_roll
from relight_core.face.parsing import INDEX


def leaning(roll_deg, without=()):
    """A face of discs whose own left is on the right of the picture, turned counterclockwise by the roll."""
    labels = np.zeros((128, 128), np.int64)
    angle = np.radians(roll_deg)
    y, x = np.mgrid[0:128, 0:128]
    for name, across, up in (
        ("right_eye", -14, 4),
        ("left_eye", 14, 4),
        ("right_brow", -15, 13),
        ("left_brow", 15, 13),
    ):
        if name in without:
            continue
        centre = 64 + across * np.cos(angle) - up * np.sin(angle), 64 - across * np.sin(angle) - up * np.cos(angle)
        labels[np.hypot(x - centre[0], y - centre[1]) < 3.5] = INDEX[name]
    return labels


@pytest.mark.parametrize("roll_deg", [0, 8, -8, 22, -30])
def test_the_lean_is_the_eyes_and_brows(roll_deg):
    assert remaining_roll(leaning(roll_deg)) == pytest.approx(roll_deg, abs=1.5)


@pytest.mark.parametrize("without", [("left_eye",), ("left_brow", "right_brow")])
def test_eyes_or_brows_are_enough(without):
    assert remaining_roll(leaning(20, without)) == pytest.approx(20, abs=1.5)


@pytest.mark.parametrize("without", [("left_eye", "left_brow"), ("left_eye", "right_brow")])
def test_where_one_side_is_out_of_sight_nothing_is_said(without):
    assert remaining_roll(leaning(20, without)) == 0.0


def test_an_absurd_lean_is_not_believed():
    assert remaining_roll(leaning(80)) == 0.0
    assert remaining_roll(np.zeros((16, 16), np.int64)) == 0.0


def test_eyes_of_few_pixels_are_enough():
    labels = np.zeros((64, 64), np.int64)
    labels[30:32, 20:22], labels[22:24, 40:42] = INDEX["right_eye"], INDEX["left_eye"]
    assert remaining_roll(labels) == pytest.approx(np.degrees(np.arctan2(8, 20)), abs=0.1)


def test_eyes_and_brows_that_disagree_meet_halfway():
    eyes, brows = leaning(0, ("left_brow", "right_brow")), leaning(20, ("left_eye", "right_eye"))
    assert remaining_roll(np.where(eyes > 0, eyes, brows)) == pytest.approx(10, abs=2)
