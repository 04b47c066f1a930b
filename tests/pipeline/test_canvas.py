"""A photo at the size of a picture: what a smaller copy keeps of it, cut out or not."""

import numpy as np
import pytest

from relight_core.imaging.black_level import Black
from relight_core.imaging.photo import Photo
from relight_core.pipeline.per_photo.person import canvas_of, shrunk

BLACK = np.float32([0.01, 0.02, 0.03])


def photo_with(alpha=None):
    return Photo(np.full((60, 90, 3), 0.4, np.float32), alpha)


def cut_out(left, right):
    """(60, 90) alpha, so much in the left 30 columns and so much in the others."""
    alpha = np.full((60, 90), right, np.float32)
    alpha[:, :30] = left
    return alpha


@pytest.mark.parametrize("alpha", [None, cut_out(0.5, 1.0)])
def test_a_smaller_copy_knows_the_photos_size_and_what_lies_over_it(alpha):
    black = Black(BLACK, 2.0)
    canvas = canvas_of(photo_with(alpha), 30, black)
    assert canvas.size == (20, 30)
    assert canvas.photo_size == (60, 90)
    assert canvas.black is black
    seen = (0.4 - BLACK) / (1 - BLACK / 2)
    np.testing.assert_allclose(canvas.linear, np.broadcast_to(seen, (20, 30, 3)), rtol=1e-5)
    again = shrunk(canvas, 15)
    assert (again.size, again.photo_size) == ((10, 15), (60, 90))
    assert again.black is black


@pytest.mark.parametrize("longest_side_px", [None, 90, 200])
def test_a_copy_that_would_be_no_smaller_is_the_photo_itself(longest_side_px):
    photo = photo_with()
    assert canvas_of(photo, longest_side_px).linear is photo.linear
    assert canvas_of(photo, longest_side_px).size == (60, 90)


def test_a_smaller_copy_is_black_where_it_is_transparent_throughout():
    canvas = canvas_of(photo_with(cut_out(0.0, 1.0)), 30)
    assert np.abs(canvas.linear[:, :10]).max() == 0
    np.testing.assert_allclose(canvas.linear[:, 10:], 0.4, rtol=1e-5)
