"""How large a picture may be, by its number of pixels and by the memory that is free."""

import io
from pathlib import Path

import pytest

from relight_core.errors import InputError
from relight_core.imaging.formats import limits

PATH = Path("a.png")


@pytest.mark.parametrize(("width", "height"), [(0, 5), (5, 0), (0, 0)])
def test_a_picture_has_pixels(width, height):
    with pytest.raises(InputError, match="no pixels"):
        limits.check_pixels(width, height, PATH)


def test_four_hundred_megapixels_are_the_most(monkeypatch):
    monkeypatch.setattr(limits, "free_bytes", lambda: None)
    limits.check_pixels(20_000, 20_000, PATH)
    limits.check_pixels(1, 400_000_000, PATH)
    with pytest.raises(InputError, match="above 400 megapixels"):
        limits.check_pixels(20_000, 20_001, PATH)


def test_there_is_room_for_the_codes_the_light_and_a_copy(monkeypatch):
    monkeypatch.setattr(limits, "free_bytes", lambda: 28_000_000)
    limits.check_pixels(1000, 1000, PATH)
    limits.check_pixels(2000, 1000, PATH, bytes_per_pixel=14)
    with pytest.raises(InputError, match=r"needs about 0\.0 GB of memory and 0\.0 GB are free; make it smaller"):
        limits.check_pixels(1000, 1001, PATH)


@pytest.mark.parametrize(
    ("told", "free"),
    [
        ("MemTotal: 999 kB\nMemFree: 1 kB\nMemAvailable:   250 kB\n", 256_000),
        ("MemTotal: 999 kB\n", None),
        ("MemAvailable:\n", None),
        ("MemAvailable: much\n", None),
        ("", None),
    ],
)
def test_free_memory_is_what_the_system_calls_available(monkeypatch, told, free):
    monkeypatch.setattr(limits, "open", lambda *_, **__: io.StringIO(told), raising=False)
    assert limits.free_bytes() == free
