"""Brims of hats, whose shadow has neither teeth nor holes."""

import numpy as np
import pytest
import torch

from relight_core.lighting.horizon import Horizon
from relight_core.pipeline.per_photo.brims import with_whole_brims

SIZE, SKIN, HAIR, HAT = 128, 1, 10, 11
BRIM, FOREHEAD = 26, slice(30, 60)
TEETH = np.array([0.30, 0.30, 0.22, 0.23, 0.22, 0.28], np.float32).repeat(4)
ACROSS = slice(40, 40 + len(TEETH))


def brim(heights=TEETH, label=HAT):
    """A hat down to its brim, of these heights, over a face; relief and parsing."""
    relief, parsing = np.zeros((SIZE, SIZE), np.float32), np.zeros((14, SIZE, SIZE), np.float32)
    relief[BRIM, ACROSS] = heights
    parsing[label, : BRIM + 1], parsing[SKIN, BRIM + 1 :] = 1, 1
    return torch.from_numpy(relief)[None, None], torch.from_numpy(parsing)[None]


def slanting():
    """A brim that falls by a row every five columns, amid a hat; relief, parsing and the row of each column."""
    relief, parsing = brim(0)
    columns = np.arange(20, 108)
    relief[0, 0, 8 + (columns - 20) // 5, columns] = 0.3
    parsing[:], parsing[0, HAT] = 0, 1
    return relief, parsing, {column: 8 + (column - 20) // 5 for column in columns}


def whole(relief, parsing):
    return with_whole_brims(relief, parsing)[0, 0].numpy()


def lit(relief, turn_deg=90.0):
    """Where a lamp of half a degree, 45 degrees above the picture's plane, reaches."""
    turn, up = np.radians([turn_deg, 45])
    lamp = float(np.cos(turn) * np.cos(up)), float(np.sin(turn) * np.cos(up)), float(np.sin(up))
    return Horizon(relief, np.ones((SIZE, SIZE), bool)).visibility(lamp, 0.5) > 0.5


def test_between_its_teeth_a_brim_is_as_high_as_the_lower_of_both():
    along = whole(*brim())[BRIM, ACROSS]
    np.testing.assert_allclose(along[9:20], 0.28, atol=1e-6)
    np.testing.assert_array_equal(along[:7], TEETH[:7])


def test_a_brim_that_rises_from_row_to_row_is_one_brim():
    relief, parsing = brim(0)
    columns = np.arange(30, 90)
    rows = BRIM - np.abs(columns - 60) // 10
    relief[0, 0, rows, columns] = torch.from_numpy(np.where(columns % 10 == 5, 0.22, 0.28).astype(np.float32))
    assert whole(relief, parsing)[rows, columns].min() == pytest.approx(0.28)


def test_the_shadow_of_a_level_brim_has_no_teeth():
    relief, parsing = brim()
    ends = [(~lit(height)[BRIM + 1 : 80, ACROSS]).sum(0) for height in (relief[0, 0].numpy(), whole(relief, parsing))]
    assert np.ptp(ends[0]) >= 4
    assert np.ptp(ends[1]) <= 2


def test_a_hat_keeps_gaps_that_are_wide_and_fills_deep_ones_a_little():
    wide = np.r_[np.full(5, 0.3), np.full(45, 0.2), np.full(5, 0.3)].astype(np.float32)
    relief, parsing = brim(0)
    relief[0, 0, BRIM, 30:85] = torch.from_numpy(wide)
    np.testing.assert_allclose(whole(relief, parsing)[BRIM, 40:75], 0.2, atol=1e-6)
    deep = np.where(np.arange(len(TEETH)) // 6 == 1, 0.1, 0.3).astype(np.float32)
    np.testing.assert_allclose(whole(*brim(deep))[BRIM, ACROSS][7:11], 0.2, atol=1e-6)


@pytest.mark.parametrize("turn_deg", [50.0, 70.0, 90.0, 130.0])
def test_the_shadow_of_a_brim_that_slants_has_no_holes(turn_deg):
    relief, parsing, rows = slanting()
    reached = lit(whole(relief, parsing), turn_deg)
    for column in range(45, 85):
        below = reached[rows[column] + 2 :, column]
        assert not below[0]
        assert np.count_nonzero(np.diff(below)) == 1


def test_rows_of_the_hat_above_a_brim_are_as_high_as_it_and_none_below():
    raised = whole(*brim(0.3))[:, ACROSS.start - 1 : ACROSS.stop + 1]
    np.testing.assert_array_equal(raised[BRIM - 4 : BRIM], np.float32(0.3))
    np.testing.assert_array_equal(raised[BRIM, 1:-1], np.float32(0.3))
    assert raised[: BRIM - 4].max() == raised[BRIM + 1 :].max() == 0


def test_what_is_no_brim_of_a_hat_keeps_its_height():
    for heights, label in ((TEETH, SKIN), (TEETH, HAIR), (0.02, HAT)):
        relief, parsing = brim(heights, label)
        np.testing.assert_array_equal(whole(relief, parsing), relief[0, 0])
    relief, parsing = brim()
    assert (whole(relief, parsing) - relief[0, 0].numpy()).min() == 0
    round_hat = 0.3 - 0.2 * np.linspace(-1, 1, SIZE, dtype=np.float32)[:, None].repeat(SIZE, 1) ** 2
    parsing[:], parsing[0, HAT] = 0, 1
    np.testing.assert_array_equal(whole(torch.from_numpy(round_hat)[None, None], parsing), round_hat)
