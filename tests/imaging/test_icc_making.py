"""Profiles made here are files of their own right, which other programs read as we do."""

import io
import struct

import numpy as np
import pytest
from PIL import Image, ImageCms

from relight_core.imaging.colour import srgb_encode
from relight_core.imaging.formats.icc import matrix_profile
from relight_core.imaging.formats.icc_making import (
    ADOBE_RGB,
    DISPLAY_P3,
    REC2020,
    grey_profile,
    measured_primaries,
    primaries_profile,
)

D50 = (0.9642, 1.0, 0.8249)
PROPHOTO = np.array([0.7347, 0.2653, 0.1596, 0.8404, 0.0366, 0.0001, 0.3457, 0.3585])


def opened(icc):
    return ImageCms.ImageCmsProfile(io.BytesIO(icc))


def through_littlecms(picture, icc):
    srgb = ImageCms.createProfile("sRGB")
    return ImageCms.profileToProfile(picture, opened(icc), srgb, renderingIntent=1, outputMode="RGB").getpixel((0, 0))


@pytest.mark.parametrize(
    ("primaries", "name"),
    [(DISPLAY_P3, "Display P3"), (REC2020, "Rec. 2020 primaries"), (ADOBE_RGB, "Adobe RGB (1998)")],
)
def test_a_made_profile_is_whole_and_read_by_littlecms_as_here(primaries, name):
    icc, picture = primaries_profile(primaries), Image.new("RGB", (1, 1), (150, 120, 100))
    profile = opened(icc).profile
    assert (profile.profile_description, profile.device_class, profile.connection_space) == (name, "mntr", "XYZ ")
    np.testing.assert_allclose(profile.media_white_point[0], D50, atol=1e-4)
    np.testing.assert_allclose(np.array(struct.unpack_from(">3i", icc, 68)) / 65536, D50, atol=1e-4)
    assert struct.unpack_from(">I", icc)[0] == len(icc)
    (count,) = struct.unpack_from(">I", icc, 128)
    places = [struct.unpack_from(">4sII", icc, 132 + 12 * index) for index in range(count)]
    assert all(offset % 4 == 0 and offset + size <= len(icc) for _, offset, size in places)
    ours = srgb_encode(matrix_profile(icc, 3).decode(np.asarray(picture)))[0, 0] * 255
    np.testing.assert_allclose(ours, through_littlecms(picture, icc), atol=0.8)


def test_a_profile_says_how_its_white_was_adapted():
    of_d65 = opened(primaries_profile(DISPLAY_P3)).profile.chromatic_adaptation[0]
    np.testing.assert_allclose(of_d65 @ np.array([0.9505, 1.0, 1.0891]), D50, atol=2e-3)
    # A white of D50 needs no adaptation.
    of_d50 = opened(primaries_profile(measured_primaries(PROPHOTO, 1.8))).profile.chromatic_adaptation[0]
    np.testing.assert_allclose(of_d50, np.eye(3), atol=2e-3)


def test_a_made_grey_profile_is_read_by_littlecms():
    code = through_littlecms(Image.new("L", (1, 1), 100), grey_profile(1.8))
    np.testing.assert_allclose(code, 255 * srgb_encode(np.float32((100 / 255) ** 1.8)), atol=0.8)
