"""Where in a parsing some classes lie."""

import numpy as np
import pytest
import torch

from relight_core.face.parsing import middle_row

LEFT_EYE, RIGHT_EYE = 4, 5


def eyes_in(*rows):
    parsing = np.zeros((14, 32, 32), np.float32)
    for label, row in zip((LEFT_EYE, RIGHT_EYE), rows, strict=True):
        parsing[label, row, 8:18] = 0.5
    return parsing


@pytest.mark.parametrize("kind", [np.asarray, torch.from_numpy])
def test_it_is_the_mean_over_all_that_the_classes_cover(kind):
    assert middle_row(kind(eyes_in(10, 13)), ("left_eye", "right_eye"), 4) == pytest.approx(11.5)
    assert middle_row(kind(eyes_in(10, 13)), ("right_eye",), 4) == pytest.approx(13)


def test_too_few_pixels_and_what_is_not_a_number_say_nothing():
    assert middle_row(eyes_in(10, 13), ("left_eye", "right_eye"), 10) is None
    assert middle_row(eyes_in(10, 13), ("glasses",), 0) is None
    assert middle_row(np.full((14, 32, 32), np.nan, np.float32), ("left_eye",), 4) is None
