"""HEIC photos and cameras' raw files."""

import struct
import sys
from pathlib import Path

import numpy as np
import pytest
import tifffile
from PIL import Image

from relight_core.errors import InputError
from relight_core.imaging.colour import srgb_encode
from relight_core.imaging.formats.exif_block import read_directory
from relight_core.imaging.formats.icc import matrix_profile
from relight_core.imaging.formats.icc_making import DISPLAY_P3, REC2020, primaries_profile
from relight_core.imaging.formats.metadata import carried_block
from relight_core.imaging.read import read_photo

HEIC = Path(__file__).parent / "heic"


def codes(photo, row, column):
    return srgb_encode(photo.linear[row, column]) * 255


def test_heic_is_upright_in_colour_and_tells_its_profile_and_exif():
    # Stored turned, with EXIF and the container both saying so: it must be turned once.
    photo = read_photo(HEIC / "turned_p3.heic")
    assert photo.linear.shape == (32, 48, 3)
    assert photo.bits == 8
    red, green = codes(photo, 8, 12), codes(photo, 8, 36)
    blue, grey = codes(photo, 24, 12), codes(photo, 24, 36)
    assert red[0] > 190
    assert green[1] > 170
    assert blue[2] > 180
    np.testing.assert_allclose(grey, 120, atol=2)
    # (40, 60, 190) in Display P3 is about (33, 61, 196) in sRGB.
    np.testing.assert_allclose(blue, (33, 61, 196), atol=4)
    assert matrix_profile(photo.icc, 3) is not None
    assert b"Maker" in photo.exif
    assert b"Someone" in photo.exif
    assert read_directory(photo.exif).entries[274].data.tobytes() == b"\0\1"


def test_a_heic_of_10_bits_keeps_them_and_its_white():
    photo = read_photo(HEIC / "ramp_10_bit.heic")
    assert photo.bits == 16
    expected = np.linspace(0, 65535, 48).astype(np.uint16) >> 6
    np.testing.assert_allclose(srgb_encode(photo.linear[16, :, 1]) * 1023, expected, atol=0.1)
    assert photo.linear.max() == 1.0
    # It says Display P3 by number, so that is what can be written back.
    assert photo.icc == primaries_profile(DISPLAY_P3)


def test_a_heic_has_its_alpha():
    alpha = read_photo(HEIC / "alpha.heic").alpha
    np.testing.assert_allclose(alpha[:, :20], 0, atol=0.01)
    np.testing.assert_allclose(alpha[:, 28:], 1, atol=0.01)


def test_a_heic_may_call_itself_an_image_file_and_needs_memory(tmp_path, monkeypatch):
    data = bytearray((HEIC / "turned_p3.heic").read_bytes())
    data[8:12] = b"mif1"
    (tmp_path / "a.heic").write_bytes(data)
    assert read_photo(tmp_path / "a.heic").linear.shape == (32, 48, 3)
    monkeypatch.setattr("relight_core.imaging.formats.limits.free_bytes", lambda: 40_000)
    with pytest.raises(InputError, match="needs about .* of memory"):
        read_photo(tmp_path / "a.heic")


def test_a_heic_may_begin_with_a_box_whose_size_takes_eight_bytes(tmp_path):
    data = bytearray((HEIC / "turned_p3.heic").read_bytes())
    places, box = data.index(b"iloc"), struct.pack(">I4sQ", 1, b"free", 16)
    for at in (places + 16, places + 34):
        struct.pack_into(">I", data, at, struct.unpack_from(">I", data, at)[0] + len(box))
    (tmp_path / "a.heic").write_bytes(data[:28] + box + data[28:])
    expected = read_photo(HEIC / "turned_p3.heic").linear
    np.testing.assert_array_equal(read_photo(tmp_path / "a.heic").linear, expected)


def test_an_hdr_heic_says_what_to_do():
    with pytest.raises(InputError, match="HDR.*SDR"):
        read_photo(HEIC / "hdr_pq.heic")


@pytest.mark.parametrize("kept", [12, 40, 300, 700, 1000])
def test_a_damaged_heic_is_told(tmp_path, kept):
    (tmp_path / "a.heic").write_bytes((HEIC / "turned_p3.heic").read_bytes()[:kept])
    with pytest.raises(InputError, match="damaged HEIC"):
        read_photo(tmp_path / "a.heic")


def test_exif_as_a_block_loses_its_orientation():
    from PIL import Image

    exif = Image.Exif()
    exif[271], exif[274] = "Maker", 6
    carried = Image.Exif()
    carried.load(carried_block(exif.tobytes()))
    assert (carried[271], carried[274]) == ("Maker", 1)
    assert carried_block(None) is None


@pytest.mark.parametrize(
    ("primaries", "red"), [(DISPLAY_P3, (1.2249, -0.0420, -0.0196)), (REC2020, (1.6605, -0.1246, -0.0182))]
)
def test_made_profiles_have_the_published_primaries(primaries, red):
    matrix = matrix_profile(primaries_profile(primaries), 3).matrix
    np.testing.assert_allclose(matrix[:, 0], red, atol=2e-3)
    np.testing.assert_allclose(matrix.sum(1), 1, atol=1e-6)


NEUTRAL = (0.5, 1.0, 0.6)
"""What the camera of the raw file says of white."""

XYZ_TO_REC709 = (3.2405, -1.5371, -0.4985, -0.9693, 1.8760, 0.0416, 0.0556, -0.2040, 1.0572)


def write_dng(path, linear, orientation=1):
    """A Bayer mosaic of a camera that sees Rec.709's primaries."""
    seen = linear * np.array(NEUTRAL)
    mosaic = seen[..., 1].copy()
    mosaic[0::2, 0::2], mosaic[1::2, 1::2] = seen[0::2, 0::2, 0], seen[1::2, 1::2, 2]
    codes = np.rint(256 + mosaic * (16383 - 256)).astype(np.uint16)
    ratios = lambda values: [part for value in values for part in (round(value * 10000), 10000)]  # noqa: E731
    tags = [
        (50706, "B", 4, (1, 4, 0, 0), True),
        (50708, "s", 0, "Synthetic", True),
        (33421, "H", 2, (2, 2), True),
        (33422, "B", 4, (0, 1, 1, 2), True),
        (50714, "H", 1, 256, True),
        (50717, "H", 1, 16383, True),
        (50721, "2i", 9, ratios(XYZ_TO_REC709), True),
        (50728, "2I", 3, ratios(NEUTRAL), True),
        (50778, "H", 1, 21, True),
        (274, "H", 1, orientation, True),
        (271, "s", 0, "Maker", True),
    ]
    tifffile.imwrite(path, codes, photometric=32803, extratags=tags, metadata=None)


def test_a_raw_file_is_developed_upright_with_its_white_balance(tmp_path):
    pytest.importorskip("rawpy")
    linear = np.full((64, 96, 3), 0.9)
    linear[:32, :48] = (0.5, 0.2, 0.2)
    write_dng(tmp_path / "a.dng", linear, orientation=6)
    photo = read_photo(tmp_path / "a.dng")
    assert photo.linear.shape == (96, 64, 3)
    assert photo.bits == 16
    assert b"Maker" in photo.exif
    white, red = photo.linear[80, 16], photo.linear[20, 48]
    np.testing.assert_allclose(white / white[1], 1, atol=0.02)
    np.testing.assert_allclose(red / red[0], (1, 0.4, 0.4), atol=0.03)


def test_a_raw_file_is_brightened_until_one_pixel_in_a_thousand_clips(tmp_path, monkeypatch):
    pytest.importorskip("rawpy")
    ramp = 0.02 + 0.6 * np.arange(64 * 96).reshape(64, 96, 1) / (64 * 96)
    write_dng(tmp_path / "a.dng", np.repeat(ramp, 3, axis=2))
    clipped = read_photo(tmp_path / "a.dng").linear[..., 1] > 0.9999
    assert 0 < clipped.mean() < 0.003
    monkeypatch.setattr("relight_core.imaging.formats.limits.free_bytes", lambda: 100_000)
    with pytest.raises(InputError, match="needs about .* of memory"):
        read_photo(tmp_path / "a.dng")


def test_raw_files_are_known_by_their_first_bytes_whatever_their_name(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rawpy", None)
    for head in (b"FUJIFILMCCD-RAW", b"IIRO", b"FOVb"):
        (tmp_path / "a.jpg").write_bytes(head + bytes(64))
        with pytest.raises(InputError, match="a camera's raw file"):
            read_photo(tmp_path / "a.jpg")


@pytest.mark.parametrize(
    ("name", "data"), [("a.nef", b"II*\0" + bytes(64)), ("a.CR3", bytes(64)), ("a.dng", b"MM\0*" + bytes(9))]
)
def test_raw_files_that_cannot_be_developed_say_what_to_do(tmp_path, monkeypatch, name, data):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError, match="raw file.*TIFF"):
        read_photo(tmp_path / name)
    monkeypatch.setitem(sys.modules, "rawpy", None)
    with pytest.raises(InputError, match="pip install rawpy.*TIFF"):
        read_photo(tmp_path / name)


@pytest.mark.parametrize("suffix", ["3FR", "fff", "iiq", "mos", "mef", "erf", "mrw", "rwl", "sr2", "srf", "dcr", "kdc"])
def test_raw_files_are_known_by_their_names(tmp_path, suffix):
    # As a TIFF it would be a picture.
    tifffile.imwrite(tmp_path / f"a.{suffix}", np.zeros((6, 8, 3), np.uint8), photometric="rgb")
    with pytest.raises(InputError, match="raw file"):
        read_photo(tmp_path / f"a.{suffix}")


@pytest.mark.parametrize("letter", [0, 3])
def test_a_heic_whose_item_has_no_name_is_told(tmp_path, letter):
    data = bytearray((HEIC / "turned_p3.heic").read_bytes())
    data[data.index(b"Exif") + letter] = 0xD5
    (tmp_path / "a.heic").write_bytes(data)
    with pytest.raises(InputError, match="damaged HEIC"):
        read_photo(tmp_path / "a.heic")


@pytest.mark.parametrize(("name", "kind"), [("a.cr2", "JPEG"), ("a.DNG", "PNG"), ("a.nef", "WEBP"), ("a.arw", "GIF")])
def test_a_picture_that_is_named_like_a_raw_file_is_read_as_what_it_is(tmp_path, name, kind):
    Image.new("RGB", (8, 6), (200, 100, 50)).save(tmp_path / name, kind)
    photo = read_photo(tmp_path / name)
    assert (photo.linear.shape, photo.bits) == ((6, 8, 3), 8)


def test_a_heic_that_is_named_like_a_raw_file_is_read_as_what_it_is(tmp_path):
    (tmp_path / "a.dng").write_bytes((HEIC / "turned_p3.heic").read_bytes())
    assert read_photo(tmp_path / "a.dng").linear.shape == (32, 48, 3)
