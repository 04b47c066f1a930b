"""Fitted garments: kept beside the data, read as they were written and made again where damaged; what they follow."""

from dataclasses import replace

import numpy as np
import pytest
from ball_heads import ball_head

from relight_core.dataset.garments.fitted_items import _bind, _read_cache, _write_cache
from relight_core.dataset.garments.makehuman import Item


@pytest.fixture
def cache(tmp_path):
    rng = np.random.default_rng(0)
    item = Item("long", rng.random((99, 3)), np.zeros((5, 3), np.int32), rng.random((99, 2)), None, None)
    _write_cache(tmp_path / "fitted.npz", [("hair", item)])
    return tmp_path / "fitted.npz"


def test_items_come_back(cache):
    ((kind, item),) = _read_cache(cache)
    assert (kind, item.name) == ("hair", "long")
    assert item.vertices.shape == (99, 3)
    assert item.opacity is None


def test_half_of_it_other_bytes_and_other_arrays_are_no_items(cache):
    whole = cache.read_bytes()
    for damaged in (whole[: len(whole) // 2], whole[:900] + bytes([whole[900] ^ 255]) + whole[901:], b""):
        cache.write_bytes(damaged)
        assert _read_cache(cache) is None
    np.savez(cache, others=np.zeros(3))
    assert _read_cache(cache) is None


@pytest.mark.parametrize("regions", [("face", "teeth", "head_neck"), ("teeth", "head_neck", "face")])
def test_brows_follow_the_skin_wherever_a_model_lists_its_regions(regions):
    ball = ball_head()
    region = np.full(len(ball.mean), regions.index("face"), np.uint8)
    region[::2] = regions.index("teeth")
    region[1:60:2] = regions.index("head_neck")
    model = replace(ball, vertex_region=region, region_names=regions)
    np.testing.assert_array_equal(_bind("brow", ball.mean[:9], model).anchors, np.arange(1, len(ball.mean), 2))
