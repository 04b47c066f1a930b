"""Archives of arrays: what is none is refused in words of relight's own."""

import numpy as np
import pytest

from relight_core.dataset.archive import read_arrays
from relight_core.errors import InputError


def test_an_archive_gives_the_arrays_that_are_named(tmp_path):
    np.savez(tmp_path / "two.npz", one=np.arange(3), other=np.ones(2))
    arrays = read_arrays(tmp_path / "two.npz", ("one",), "a library", "give another")
    assert list(arrays) == ["one"]
    np.testing.assert_array_equal(arrays["one"], [0, 1, 2])


@pytest.mark.parametrize("content", [b"hello", b"", b"\x80\x04}.", b"PK\x03\x04"])
def test_what_is_no_archive_is_refused_without_advice_on_unpickling_it(tmp_path, content):
    path = tmp_path / "lights.npz"
    path.write_bytes(content)
    with pytest.raises(InputError) as refusal:
        read_arrays(path, ("one",), "a library", "give another")
    assert str(refusal.value) == f"{path}: not a library, or damaged (no .npz archive); give another"
