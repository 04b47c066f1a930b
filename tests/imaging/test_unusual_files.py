"""Files that cameras seldom write and programs do: TIFFs in planes, white as 0, inks, grey with alpha."""

import struct
import zlib

import cv2
import numpy as np
import pytest
import tifffile
from PIL import Image

from relight_core.errors import InputError
from relight_core.imaging.colour import srgb_encode
from relight_core.imaging.formats.png import SIGNATURE, chunk
from relight_core.imaging.photo import Photo
from relight_core.imaging.read import read_photo

RNG = np.random.default_rng(8)
CODES = RNG.integers(0, 65536, (24, 40, 3), np.uint16)
GREY = CODES[..., 0]
LINEAR = Photo.from_srgb(CODES).linear


def planes(codes):
    return np.ascontiguousarray(np.moveaxis(codes, -1, 0))


@pytest.mark.parametrize("options", [{}, {"compression": "zlib"}, {"tile": (16, 16), "compression": "zlib"}])
@pytest.mark.parametrize("byteorder", ["<", ">"])
def test_deep_tiffs_in_planes(tmp_path, options, byteorder):
    kind = {"photometric": "rgb", "planarconfig": "separate", "byteorder": byteorder}
    tifffile.imwrite(tmp_path / "a.tif", planes(CODES), **kind, **options)
    photo = read_photo(tmp_path / "a.tif")
    assert photo.bits == 16
    np.testing.assert_array_equal(photo.linear, LINEAR)


@pytest.mark.parametrize("kind", [np.float16, np.float32])
@pytest.mark.parametrize("in_planes", [False, True])
def test_tiffs_of_floats_are_linear(tmp_path, kind, in_planes):
    values = (4 * RNG.random((8, 10, 3))).astype(kind)
    stored = planes(values) if in_planes else values
    config = {"planarconfig": "separate"} if in_planes else {}
    tifffile.imwrite(tmp_path / "a.tif", stored, photometric="rgb", **config)
    np.testing.assert_array_equal(read_photo(tmp_path / "a.tif").linear, values.astype(np.float32))


def test_deep_grey_whose_white_is_0(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", 65535 - GREY, photometric="miniswhite")
    np.testing.assert_array_equal(read_photo(tmp_path / "a.tif").linear[..., 1], LINEAR[..., 0])


def test_deep_grey_with_alpha(tmp_path):
    stored = np.dstack([GREY, CODES[..., 1]])
    kind = {"photometric": "minisblack", "planarconfig": "contig", "extrasamples": ["unassalpha"]}
    tifffile.imwrite(tmp_path / "a.tif", stored, **kind)
    photo = read_photo(tmp_path / "a.tif")
    np.testing.assert_array_equal(photo.linear[..., 2], LINEAR[..., 0])
    np.testing.assert_allclose(photo.alpha, CODES[..., 1] / 65535, atol=1e-6)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize(("extra", "opacity"), [("unspecified", None), ("unassalpha", 0.0)])
def test_a_channel_that_is_no_transparency_is_none(tmp_path, kind, extra, opacity):
    # A selection kept with the picture, say: all of it is 0.
    stored = np.zeros((6, 8, 4), kind)
    stored[..., :3] = 1 if kind == np.float32 else np.iinfo(kind).max
    tifffile.imwrite(tmp_path / "a.tif", stored, photometric="rgb", extrasamples=[extra])
    photo = read_photo(tmp_path / "a.tif")
    np.testing.assert_array_equal(photo.linear, 1.0)
    if opacity is None:
        assert photo.alpha is None
    else:
        np.testing.assert_array_equal(photo.alpha, opacity)


def test_transparency_may_come_before_other_channels_and_unsaid(tmp_path):
    stored = np.full((6, 8, 5), 65535, np.uint16)
    stored[..., 3:] = 13107, 0
    config = {"photometric": "rgb", "planarconfig": "contig"}
    tifffile.imwrite(tmp_path / "a.tif", stored, extrasamples=["unassalpha", "unspecified"], **config)
    np.testing.assert_allclose(read_photo(tmp_path / "a.tif").alpha, 0.2, atol=1e-5)
    # OpenCV says nothing of what it writes.
    cv2.imwrite(str(tmp_path / "b.tif"), stored[..., :4])
    np.testing.assert_allclose(read_photo(tmp_path / "b.tif").alpha, 0.2, atol=1e-5)


FLAT = np.full((6, 8, 1), 1, np.uint8)
HALF, COLOUR = 128, (200, 100, 50)


def write_flat(path, samples, extras, in_planes=False, **options):
    """A TIFF of 8 bits whose pixels all are the same."""
    stored = FLAT * np.array(samples, np.uint8)
    options = {"photometric": "rgb", "planarconfig": "separate" if in_planes else "contig", **options}
    tifffile.imwrite(path, planes(stored) if in_planes else stored, extrasamples=extras, metadata=None, **options)


def in_srgb(photo):
    return srgb_encode(photo.linear) * 255


@pytest.mark.parametrize("options", [{}, {"compression": "zlib", "predictor": True}])
def test_flat_planes_with_transparency_in_the_colours(tmp_path, options):
    write_flat(tmp_path / "a.tif", (100, 50, 25, HALF), ["assocalpha"], in_planes=True, **options)
    photo = read_photo(tmp_path / "a.tif")
    assert photo.bits == 8
    np.testing.assert_allclose(in_srgb(photo), np.broadcast_to(COLOUR, (6, 8, 3)), atol=1.01)
    np.testing.assert_allclose(photo.alpha, HALF / 255, atol=1e-6)


def test_flat_planes_with_a_channel_that_is_no_transparency(tmp_path):
    write_flat(tmp_path / "a.tif", (*COLOUR, 0), ["unspecified"], in_planes=True)
    photo = read_photo(tmp_path / "a.tif")
    np.testing.assert_allclose(in_srgb(photo), np.broadcast_to(COLOUR, (6, 8, 3)), atol=0.01)
    assert photo.alpha is None


def test_flat_grey_with_transparency_in_it(tmp_path):
    write_flat(tmp_path / "a.tif", (100, HALF), ["assocalpha"], photometric="minisblack")
    photo = read_photo(tmp_path / "a.tif")
    np.testing.assert_allclose(in_srgb(photo), 199, atol=1.01)
    np.testing.assert_allclose(photo.alpha, HALF / 255, atol=1e-6)


@pytest.mark.parametrize("scale", [1, 257])
def test_transparency_may_come_after_other_channels(tmp_path, scale):
    stored = FLAT * np.array([*COLOUR, 7, HALF], np.uint16) * scale
    stored = stored.astype(np.uint8 if scale == 1 else np.uint16)
    extras = ["unspecified", "unassalpha"]
    tifffile.imwrite(tmp_path / "a.tif", stored, photometric="rgb", planarconfig="contig", extrasamples=extras)
    photo = read_photo(tmp_path / "a.tif")
    np.testing.assert_allclose(in_srgb(photo), np.broadcast_to(COLOUR, (6, 8, 3)), atol=0.01)
    np.testing.assert_allclose(photo.alpha, HALF / 255, atol=1e-6)


@pytest.mark.parametrize("scale", [1, 257])
@pytest.mark.parametrize(("extra", "ink", "black"), [("unassalpha", 255, 127), ("assocalpha", HALF, 64)])
def test_inks_with_transparency(tmp_path, scale, extra, ink, black):
    stored = FLAT * np.array([0, ink, ink, black, HALF], np.uint16) * scale
    stored = stored.astype(np.uint8 if scale == 1 else np.uint16)
    tifffile.imwrite(tmp_path / "a.tif", stored, photometric="separated", planarconfig="contig", extrasamples=[extra])
    photo = read_photo(tmp_path / "a.tif")
    np.testing.assert_allclose(in_srgb(photo), np.broadcast_to((128, 0, 0), (6, 8, 3)), atol=0.01)
    np.testing.assert_allclose(photo.alpha, HALF / 255, atol=1e-6)


LAB_COLOUR = (54.29, 80.81, 69.89)
"""Red of sRGB, by CIE's formulas from its values relative to D50."""


@pytest.mark.parametrize("scale", [1, 257])
@pytest.mark.parametrize("options", [{}, {"compression": "zlib"}, {"in_planes": True}])
def test_lab_as_profiles_store_it(tmp_path, scale, options):
    codes = FLAT * np.rint([LAB_COLOUR[0] * 2.55, LAB_COLOUR[1] + 128, LAB_COLOUR[2] + 128]).astype(np.uint16)
    stored = (codes * scale).astype(np.uint8 if scale == 1 else np.uint16)
    in_planes = options.get("in_planes", False)
    config = {"planarconfig": "separate" if in_planes else "contig", "compression": options.get("compression")}
    tifffile.imwrite(tmp_path / "a.tif", planes(stored) if in_planes else stored, photometric="icclab", **config)
    np.testing.assert_allclose(in_srgb(read_photo(tmp_path / "a.tif")), np.broadcast_to((255, 0, 0), (6, 8, 3)), atol=6)


def test_usual_channels_that_are_damaged_are_called_so(tmp_path):
    write_flat(tmp_path / "a.tif", (*COLOUR, HALF), ["unassalpha"], compression="zlib")
    data = bytearray((tmp_path / "a.tif").read_bytes())
    with tifffile.TiffFile(tmp_path / "a.tif") as file:
        start = file.pages[0].dataoffsets[0]
    data[start : start + 8] = b"\xff" * 8
    (tmp_path / "a.tif").write_bytes(data)
    with pytest.raises(InputError, match="damaged image"):
        read_photo(tmp_path / "a.tif")


@pytest.mark.parametrize(
    ("samples", "extras", "options"),
    [
        ((*COLOUR, 7, HALF), ["unspecified", "unassalpha"], {}),
        ((0, 9, 9, 0, HALF), ["unassalpha"], {"photometric": "separated"}),
        ((*COLOUR, 7), ["unspecified"], {"in_planes": True}),
        (COLOUR, [], {"photometric": "icclab"}),
        (COLOUR, [], {"photometric": "itulab"}),
    ],
)
def test_unusual_channels_in_an_unread_compression_say_what_to_do(tmp_path, samples, extras, options):
    write_flat(tmp_path / "a.tif", samples, extras, **options)
    data = bytearray((tmp_path / "a.tif").read_bytes())
    with tifffile.TiffFile(tmp_path / "a.tif") as file:
        place = file.pages[0].tags["Compression"].valueoffset
    lzw = 5
    struct.pack_into("<H", data, place, lzw)
    (tmp_path / "a.tif").write_bytes(data)
    with pytest.raises(InputError, match="TIFF of a kind.*save it"):
        read_photo(tmp_path / "a.tif")


@pytest.mark.parametrize(("kind", "compression"), [(np.uint8, 34712), (np.uint8, 50002), (np.int8, 1)])
def test_flat_tiffs_of_no_kind_that_is_read_are_still_called_tiffs(tmp_path, kind, compression):
    tifffile.imwrite(tmp_path / "a.tif", np.ones((6, 8, 3), kind), photometric="rgb", metadata=None, byteorder="<")
    data = bytearray((tmp_path / "a.tif").read_bytes())
    with tifffile.TiffFile(tmp_path / "a.tif") as file:
        struct.pack_into("<H", data, file.pages[0].tags["Compression"].valueoffset, compression)
    (tmp_path / "a.tif").write_bytes(data)
    with pytest.raises(InputError, match="TIFF of a kind.*save it"):
        read_photo(tmp_path / "a.tif")


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_channels_that_memory_does_not_hold_are_refused(tmp_path, monkeypatch, kind):
    stored = np.zeros((50, 60, 400), kind)
    extras = ["unspecified"] * 396 + ["unassalpha"]
    options = {"photometric": "rgb", "planarconfig": "contig", "compression": "zlib"}
    tifffile.imwrite(tmp_path / "a.tif", stored, extrasamples=extras, **options)
    monkeypatch.setattr("relight_core.imaging.formats.limits.free_bytes", lambda: 500_000)
    with pytest.raises(InputError, match="needs about .* of memory"):
        read_photo(tmp_path / "a.tif")


def test_more_channels_said_than_stored_are_none(tmp_path):
    write_flat(tmp_path / "a.tif", (*COLOUR, 7, 9), ["unspecified", "unspecified"])
    data = bytearray((tmp_path / "a.tif").read_bytes())
    with tifffile.TiffFile(tmp_path / "a.tif") as file:
        extras = file.pages[0].tags["ExtraSamples"]
    struct.pack_into("<I", data, extras.offset + 4, 3)
    at = len(data)
    struct.pack_into("<I", data, extras.offset + 8, at)
    (tmp_path / "a.tif").write_bytes(data + struct.pack("<3H", 0, 0, 2))
    assert read_photo(tmp_path / "a.tif").alpha is None


def test_deep_planes_stand_upright(tmp_path):
    kind = {"photometric": "rgb", "planarconfig": "separate", "extratags": [(274, "H", 1, 6, True)]}
    tifffile.imwrite(tmp_path / "a.tif", planes(CODES), **kind)
    np.testing.assert_array_equal(read_photo(tmp_path / "a.tif").linear, np.rot90(LINEAR, -1))


def test_deep_inks(tmp_path):
    inks = np.zeros((6, 8, 4), np.uint16)
    inks[..., 1:3] = 60000
    tifffile.imwrite(tmp_path / "a.tif", inks, photometric="separated")
    red, green, blue = read_photo(tmp_path / "a.tif").linear.mean((0, 1))
    assert red > 3 * max(green, blue)


def without_adobes_mark(jpeg):
    at = jpeg.index(b"\xff\xee")
    (length,) = struct.unpack_from(">H", jpeg, at + 2)
    return jpeg[:at] + jpeg[at + 2 + length :]


def test_inks_of_a_jpeg_are_inverted_only_by_adobe(tmp_path):
    ink = Image.new("CMYK", (16, 16), (0, 200, 200, 20))
    ink.save(tmp_path / "adobe.jpg", quality=98)
    # Saving inverts, as Adobe's programs do.
    Image.new("CMYK", (16, 16), (255, 55, 55, 235)).save(tmp_path / "other.jpg", quality=98)
    (tmp_path / "plain.jpg").write_bytes(without_adobes_mark((tmp_path / "other.jpg").read_bytes()))
    adobe, plain = (read_photo(tmp_path / f"{name}.jpg").linear for name in ("adobe", "plain"))
    np.testing.assert_allclose(plain, adobe, atol=0.01)
    assert plain[0, 0, 0] > 3 * plain[0, 0, 1]


def test_a_strip_that_inflates_to_more_than_its_pixels_is_refused(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", planes(np.zeros((64, 64, 3), np.uint16)), **BOMB)
    whole = (tmp_path / "a.tif").read_bytes()
    with tifffile.TiffFile(tmp_path / "a.tif") as file:
        # Fewer rows than the strips hold.
        place = file.pages[0].tags["ImageLength"].valueoffset
        rows = file.pages[0].tags["RowsPerStrip"].valueoffset
    data = bytearray(whole)
    for at in (place, rows):
        struct.pack_into("<H", data, at, 2)
    (tmp_path / "a.tif").write_bytes(data)
    with pytest.raises(InputError, match="TIFF of a kind|damaged"):
        read_photo(tmp_path / "a.tif")


BOMB = {"photometric": "rgb", "planarconfig": "separate", "compression": "zlib", "byteorder": "<"}


def test_the_grey_that_a_deep_png_calls_transparent_is(tmp_path):
    grey = GREY.copy()
    grey[3:7, 5:9] = 1234
    rows = b"".join(b"\0" + row.astype(">u2").tobytes() for row in grey)
    chunks = chunk(b"IHDR", struct.pack(">IIBBBBB", 40, 24, 16, 0, 0, 0, 0)) + chunk(b"tRNS", struct.pack(">H", 1234))
    chunks += chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    (tmp_path / "a.png").write_bytes(SIGNATURE + chunks)
    photo = read_photo(tmp_path / "a.png")
    assert photo.bits == 16
    np.testing.assert_array_equal(photo.alpha, (grey != 1234).astype(np.float32))
