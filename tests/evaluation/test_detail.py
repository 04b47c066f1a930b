"""Comparing ways to carry a relit view to the photo's size, on balls."""

import numpy as np
import pytest
from synthetic_heads import write_balls, write_lights

from relight_core.evaluation import detail
from relight_core.evaluation.detail_methods import METHODS, DetailTask
from relight_core.evaluation.held_out import held_out_lights
from relight_core.imaging.resampling import resize_area
from relight_core.imaging.view_of_photo import Makeup


@pytest.mark.parametrize("name", METHODS)
def test_every_method_finds_a_uniform_change_of_a_smooth_photo(name):
    x = np.linspace(0.2, 0.6, 64, dtype=np.float32)
    photo = np.repeat((x[:, None] * x[None, :])[..., None], 3, axis=2)
    small = resize_area(photo, (32, 32))
    task = DetailTask(photo, small, 1.5 * small, np.zeros_like(small), Makeup.plain(32))
    result = METHODS[name](task)
    assert result.shape == photo.shape
    np.testing.assert_allclose(result, 1.5 * photo, atol=0.02)


def test_the_comparison_names_every_method_and_region(tmp_path, monkeypatch):
    monkeypatch.setattr(detail, "_NETWORK_SIZE", 16)
    write_balls(tmp_path / "heads", 2_000_000, 1, size=32)
    write_lights(tmp_path / "lights.npz", 3)
    scores = detail.compare_detail(tmp_path / "heads", tmp_path / "lights.npz", "test", 1)
    assert scores.size == 32
    assert scores.pictures == 8
    assert set(scores.errors) == set(METHODS)
    assert all(np.isfinite(errors["head"]) for errors in scores.errors.values())
    table = detail.detail_table(scores)
    assert all(name in table for name in METHODS)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_no_photo_is_relit_with_its_own_light(tmp_path, count):
    write_lights(tmp_path / "lights.npz", 3)
    lights = held_out_lights(tmp_path / "lights.npz", "test")
    few = [*lights[:count], *(light for light in lights if light.lamp)]
    chosen = detail._chosen(few, 0)
    pairs = [(chosen[source].name, chosen[target].name) for source, target in detail._pairs(chosen)]
    assert len(pairs) >= 4
    assert all(source != target for source, target in pairs)
