"""What the data set's tests share: textures to draw from, and a library of lights."""

import numpy as np
import pytest
from synthetic_heads import write_lights

from relight_core.dataset.painting.texture import TexturePool


@pytest.fixture(scope="session")
def pool():
    return TexturePool(np.random.default_rng(0), count=2)


@pytest.fixture(scope="session")
def library(tmp_path_factory):
    """60 lights of 21 places: light n is of place n % 21."""
    path = tmp_path_factory.mktemp("lights") / "lights.npz"
    write_lights(path, 60, places=21)
    return path
