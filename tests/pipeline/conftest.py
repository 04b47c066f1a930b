"""A Relighter with tiny random networks, small tiers and a finder that sees two faces."""

import numpy as np
import pytest
from tiny_relighter import some_photo

from relight_core.face.find import FaceBox
from relight_core.imaging import photo
from relight_core.networks.bundle import load_bundle
from relight_core.pipeline import quality, stages
from relight_core.pipeline.per_photo import choosing_faces
from relight_core.pipeline.relighter import Relighter


@pytest.fixture
def small_and_seeing_faces(monkeypatch):
    tiers = {
        "draft": quality.Tier(48, 32, 32, 16, False),
        "live": quality.Tier(64, 32, 32, 16, False),
        "final": quality.Tier(96, 32, 32, 16, True),
    }
    monkeypatch.setattr(quality, "TIERS", tiers)
    # Of few shades and none of them black, these photos would pass for faded ones.
    monkeypatch.setattr(photo, "light_over", lambda *seen: np.zeros(3, np.float32))
    monkeypatch.setattr(choosing_faces, "find_faces", lambda *seen: [FaceBox(24, 20, 72, 76), FaceBox(4, 4, 20, 20)])


@pytest.fixture
def person_on_the_left(monkeypatch):
    """A person is seen in the left half of every view, and nobody in the right one."""
    left_half = np.zeros((32, 32), np.float32)
    left_half[:, :16] = 1
    monkeypatch.setattr(stages, "solid_person", lambda parsing: left_half)


@pytest.fixture
def relighter(weights, small_and_seeing_faces):
    relighter = Relighter(weights)
    relighter.set_portrait(some_photo())
    return relighter


@pytest.fixture
def bundle(weights):
    """The tiny networks as they are used."""
    return load_bundle(weights).for_inference()
