"""What is kept of fitted garments beside the data: read as it was written, and made again where it is damaged."""

import numpy as np
import pytest

from relight_core.dataset.garments.fitted_items import _read_cache, _write_cache
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
