"""The shipped networks and one small portrait, loaded once: what is attacked here is the whole pipeline."""

import numpy as np
import pytest
from skimage.data import astronaut

from relight_core.imaging.photo import Photo
from relight_core.imaging.resampling import resize_area
from relight_core.pipeline.relighter import Relighter


@pytest.fixture(scope="session")
def portrait():
    """The sample portrait's upper half, 192 x 288."""
    whole = Photo.from_srgb(astronaut()).linear
    return Photo(np.ascontiguousarray(resize_area(whole[:288, 60:380], (192, 213))))


@pytest.fixture(scope="session")
def relighter(portrait):
    relighter = Relighter()
    relighter.set_portrait(portrait)
    return relighter
