"""TIFFs whose first picture is only a thumbnail."""

import numpy as np
import pytest
import tifffile
from PIL import Image

from relight_core.errors import InputError
from relight_core.imaging.photo import Photo
from relight_core.imaging.read import read_photo

RNG = np.random.default_rng(3)
PICTURE = RNG.integers(0, 65536, (24, 40, 3), np.uint16)
THUMBNAIL = np.full((6, 10, 3), 90, np.uint8)
MAKER, ORIENTATION = 271, 274
REDUCED, MASK = 1, 4


def written(path, codes, within=False, first=(), file_kind=None, **options):
    """A thumbnail, and a picture after it or within it."""
    small = {"subfiletype": REDUCED, "subifds": int(within), "extratags": [(MAKER, "s", 0, "Camera", True), *first]}
    with tifffile.TiffWriter(path, **(file_kind or {})) as file:
        file.write(THUMBNAIL, photometric="rgb", metadata=None, **small)
        file.write(codes, photometric="rgb", metadata=None, **options)
    return path


@pytest.mark.parametrize("within", [False, True])
@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
@pytest.mark.parametrize("file_kind", [{}, {"byteorder": ">"}, {"bigtiff": True}, {"bigtiff": True, "byteorder": ">"}])
def test_the_picture_is_read_and_not_its_thumbnail(tmp_path, within, kind, file_kind):
    codes = PICTURE if kind == np.uint16 else (PICTURE >> 8).astype(np.uint8)
    photo = read_photo(written(tmp_path / "a.tif", codes, within, file_kind=file_kind, compression="zlib"))
    np.testing.assert_array_equal(photo.linear, Photo.from_srgb(codes).linear)
    assert b"Camera" in photo.exif


def test_a_mask_is_no_picture_either(tmp_path):
    with tifffile.TiffWriter(tmp_path / "a.tif") as file:
        file.write(THUMBNAIL, photometric="rgb", subfiletype=REDUCED, metadata=None)
        file.write(THUMBNAIL[..., 0] > 0, photometric="mask", subfiletype=MASK, metadata=None)
        file.write(PICTURE, photometric="rgb", metadata=None)
    assert read_photo(tmp_path / "a.tif").linear.shape == (24, 40, 3)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
@pytest.mark.parametrize(("own", "expected"), [(None, 6), (1, 1), (3, 3), (8, 8)])
def test_the_picture_stands_as_it_says_or_as_its_thumbnail_does(tmp_path, kind, own, expected):
    codes = PICTURE if kind == np.uint16 else (PICTURE >> 8).astype(np.uint8)
    tags = [] if own is None else [(ORIENTATION, "H", 1, own, True)]
    path = written(tmp_path / "a.tif", codes, True, [(ORIENTATION, "H", 1, 6, True)], extratags=tags)
    turned = {1: 0, 3: 2, 6: -1, 8: 1}[expected]
    np.testing.assert_array_equal(read_photo(path).linear, np.rot90(Photo.from_srgb(codes).linear, turned))


def test_nothing_but_thumbnails_is_refused(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", THUMBNAIL, photometric="rgb", subfiletype=REDUCED, metadata=None)
    with pytest.raises(InputError, match="nothing but a thumbnail; export"):
        read_photo(tmp_path / "a.tif")


def test_the_thumbnail_of_a_raw_picture_is_not_its_photo(tmp_path):
    with tifffile.TiffWriter(tmp_path / "a.tif") as file:
        file.write(THUMBNAIL, photometric="rgb", subfiletype=REDUCED, subifds=1, metadata=None)
        mosaic = 32803
        file.write(PICTURE[..., 0], photometric=mosaic, metadata=None)
    with pytest.raises(InputError, match="TIFF of a kind"):
        read_photo(tmp_path / "a.tif")


def test_pages_after_a_picture_change_nothing(tmp_path):
    first, second = Image.new("RGB", (9, 7), (10, 20, 30)), Image.new("RGB", (40, 30))
    first.save(tmp_path / "a.tif", save_all=True, append_images=[second])
    assert read_photo(tmp_path / "a.tif").linear.shape == (7, 9, 3)


def test_a_large_picture_that_calls_itself_a_smaller_one_is_the_photo_where_there_is_no_other(tmp_path):
    large = np.repeat(np.repeat(THUMBNAIL, 100, 0), 100, 1)
    tifffile.imwrite(tmp_path / "a.tif", large, photometric="rgb", subfiletype=REDUCED, metadata=None)
    assert read_photo(tmp_path / "a.tif").linear.shape == large.shape


@pytest.mark.parametrize(("side_px", "is_photo"), [(500, False), (513, True)])
def test_a_large_picture_that_calls_itself_a_thumbnail_is_the_photo_if_there_is_no_other(tmp_path, side_px, is_photo):
    codes = np.full((6, side_px, 3), 90, np.uint8)
    tifffile.imwrite(tmp_path / "a.tif", codes, photometric="rgb", subfiletype=REDUCED, metadata=None)
    if is_photo:
        assert read_photo(tmp_path / "a.tif").linear.shape == (6, side_px, 3)
    else:
        with pytest.raises(InputError, match="nothing but a thumbnail"):
            read_photo(tmp_path / "a.tif")
