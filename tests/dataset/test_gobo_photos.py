"""Photos with a shadow from outside on them: what the foreign-shadow network is shown, and what it is told."""

import numpy as np
import pytest
import torch

from relight_core.dataset import gobo_photos
from relight_core.dataset.gobo_photos import GoboStream
from tests.synthetic_heads import write_balls, write_lights

SIZE = 32


@pytest.fixture
def stream(tmp_path):
    write_balls(tmp_path / "heads", 0, 2, size=SIZE)
    write_lights(tmp_path / "lights.npz", 6)
    where = (tmp_path / "heads", tmp_path / "lights.npz", "train", SIZE, 7)
    return lambda **how: iter(GoboStream(*where, pairs=2, heads_at_once=2, **how))


def some(samples, count):
    return [next(samples) for _ in range(count)]


def test_a_sample_is_a_photo_its_parts_and_what_the_shadow_leaves(stream):
    for sample in some(stream(), 12):
        shapes = {name: tuple(value.shape) for name, value in sample.items()}
        assert shapes == {
            "photo_srgb": (3, SIZE, SIZE),
            "kinds": (4, SIZE, SIZE),
            "foreign_shadow": (3, SIZE, SIZE),
            "person": (1, SIZE, SIZE),
        }
        off = sample["person"].expand(3, -1, -1) == 0
        assert off.any()
        assert (sample["foreign_shadow"][off] == 0).all()
        assert float(sample["foreign_shadow"].max()) <= 0
        assert 0 <= float(sample["photo_srgb"].min()) <= float(sample["photo_srgb"].max()) <= 1
        # A ball is all skin.
        middle = sample["kinds"][:, SIZE // 2 - 2 : SIZE // 2 + 2, SIZE // 2 - 2 : SIZE // 2 + 2]
        assert float(middle[0].min()) > 0.9
        assert float(middle[1:].max()) < 0.1


def test_a_third_has_no_shadow_and_some_are_deep(stream):
    samples = some(stream(), 90)
    deepest = np.array([float(sample["foreign_shadow"].mean(0).min()) for sample in samples])
    assert 0.2 < np.mean(deepest > -1e-3) < 0.6
    assert np.mean(deepest < -0.7) > 0.2


def test_the_photo_is_as_dark_as_is_told(stream, monkeypatch):
    """Seen by a camera that does nothing, the photo over what is told is the photo without the shadow."""
    half = np.ones((SIZE, SIZE), np.float32)
    half[:, SIZE // 2 :] = 0
    monkeypatch.setattr(gobo_photos, "taken", lambda exposed, rng: np.clip(exposed, 0, 1).astype(np.float32))
    monkeypatch.setattr(gobo_photos, "camera_gain", lambda *exposing: np.float32(0.3))
    monkeypatch.setattr(gobo_photos, "_SHADOWED_SHARE", 1.0)
    plain = some(stream_with(stream, monkeypatch, np.ones_like(half)), 20)
    shaded = some(stream_with(stream, monkeypatch, half), 20)
    for before, after in zip(plain, shaded, strict=True):
        # At the outline what lies behind is dark as well.
        person = -torch.nn.functional.max_pool2d(-before["person"][None], 5, 1, 2)[0, 0] > 0.5
        told = after["foreign_shadow"][:, person]
        ratio = ((after["photo_srgb"] + 0.005) / (before["photo_srgb"] + 0.005)).log()[:, person]
        dark = told.mean(0) < -0.05
        assert dark.any()
        # Where most is lit counts as lit.
        lit = (ratio - told)[:, dark]
        off = (lit - lit.median(1, keepdim=True).values).abs()
        assert float(off.quantile(0.9)) < 2e-3
        assert float(lit.median().abs()) < 0.2
        assert (before["foreign_shadow"].abs() < 1e-5).all()


def stream_with(stream, monkeypatch, passes):
    monkeypatch.setattr(gobo_photos, "sample_gobo", lambda relief, pool, rng: passes)
    return stream()


def test_the_stream_goes_on_where_it_is_told_to(stream):
    ahead, again = some(stream(), 61)[60], next(stream(first_batch=30))
    for name, value in ahead.items():
        np.testing.assert_array_equal(value.numpy(), again[name].numpy())
