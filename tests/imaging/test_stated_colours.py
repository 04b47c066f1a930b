"""Files that say what their colours are without embedding a profile."""

import struct
from pathlib import Path

import numpy as np
import pytest
import tifffile
from PIL import Image, ImageCms

from relight_core.imaging.colour import srgb_encode
from relight_core.imaging.formats.exif_block import Directory, Entry, laid_out, read_directory
from relight_core.imaging.formats.icc import matrix_profile
from relight_core.imaging.formats.stated_colours import numbered_profile
from relight_core.imaging.read import read_photo

SRGB = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
CODES = (200, 120, 90)
IN_SRGB = (223.7, 120.8, 87.9)
"""What CODES in Adobe RGB (1998) are in sRGB, by its published primaries and its exponent of 563/256."""

EXIF, COLOUR_SPACE, INTEROPERABILITY = 34665, 40961, 40965


def camera_says(space, index=None):
    exif = Image.Exif()
    exif[271] = "Camera"
    settings = exif.get_ifd(EXIF)
    settings[COLOUR_SPACE] = space
    if index is not None:
        settings[INTEROPERABILITY] = {1: index, 2: b"0100"}
    return exif


def shown(photo):
    return srgb_encode(photo.linear[3, 3]) * 255


def in_adobe_rgb(path):
    """A little-endian TIFF as it is read where its EXIF says Adobe RGB."""
    data = path.read_bytes()
    settings = Directory("<", {COLOUR_SPACE: Entry(3, 1, struct.pack("<H", 2))}, {})
    directory = laid_out(Directory("<", read_directory(data).entries, {EXIF: settings}), len(data))
    path.write_bytes(data[:4] + struct.pack("<I", len(data)) + data[8:] + directory)
    return read_photo(path)


@pytest.mark.parametrize(("space", "index"), [(65535, "R03"), (2, None)])
def test_adobe_rgb_by_exif(tmp_path, space, index):
    path = tmp_path / "a.jpg"
    Image.new("RGB", (16, 16), CODES).save(path, exif=camera_says(space, index), quality=100, subsampling=0)
    photo = read_photo(path)
    np.testing.assert_allclose(shown(photo), IN_SRGB, atol=1.5)
    # So that it can be written back.
    np.testing.assert_allclose(matrix_profile(photo.icc, 3).matrix[:, 0], (1.3984, 0, 0), atol=2e-3)


@pytest.mark.parametrize(
    ("primaries", "transfer", "red", "at_half"),
    [
        (9, 13, (1.6605, -0.1246, -0.0182), 0.21404),
        (1, 5, (1, 0, 0), 0.5**2.8),
        # Primaries that have no name.
        (2, 8, (1, 0, 0), 0.5),
    ],
)
def test_colours_by_number(primaries, transfer, red, at_half):
    profile = matrix_profile(numbered_profile(primaries, transfer, 3, Path("a")), 3)
    np.testing.assert_allclose(profile.matrix[:, 0], red, atol=2e-3)
    np.testing.assert_allclose(np.interp(0.5, np.linspace(0, 1, 4096), profile.curves[1]), at_half, atol=1e-3)


def test_grey_by_number_is_of_no_primaries():
    assert numbered_profile(12, 13, 1, Path("a")) is None
    assert matrix_profile(numbered_profile(12, 8, 1, Path("a")), 1) is not None


def test_a_file_of_several_pictures_says_adobe_rgb_as_one_of_one_does(tmp_path):
    options = {"exif": camera_says(2), "quality": 100, "save_all": True, "append_images": [Image.new("RGB", (8, 8))]}
    Image.new("RGB", (16, 16), CODES).save(tmp_path / "a.jpg", "MPO", **options)
    np.testing.assert_allclose(shown(read_photo(tmp_path / "a.jpg")), IN_SRGB, atol=1.5)


def test_a_cameras_exif_says_nothing_of_colours_that_a_program_has_written_anew(tmp_path):
    Image.new("RGB", (16, 16), CODES).save(tmp_path / "a.webp", exif=camera_says(2), lossless=True)
    np.testing.assert_allclose(shown(read_photo(tmp_path / "a.webp")), CODES, atol=0.01)


@pytest.mark.parametrize(("space", "index"), [(65535, "R98"), (65535, None), (1, "R98"), (1, "R03"), (1, None)])
def test_exif_that_says_srgb_or_nothing_changes_nothing(tmp_path, space, index):
    Image.new("RGB", (16, 16), CODES).save(tmp_path / "a.jpg", exif=camera_says(space, index), quality=100)
    photo = read_photo(tmp_path / "a.jpg")
    np.testing.assert_allclose(shown(photo), CODES, atol=1.5)
    assert photo.icc is None


def test_an_embedded_profile_counts_before_exif(tmp_path):
    path, exif = tmp_path / "a.jpg", camera_says(65535, "R03")
    Image.new("RGB", (16, 16), CODES).save(path, exif=exif, icc_profile=SRGB, quality=100)
    np.testing.assert_allclose(shown(read_photo(path)), CODES, atol=1.5)


def test_deep_grey_in_adobe_rgb_has_its_exponent_too(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", np.full((8, 8), 16384, np.uint16), metadata=None, byteorder="<")
    np.testing.assert_allclose(in_adobe_rgb(tmp_path / "a.tif").linear, 0.25**2.2, atol=1e-3)


def test_grey_in_adobe_rgb_has_its_exponent(tmp_path):
    Image.new("L", (16, 16), 40).save(tmp_path / "a.jpg", exif=camera_says(65535, "R03"), quality=100)
    np.testing.assert_allclose(read_photo(tmp_path / "a.jpg").linear, (40 / 255) ** 2.2, atol=1e-3)


@pytest.mark.parametrize(("kind", "scale"), [(np.uint8, 1), (np.uint16, 257), (np.float32, 1 / 255)])
def test_tiffs_in_adobe_rgb_by_exif(tmp_path, kind, scale):
    codes = (np.ones((16, 16, 1)) * np.array(CODES) * scale).astype(kind)
    tifffile.imwrite(tmp_path / "a.tif", codes, photometric="rgb", metadata=None, byteorder="<")
    photo = in_adobe_rgb(tmp_path / "a.tif")
    if kind == np.float32:
        # Floats are linear whatever a camera once said.
        np.testing.assert_allclose(photo.linear[3, 3] * 255, CODES, atol=0.1)
    else:
        np.testing.assert_allclose(shown(photo), IN_SRGB, atol=0.5)
