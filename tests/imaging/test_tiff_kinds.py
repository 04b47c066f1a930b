"""TIFFs by how they pack pixels and what they count them in: which are read, and which are refused."""

import itertools

import numpy as np
import pytest
import tifffile

from relight_core.errors import InputError
from relight_core.imaging.read import read_photo

UNREAD = "TIFF of a kind.*save it"
FORMS = {3: "<u2", 4: "<u4"}


def changed(path, **tags):
    """The file with other values of tags; as many as it had."""
    data = bytearray(path.read_bytes())
    with tifffile.TiffFile(path) as file:
        for name, values in tags.items():
            tag = file.pages[0].tags[name]
            raw = np.full(tag.count, values, FORMS[int(tag.dtype)]).tobytes()
            data[tag.valueoffset : tag.valueoffset + len(raw)] = raw
    path.write_bytes(data)
    return path


def written(path, pixels, **options):
    tifffile.imwrite(path, pixels, photometric=options.pop("photometric", "rgb"), metadata=None, **options)
    return path


def in_planes(path, pixels, **options):
    return written(path, np.moveaxis(pixels, -1, 0).copy(), planarconfig="separate", **options)


def test_integers_that_have_no_white_are_refused(tmp_path):
    for write, kind in itertools.product((written, in_planes), (np.int16, np.uint32)):
        with pytest.raises(InputError, match=UNREAD):
            read_photo(write(tmp_path / "a.tif", np.full((4, 5, 3), 9, kind)))


def test_signed_bytes_are_refused_as_other_signed_integers_are(tmp_path):
    for shape, colours in (((4, 5), "minisblack"), ((4, 5, 3), "rgb")):
        with pytest.raises(InputError, match=UNREAD):
            read_photo(written(tmp_path / "a.tif", np.full(shape, -3, np.int8), photometric=colours))


@pytest.mark.parametrize("bits", [10, 12, 14])
def test_white_of_any_number_of_bits_is_white(tmp_path, bits):
    codes = (0, 2 ** (bits - 1), 2**bits - 2, 2**bits - 1)
    packed = int("".join(f"{code:0{bits}b}" for code in codes), 2).to_bytes(bits // 2, "big")
    path = written(tmp_path / "a.tif", np.frombuffer(packed * 3, np.uint8).reshape(3, -1), photometric="minisblack")
    photo = read_photo(changed(path, BitsPerSample=bits, ImageWidth=len(codes)))
    assert photo.linear.shape == (3, 4, 3)
    np.testing.assert_array_equal(photo.linear[:, [0, 3]], np.broadcast_to([[0.0], [1.0]], (3, 2, 3)))
    np.testing.assert_allclose(photo.linear[:, 1], 0.2140, atol=2e-3)
    assert (photo.linear[:, 2] < 1).all()


def test_floats_of_64_bits_are_read_as_those_of_32(tmp_path):
    photo = read_photo(written(tmp_path / "a.tif", np.full((4, 5, 3), 2.5)))
    np.testing.assert_array_equal(photo.linear, 2.5)
    assert photo.bits == 32


def test_deep_planes_may_be_packed_in_runs_of_bytes(tmp_path):
    width, height, code, pack_bits = 5, 4, 10, 32773
    path = in_planes(tmp_path / "a.tif", np.zeros((height, width, 3), np.uint16))
    with tifffile.TiffFile(path) as file:
        strips = file.pages[0].dataoffsets
    data = bytearray(path.read_bytes())
    for at in strips:
        data[at : at + 2] = 257 - 2 * width * height, code
    path.write_bytes(data)
    photo = read_photo(changed(path, StripByteCounts=2, Compression=pack_bits))
    np.testing.assert_allclose(photo.linear, 10 / 255 / 12.92, rtol=1e-4)


def test_deflate_has_an_older_number_too(tmp_path):
    grey = np.full((4, 5, 3), 32896, np.uint16)
    path = changed(in_planes(tmp_path / "a.tif", grey, compression="zlib"), Compression=32946)
    np.testing.assert_allclose(read_photo(path).linear, 0.21586, atol=1e-5)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_rows_whose_strips_are_missing_are_not_taken_for_black(tmp_path, kind):
    path = written(tmp_path / "a.tif", np.full((16, 5, 3), 9, kind), rowsperstrip=8)
    with pytest.raises(InputError, match="truncated or damaged"):
        read_photo(changed(path, ImageLength=24))


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_colour_of_two_channels_is_refused(tmp_path, kind):
    options = {"photometric": "minisblack", "planarconfig": "contig", "extrasamples": ["unspecified"]}
    path = written(tmp_path / "a.tif", np.full((4, 5, 2), 9, kind), **options)
    with pytest.raises(InputError, match=UNREAD):
        read_photo(changed(path, PhotometricInterpretation=2))


def test_a_deep_tiff_takes_more_memory_than_its_codes(tmp_path, monkeypatch):
    path = written(tmp_path / "a.tif", np.zeros((50, 60, 3), np.uint16))
    for free, is_enough in ((28 * 3000, True), (27 * 3000, False)):
        monkeypatch.setattr("relight_core.imaging.formats.limits.free_bytes", lambda free=free: free)
        if is_enough:
            assert read_photo(path).linear.shape == (50, 60, 3)
        else:
            with pytest.raises(InputError, match="needs about .* of memory"):
                read_photo(path)


def test_the_transparency_of_floats_ends_at_1(tmp_path):
    stored = np.full((4, 5, 4), 0.5, np.float32) * np.float32([1, 2, 3, 0.5])
    for write in (written, in_planes):
        photo = read_photo(write(tmp_path / "a.tif", stored, extrasamples=["unassalpha"]))
        np.testing.assert_array_equal(photo.alpha, 0.25)
        np.testing.assert_array_equal(photo.linear[1, 2], (0.5, 1.0, 1.5))


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_a_profile_that_is_stored_as_numbers_counts_as_none(tmp_path, kind):
    grey = np.full((4, 5, 3), 128 * (257 if kind == np.uint16 else 1), kind)
    path = written(tmp_path / "a.tif", grey, extratags=[(34675, "H", 3, (1, 2, 3), True)])
    np.testing.assert_allclose(read_photo(path).linear, 0.21586, atol=1e-5)


def test_inks_in_floats_end_at_1_and_are_none_where_they_are_no_numbers(tmp_path):
    inks = np.tile(np.float32([0, 1, 1, 0]), (4, 5, 1))
    inks[0, 0] = np.nan, 1.7, 1, -3
    photo = read_photo(written(tmp_path / "a.tif", inks, photometric="separated"))
    np.testing.assert_allclose(photo.linear, np.broadcast_to((1, 0, 0), (4, 5, 3)), atol=0.01)
