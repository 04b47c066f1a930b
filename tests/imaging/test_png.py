"""PNG files that come in bands, read back by others."""

import io
import threading

import cv2
import numpy as np
import pytest
from PIL import Image

from relight_core.imaging.formats.png import write_png
from relight_core.imaging.in_order import in_order


def written(pixels, bands, notes=b""):
    file = io.BytesIO()
    bits = 8 * pixels.dtype.itemsize
    write_png(file, pixels.shape[:2], pixels.shape[2], bits, bands, notes)
    return file.getvalue()


@pytest.mark.parametrize("channels", [3, 4])
@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
@pytest.mark.parametrize("rows", [1, 7, 100])
def test_every_pixel_comes_back_however_it_is_cut(channels, kind, rows):
    rng = np.random.default_rng(0)
    ramp = np.linspace(0, np.iinfo(kind).max, 31 * 17 * channels).reshape(31, 17, channels)
    pixels = np.where(rng.random((31, 17, 1)) < 0.5, ramp, rng.random((31, 17, channels)) * 255).astype(kind)
    data = written(pixels, (pixels[top : top + rows] for top in range(0, 31, rows)))
    back = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    order = [2, 1, 0, 3][:channels]
    np.testing.assert_array_equal(back[..., order], pixels)
    image = Image.open(io.BytesIO(data))
    image.load()
    assert image.size == (17, 31)


def test_a_single_pixel():
    pixels = np.array([[[1, 2, 3]]], np.uint8)
    assert Image.open(io.BytesIO(written(pixels, [pixels]))).getpixel((0, 0)) == (1, 2, 3)


def test_smooth_pictures_become_small():
    pixels = np.repeat(np.arange(256, dtype=np.uint8)[:, None, None], 300, 1).repeat(3, 2)
    assert len(written(pixels, [pixels[:128], pixels[128:]])) < pixels.size / 20


def test_results_come_in_order_and_few_items_are_taken_ahead():
    taken = []

    def items():
        for number in range(100):
            taken.append(number)
            yield number

    results = in_order(lambda number: number * number, items())
    assert [next(results) for _ in range(3)] == [0, 1, 4]
    assert len(taken) < 30
    assert list(results) == [number * number for number in range(3, 100)]


def test_an_error_reaches_the_caller_and_the_threads_end():
    def fail(number):
        if number == 5:
            raise KeyError(number)
        return number

    before = threading.active_count()
    with pytest.raises(KeyError):
        list(in_order(fail, range(50)))
    assert threading.active_count() == before
