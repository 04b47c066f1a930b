"""The view of a face that the networks see."""

import numpy as np
import pytest

from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.pipeline.per_photo.portrait import frame


@pytest.mark.parametrize(("x", "y"), [(20, 30), (130, 20), (70, 60), (140, 150)])
def test_a_view_is_wider_than_its_crop_and_shows_nothing_beyond_the_photo(x, y):
    portrait = frame(Photo(np.full((240, 200, 3), 0.4, np.float32)), FaceBox(x, y, x + 40, y + 56))
    x0, y0, x1, y1 = portrait.view.window
    assert 0 <= x0 < x1 <= 200
    assert 0 <= y0 < y1 <= 240
    assert portrait.view.side == round(min(1.7 * portrait.crop.side, 200))


def test_a_face_as_large_as_its_photo_is_seen_whole_and_no_wider():
    portrait = frame(Photo(np.full((120, 100, 3), 0.4, np.float32)), FaceBox(10, 20, 90, 110))
    assert portrait.view.side == round(portrait.crop.side)
    assert portrait.crop.side > 100
