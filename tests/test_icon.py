"""The program's icon, which a script beside it draws."""

import runpy

import numpy as np
from PIL import Image

from relight_core.resources import resource_path


def test_the_script_still_draws_the_icon_that_is_shown():
    draw = runpy.run_path(str(resource_path("icon", "draw_icon.py")))["draw"]
    shown = np.asarray(Image.open(resource_path("icon", "icon.png")), np.float32)
    assert np.abs(255 * draw() - shown).mean() < 1.0
