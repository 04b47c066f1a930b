"""Labelled pictures in a grid, and what is transparent before its ground."""

import numpy as np
import pytest

from relight_core.imaging.contact_sheet import contact_sheet, on_ground

GROUND = (24, 24, 26)


def plain(colour, height=10, width=10):
    return "", np.full((height, width, 3), colour, np.float32)


def test_pictures_lie_row_by_row_in_cells_with_room_for_a_label():
    sheet = contact_sheet([plain((1, 0, 0)), plain((0, 1, 0)), plain((0, 0, 1))], columns=2, cell_px=40)
    assert sheet.dtype == np.uint8
    assert sheet.shape == (8 + 2 * (40 + 22 + 8), 8 + 2 * (40 + 8), 3)
    assert sheet[8, 8].tolist() == sheet[47, 47].tolist() == [255, 0, 0]
    assert sheet[8, 56].tolist() == [0, 255, 0]
    assert sheet[78, 8].tolist() == [0, 0, 255]
    for y, x in ((7, 8), (8, 7), (48, 8), (8, 48), (78, 56)):
        assert tuple(sheet[y, x]) == GROUND


@pytest.mark.parametrize(("height", "width"), [(4, 8), (8, 4), (800, 400), (1, 900)])
def test_a_picture_fits_its_cell_as_wide_for_its_height_and_in_the_middle(height, width):
    sheet = contact_sheet([plain((1, 1, 1), height, width)], columns=1, cell_px=40)
    rows, columns = np.nonzero((sheet[8:48] == 255).all(-1))
    longest = max(height, width)
    assert np.ptp(rows) + 1 == max(1, round(40 * height / longest))
    assert np.ptp(columns) + 1 == max(1, round(40 * width / longest))
    assert rows.min() + rows.max() == pytest.approx(39, abs=1)
    assert columns.min() + columns.max() == pytest.approx(8 + 8 + 39, abs=1)


def test_a_label_stands_below_its_picture():
    label, picture = "Albedo", np.zeros((10, 10, 3), np.float32)
    named, unnamed = (contact_sheet([(text, picture)], columns=1, cell_px=80) for text in (label, ""))
    rows, columns = np.nonzero((named != unnamed).any(-1))
    assert rows.min() >= 88
    assert rows.max() < 88 + 22
    assert columns.min() + columns.max() == pytest.approx(2 * 48, abs=4)
    assert named[88:110].max() > 180


def test_a_picture_that_is_shrunk_is_averaged():
    stripes = np.zeros((400, 400, 3), np.float32)
    stripes[:, ::2] = 1
    shown = contact_sheet([("", stripes)], columns=1, cell_px=40)[12:44, 12:44]
    assert 110 < shown.min() <= shown.max() < 146


def test_colours_are_rounded_to_the_nearest_code_and_kept_within_range():
    sheet = contact_sheet([plain((-0.5, 99.6 / 255, 1.5))], columns=1, cell_px=10)
    assert sheet[12, 12].tolist() == [0, 100, 255]


def test_before_the_ground_light_is_mixed_and_not_codes():
    srgb, ground = np.ones((1, 3, 3), np.float32), np.array(GROUND) / 255
    seen = on_ground(srgb, np.float32([[0.0, 0.5, 1.0]]))
    np.testing.assert_allclose(seen[0, 0], ground, atol=1e-5)
    np.testing.assert_allclose(seen[0, 2], 1.0, atol=1e-5)
    np.testing.assert_allclose(seen[0, 1], [0.7386, 0.7386, 0.7389], atol=1e-3)
