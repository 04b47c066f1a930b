"""How large the engine makes the picture of a photo that is looked at whole."""

import numpy as np
import pytest
from fake_relighter import FakeRelighter, answered

from app.engine import desk
from app.engine.engine import Engine
from app.engine.sources import LightSource, PhotoSource, Request
from relight_core.imaging.photo import Photo


@pytest.mark.parametrize(("small_px", "side_px"), [(24 * 32, None), (24 * 32 - 1, 2560)])
def test_a_small_photo_is_always_shown_at_its_own_size(monkeypatch, small_px, side_px):
    monkeypatch.setattr(desk, "_SMALL_PHOTO_PX", small_px)
    relighter = FakeRelighter()
    engine = Engine(lambda: relighter)
    source = PhotoSource(Photo(np.full((24, 32, 3), 0.5, np.float32)))
    answered(engine, Request(source, LightSource("rig", "split"), longest_side_px=2560))
    engine.close()
    assert relighter.sides_px == [side_px]
