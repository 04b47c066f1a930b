"""The lines that are drawn along the people's outlines."""

import numpy as np
import pytest

from relight_core.pipeline.per_photo.matte import Matte
from relight_core.pipeline.per_photo.person import Canvas
from relight_core.pipeline.results.outline_lines import outline_lines


def lines_of(share, photo_size):
    """The outlines of a photo that was cut out."""
    one = np.ones((1, 1), np.float32)
    matte = Matte(one, one, one[..., None] * np.ones(3), one[..., None] * np.ones(3), one, True)
    return outline_lines(Canvas(np.zeros((*share.shape, 3), np.float32), share, photo_size), matte)


def test_lines_run_where_the_matte_is_a_half_around_people_and_holes_in_the_photo_s_own_pixels():
    share = np.full((60, 40), 0.4, np.float32)
    share[10:50, 8:32] = 0.6
    share[20:30, 12:28] = 0.4
    share[2, 2] = 1.0
    hole, around = sorted(lines_of(share, (120, 120)), key=lambda line: float(np.ptp(line)))
    np.testing.assert_allclose([around.min(0), around.max(0)], [(24, 20), (96, 100)], atol=2)
    np.testing.assert_allclose([hole.min(0), hole.max(0)], [(36, 40), (84, 60)], atol=2)
    assert around.dtype == np.float32
    assert len(around) == 4
    assert lines_of(0.5 * share, (120, 120)) == []


def test_a_straight_line_has_few_points_and_a_round_one_follows_its_circle():
    y, x = np.mgrid[:80, :80] + 0.5
    (line,) = lines_of((np.hypot(x - 40, y - 40) < 30).astype(np.float32), (80, 80))
    ends = np.stack([line, np.roll(line, -1, 0)])
    middles = ends.mean(0)
    for places in (line, middles):
        assert np.hypot(*(places - 40).T) == pytest.approx(29.5, abs=1.1)
    assert 8 < len(line) < 60
