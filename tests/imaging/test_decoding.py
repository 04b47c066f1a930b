"""What decoders make of a file before there is light: inks, claims, odd EXIF, and what they leave of the process."""

import io
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
import tifffile
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from relight_core.errors import InputError
from relight_core.imaging.colour import srgb_encode
from relight_core.imaging.formats.decode import decode_raster
from relight_core.imaging.formats.exif_block import read_directory
from relight_core.imaging.formats.png import SIGNATURE, chunk
from relight_core.imaging.read import read_photo

RNG = np.random.default_rng(6)
PATH = Path("a")
ORIENTATION, MAKER, AUTHOR = 274, 271, 315
RED_INKS = (0, 255, 255, 0)


def encoded(picture, kind, **options):
    buffer = io.BytesIO()
    picture.save(buffer, kind, **options)
    return buffer.getvalue()


def shown(photo, row=2, column=3):
    return srgb_encode(photo.linear[row, column]) * 255


def png_of(bits, rows, more=b""):
    """A grey PNG of 6 x 4 pixels."""
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 6, 4, bits, 0, 0, 0, 0))
    return SIGNATURE + header + more + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def cut_exif():
    exif = Image.Exif()
    exif[ORIENTATION], exif[AUTHOR] = 6, "Someone whose name is long"
    return exif.tobytes()[:-12]


@pytest.mark.filterwarnings("error")
def test_damaged_exif_is_no_fault_of_the_picture_and_not_worth_a_word(tmp_path):
    deep = png_of(16, bytes(4 * 13), chunk(b"eXIf", cut_exif().removeprefix(b"Exif\0\0")))
    for data in (deep, *(encoded(Image.new("RGB", (6, 4)), kind, exif=cut_exif()) for kind in ("PNG", "WEBP"))):
        (tmp_path / "a").write_bytes(data)
        assert read_photo(tmp_path / "a").linear.shape == (6, 4, 3)


def test_exif_as_text_that_is_none_is_no_fault_of_the_picture(tmp_path):
    notes = PngInfo()
    notes.add_text("Raw profile type exif", "\nexif\n    4\nnone")
    Image.new("RGB", (6, 4)).save(tmp_path / "a.png", pnginfo=notes)
    photo = read_photo(tmp_path / "a.png")
    assert (photo.linear.shape, photo.exif) == ((4, 6, 3), None)


@pytest.mark.parametrize(("kind", "orientation"), [("JPEG", 0), ("PNG", 9), ("deep TIFF", 9)])
def test_an_orientation_that_is_none_turns_nothing(tmp_path, kind, orientation):
    if kind == "deep TIFF":
        tags = [(ORIENTATION, "H", 1, orientation, True)]
        options = {"photometric": "rgb", "planarconfig": "separate", "extratags": tags, "metadata": None}
        tifffile.imwrite(tmp_path / "a", np.zeros((3, 4, 6), np.uint16), **options)
    else:
        exif = Image.Exif()
        exif[ORIENTATION] = orientation
        Image.new("RGB", (6, 4)).save(tmp_path / "a", kind, exif=exif)
    assert read_photo(tmp_path / "a").linear.shape == (4, 6, 3)


def test_a_deep_png_stands_upright_and_tells_of_its_author(tmp_path):
    turned = Image.Exif()
    turned[ORIENTATION], turned[AUTHOR] = 6, "Someone"
    rows = b"\0" + b"\xff" * 2 + bytes(10) + bytes(3 * 13)
    (tmp_path / "a.png").write_bytes(png_of(16, rows, chunk(b"eXIf", turned.tobytes().removeprefix(b"Exif\0\0"))))
    photo = read_photo(tmp_path / "a.png")
    linear = photo.linear
    assert b"Someone" in photo.exif
    assert linear.shape == (6, 4, 3)
    assert linear[0, 3, 0] == linear[..., 0].sum() == 1.0


def test_pillows_own_limit_is_neither_obeyed_nor_changed(tmp_path, monkeypatch):
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 5)
    Image.new("RGB", (9, 7)).save(tmp_path / "a.png")
    assert read_photo(tmp_path / "a.png").linear.shape == (7, 9, 3)
    (tmp_path / "b.png").write_bytes((tmp_path / "a.png").read_bytes()[:45])
    with pytest.raises(InputError, match="damaged"):
        read_photo(tmp_path / "b.png")
    assert Image.MAX_IMAGE_PIXELS == 5


def test_formats_that_nobody_meant_are_not_tried():
    for kind in ("PPM", "ICO"):
        with pytest.raises(InputError, match="not an image; use a JPEG"):
            decode_raster(encoded(Image.new("RGB", (16, 16), (9, 8, 7)), kind), PATH)


def test_far_more_pixels_than_bytes_are_refused_with_both_numbers():
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 20000, 5000, 8, 2, 0, 0, 0))
    data = SIGNATURE + header + chunk(b"IDAT", zlib.compress(b"\0")) + chunk(b"IEND", b"")
    with pytest.raises(InputError, match=rf"damaged image \(20000 x 5000 pixels in {len(data)} bytes\)"):
        decode_raster(data, PATH)


def test_a_large_picture_of_one_grey_is_no_false_claim():
    # Deflate makes one byte of a thousand.
    side = 4100
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0))
    data = SIGNATURE + header + chunk(b"IDAT", zlib.compress(bytes(side * (side + 1)), 9)) + chunk(b"IEND", b"")
    assert len(data) < 20_000
    assert decode_raster(data, PATH).values.shape == (side, side, 1)


def ink_profile():
    """A table of sixteen mixtures of full inks: those of red are a middle grey, the others paper or black."""
    black, grey, paper = (0, 128, 128), (127, 128, 128), (255, 128, 128)
    mixtures = [paper] * 16
    mixtures[0b0110] = grey
    mixtures[1::2] = [black] * 8
    ramp = bytes(range(256))
    unit = struct.pack(">9i", *(np.eye(3, dtype=int).ravel() * 65536).tolist())
    table = b"mft1" + bytes(4) + bytes([4, 3, 2, 0]) + unit + ramp * 4 + np.uint8(mixtures).tobytes() + ramp * 3
    white = b"XYZ " + bytes(4) + struct.pack(">3i", *(round(65536 * value) for value in (0.9642, 1.0, 0.8249)))
    body = white + table
    head = struct.pack(">I4sI4s4s4s", 156 + len(body), b"lcms", 0x02400000, b"scnr", b"CMYK", b"Lab ").ljust(36, b"\0")
    head = (head + b"acsp").ljust(68, b"\0") + white[8:]
    tags = struct.pack(">I4sII4sII", 2, b"wtpt", 156, len(white), b"A2B0", 156 + len(white), len(table))
    return head.ljust(128, b"\0") + tags + body


@pytest.mark.parametrize("kind", ["a.jpg", "flat.tif", "deep.tif"])
def test_inks_are_seen_through_their_profile_and_stand_upright(tmp_path, kind):
    path, turned = tmp_path / kind, Image.Exif()
    turned[ORIENTATION] = 6
    inks = Image.new("CMYK", (16, 8), RED_INKS)
    for icc, expected in ((None, (255, 0, 0)), (b"rubbish" * 40, (255, 0, 0)), (ink_profile(), (119, 119, 119))):
        if kind == "deep.tif":
            tags = [(ORIENTATION, "H", 1, 6, True)]
            tifffile.imwrite(path, np.uint16(inks) * 257, photometric="separated", iccprofile=icc, extratags=tags)
        else:
            inks.save(path, exif=turned, icc_profile=icc, **({"quality": 100} if kind == "a.jpg" else {}))
        photo = read_photo(path)
        assert photo.linear.shape == (16, 8, 3)
        np.testing.assert_allclose(shown(photo), expected, atol=2.5)


def avif_saying(primaries, transfer, mode="RGB", colour=(0, 255, 0)):
    data = bytearray(encoded(Image.new(mode, (16, 12), colour), "AVIF", quality=100))
    struct.pack_into(">HH", data, data.index(b"nclx") + 4, primaries, transfer)
    return bytes(data)


def test_an_avif_is_in_the_colours_it_states_by_number(tmp_path):
    display_p3, srgb, pq = 12, 13, 16
    (tmp_path / "a.avif").write_bytes(avif_saying(display_p3, srgb))
    photo = read_photo(tmp_path / "a.avif")
    np.testing.assert_allclose((photo.linear + photo.beyond)[2, 3], (-0.2249, 1.0421, -0.0786), atol=5e-3)
    (tmp_path / "b.avif").write_bytes(avif_saying(1, pq))
    with pytest.raises(InputError, match=r"HDR picture \(PQ\)"):
        read_photo(tmp_path / "b.avif")


@pytest.mark.parametrize("primaries", [1, 12])
@pytest.mark.parametrize(("transfer", "linear"), [(8, 128 / 255), (4, (128 / 255) ** 2.2), (13, 0.2159)])
def test_a_grey_avif_has_the_curve_it_states_by_number(tmp_path, primaries, transfer, linear):
    (tmp_path / "a.avif").write_bytes(avif_saying(primaries, transfer, "L", 128))
    np.testing.assert_allclose(read_photo(tmp_path / "a.avif").linear, linear, atol=5e-3)


def test_what_only_the_photo_of_a_tiff_and_not_its_thumbnail_says_is_kept(tmp_path):
    with tifffile.TiffWriter(tmp_path / "a.tif") as file:
        file.write(np.zeros((4, 5, 3), np.uint8), photometric="rgb", subfiletype=1, metadata=None, software=False)
        said = [(MAKER, "s", 0, "Camera", True)]
        file.write(np.zeros((8, 9, 3), np.uint8), photometric="rgb", metadata=None, software=False, extratags=said)
    assert bytes(read_directory(read_photo(tmp_path / "a.tif").exif).entries[MAKER].data) == b"Camera\0"
