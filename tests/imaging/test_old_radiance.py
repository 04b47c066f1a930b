"""Radiance pictures of old programs: repeated pixels, XYZ, and those that are damaged."""

from pathlib import Path

import numpy as np
import pytest

from relight_core.errors import InputError
from relight_core.imaging.formats.radiance import decode_radiance_hdr

PATH = Path("a.hdr")
ONE, OTHER = bytes([128, 64, 32, 129]), bytes([32, 64, 128, 129])


def decoded(size, pixels, kind=b"rgbe"):
    return decode_radiance_hdr(b"#?RADIANCE\nFORMAT=32-bit_rle_" + kind + b"\n\n" + size + b"\n" + pixels, PATH)


def again(times):
    return bytes([1, 1, 1, times])


def test_a_pixel_comes_again_as_often_as_it_says_and_right_after_that_256_times_as_often():
    picture = decoded(b"-Y 2 +X 300", ONE + again(43) + again(1) + OTHER + again(43) + again(1))
    assert picture.shape == (2, 300, 3)
    np.testing.assert_allclose(picture[0], np.tile([1.0, 0.5, 0.25], (300, 1)), rtol=0.02)
    np.testing.assert_allclose(picture[1], np.tile([0.25, 0.5, 1.0], (300, 1)), rtol=0.02)


@pytest.mark.parametrize("pixels", [again(4), ONE + again(2), ONE + again(9), again(3) + ONE, b"", ONE[:3]])
def test_too_few_and_too_many_pixels_and_one_that_repeats_nothing_are_damage(pixels):
    with pytest.raises(InputError, match="not a complete Radiance file"):
        decoded(b"-Y 1 +X 4", pixels)


@pytest.mark.parametrize("size", [b"-Y 1 -Y 4", b"+X 4 +X 1", b"-Y 1", b""])
def test_a_header_without_a_size_along_both_axes_is_damage(size):
    with pytest.raises(InputError, match="not a complete Radiance file"):
        decoded(size, ONE * 4)


def test_a_size_beyond_all_bounds_is_refused_before_there_is_room_for_it():
    with pytest.raises(InputError, match="above 400 megapixels"):
        decoded(b"-Y 99999 +X 99999", ONE)


def test_xyz_stands_for_red_green_and_blue_in_this_order():
    red, blue = decoded(b"-Y 1 +X 2", ONE + OTHER, b"xyze")[0]
    assert red[0] > 1.5 > red[2]
    assert blue[2] > 0.8 > blue[0]
    np.testing.assert_allclose(decoded(b"-Y 1 +X 1", bytes([128, 128, 128, 129]), b"xyze"), 1.0, rtol=0.02)
