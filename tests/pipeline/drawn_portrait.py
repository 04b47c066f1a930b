"""Somebody drawn before a wall, whose true matte is known."""

import numpy as np

from relight_core.face.crop import Crop
from relight_core.imaging.photo import Photo
from relight_core.pipeline.per_photo.first_matte import SeenPeople
from relight_core.pipeline.per_photo.matte import draft_matte, finish_matte

CROP = Crop(100.0, 85.0, 130.0)


def portrait(behind=(0.05, 0.1, 0.5)):
    """A head on shoulders before a wall of one colour, linear, and its true matte."""
    y, x = np.mgrid[0:240, 0:200] + 0.5
    head = np.hypot((x - 100) / 38, (y - 80) / 50) < 1
    body = (y > 120) & (np.abs(x - 100) < 30 + 0.5 * (y - 120))
    matte = (head | body).astype(np.float32)
    noise = np.random.default_rng(0).normal(1.0, 0.05, (240, 200, 1))
    linear = np.where(matte[..., None] > 0, (0.5, 0.25, 0.15), behind) * noise
    return np.maximum(linear, 0).astype(np.float32), matte


def make_matte(linear, people, alpha=None, exposure=1.0):
    """The matte of looks at people."""
    return finish_matte(draft_matte(Photo(linear, alpha), lambda: SeenPeople(people), exposure=exposure))
