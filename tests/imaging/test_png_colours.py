"""PNGs that say what their colours are by chunks, and which of these counts."""

import struct
import zlib

import numpy as np
import pytest
from PIL import Image, ImageCms

from relight_core.errors import InputError
from relight_core.imaging.colour import srgb_encode
from relight_core.imaging.formats.icc import matrix_profile
from relight_core.imaging.formats.png import SIGNATURE, chunk
from relight_core.imaging.read import read_photo

ICC = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
EMBEDDED = chunk(b"iCCP", b"icc\0\0" + zlib.compress(ICC))
SRGB = chunk(b"sRGB", b"\0")
GREY, RGB, GREY_ALPHA, RGBA = 0, 2, 4, 6
CHANNELS = {GREY: 1, RGB: 3, GREY_ALPHA: 2, RGBA: 4}

P3_GREEN = (-0.2249, 1.0421, -0.0786)
"""Display P3's in Rec.709."""


@pytest.mark.parametrize(("bits", "key"), [(1, 1), (2, 1), (2, 3), (4, 9), (8, 200)])
def test_the_grey_that_is_transparent_is_so_at_any_depth(tmp_path, bits, key):
    codes = [0, key] if bits == 1 else [0, key, 2**bits - 2]
    row = int("".join(f"{code:0{bits}b}" for code in codes).ljust(24, "0"), 2).to_bytes(3, "big")
    chunks = chunk(b"IHDR", struct.pack(">IIBBBBB", len(codes), 1, bits, GREY, 0, 0, 0))
    chunks += chunk(b"tRNS", struct.pack(">H", key)) + chunk(
        b"IDAT", zlib.compress(b"\0" + row[: -(-len(codes) * bits // 8)])
    )
    (tmp_path / "a.png").write_bytes(SIGNATURE + chunks + chunk(b"IEND", b""))
    np.testing.assert_array_equal(read_photo(tmp_path / "a.png").alpha[0], [1, 0, 1][: len(codes)])


def numbers(primaries, transfer):
    return chunk(b"cICP", bytes([primaries, transfer, 0, 1]))


def gamma(value):
    return chunk(b"gAMA", struct.pack(">I", value))


def chromaticities(*white_red_green_blue):
    return chunk(b"cHRM", struct.pack(">8I", *white_red_green_blue))


P3_CHROMATICITIES = chromaticities(31270, 32900, 68000, 32000, 26500, 69000, 15000, 6000)
SRGB_CHROMATICITIES = chromaticities(31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000)
# ProPhoto's, with the white of D50.
PROPHOTO_CHROMATICITIES = chromaticities(34570, 35850, 73470, 26530, 15960, 84040, 3660, 10)


def photo_of(path, codes, said, bits=8, kind=RGB):
    """A PNG of one colour, given as 8 bits."""
    row = np.tile(np.array(codes, np.uint16) * (257 if bits == 16 else 1), 8).astype(f">u{bits // 8}").tobytes()
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 8, 6, bits, kind, 0, 0, 0))
    pixels = chunk(b"IDAT", zlib.compress((b"\0" + row) * 6)) + chunk(b"IEND", b"")
    path.write_bytes(SIGNATURE + header + said + pixels)
    return read_photo(path)


def whole(photo):
    beyond = 0 if photo.beyond is None else photo.beyond[2, 3].astype(np.float32)
    return photo.linear[2, 3] + beyond


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize(("kind", "alpha"), [(RGB, ()), (RGBA, (255,))])
@pytest.mark.parametrize("before", [b"", EMBEDDED, SRGB, gamma(100_000)])
def test_numbers_count_before_all_else(tmp_path, bits, kind, alpha, before):
    photo = photo_of(tmp_path / "a.png", (0, 255, 0, *alpha), before + numbers(12, 13), bits, kind)
    np.testing.assert_allclose(whole(photo), P3_GREEN, atol=2e-3)
    assert photo.bits == bits
    # So that it can be written back.
    np.testing.assert_allclose(matrix_profile(photo.icc, 3).matrix[:, 1], P3_GREEN, atol=2e-3)


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize(("transfer", "name"), [(16, "PQ"), (18, "HLG")])
def test_numbers_of_hdr_are_refused(tmp_path, bits, transfer, name):
    for kind, codes in ((RGB, (9, 9, 9)), (GREY, (9,))):
        with pytest.raises(InputError, match=rf"HDR picture \({name}\).*SDR"):
            photo_of(tmp_path / "a.png", codes, numbers(9, transfer), bits, kind)


@pytest.mark.parametrize(("transfer", "expected"), [(8, 0.4), (4, 0.4**2.2), (13, 0.13287)])
@pytest.mark.parametrize(("kind", "codes"), [(RGB, (102, 102, 102)), (GREY, (102,)), (GREY_ALPHA, (102, 255))])
def test_numbers_tell_the_curve(tmp_path, transfer, expected, kind, codes):
    for bits in (8, 16):
        photo = photo_of(tmp_path / "a.png", codes, numbers(1, transfer), bits, kind)
        np.testing.assert_allclose(photo.linear, expected, atol=1e-3)


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize(("kind", "codes"), [(RGB, (102, 102, 102)), (GREY, (102,)), (GREY_ALPHA, (102, 255))])
def test_a_gamma_alone(tmp_path, bits, kind, codes):
    exponents = {100_000: 1, 55_556: 1.8, 50_000: 2, 40_000: 2.5, 200_000: 0.5}
    for value, expected in ((value, 0.4**exponent) for value, exponent in exponents.items()):
        photo = photo_of(tmp_path / "a.png", codes, gamma(value), bits, kind)
        np.testing.assert_allclose(photo.linear, expected, atol=1e-3)


@pytest.mark.parametrize("bits", [8, 16])
def test_measured_primaries(tmp_path, bits):
    green = photo_of(tmp_path / "a.png", (0, 255, 0), gamma(45_455) + P3_CHROMATICITIES, bits)
    np.testing.assert_allclose(whole(green), P3_GREEN, atol=2e-3)
    grey = photo_of(tmp_path / "b.png", (102, 102, 102), gamma(45_455) + P3_CHROMATICITIES, bits)
    np.testing.assert_allclose(grey.linear, 0.4**2.2, atol=1e-3)
    # Without a gamma the curve is that of sRGB.
    grey = photo_of(tmp_path / "c.png", (102, 102, 102), P3_CHROMATICITIES, bits)
    np.testing.assert_allclose(grey.linear, 0.13287, atol=1e-3)


def test_measured_primaries_with_another_white(tmp_path):
    said = gamma(55_556) + PROPHOTO_CHROMATICITIES
    white = photo_of(tmp_path / "a.png", (255, 255, 255), said)
    np.testing.assert_allclose(whole(white), 1.0, atol=1e-3)
    red, blue = (photo_of(tmp_path / "b.png", code, said) for code in ((255, 0, 0), (0, 0, 255)))
    # ProPhoto's in Rec.709, by its published matrix and Bradford's adaptation.
    np.testing.assert_allclose(whole(red), (2.0341, -0.2288, -0.0086), atol=3e-3)
    np.testing.assert_allclose(whole(blue), (-0.3068, -0.0029, 1.1618), atol=3e-3)


def test_numbers_of_primaries_that_have_no_name_leave_it_to_the_gamma(tmp_path):
    photo = photo_of(tmp_path / "a.png", (102, 102, 102), numbers(2, 13) + gamma(100_000))
    np.testing.assert_allclose(photo.linear, 0.4, atol=1e-3)


@pytest.mark.parametrize("before", [EMBEDDED, SRGB, chunk(b"iCCP", b"icc\0\0damaged")])
def test_profile_and_srgb_count_before_measurements(tmp_path, before):
    photo = photo_of(tmp_path / "a.png", (0, 200, 90), before + gamma(100_000) + P3_CHROMATICITIES)
    np.testing.assert_allclose(srgb_encode(photo.linear[2, 3]) * 255, (0, 200, 90), atol=0.5)


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize(
    "said",
    [
        *[numbers(1, 13), numbers(1, 13) + gamma(100_000), numbers(2, 2)],
        *[gamma(45_455), gamma(45_000), gamma(45_455) + SRGB_CHROMATICITIES, SRGB_CHROMATICITIES],
        # Mistakes: no gamma, no colours, a line, too few numbers.
        *[gamma(0), gamma(7), chromaticities(*[0] * 8), chromaticities(*[4_000_000_000] * 8)],
        *[chromaticities(31270, 32900, 30000, 30000, 40000, 40000, 20000, 20000), chunk(b"cICP", b"\x0c")],
    ],
)
def test_srgb_by_number_or_measurement_and_mistakes_change_nothing(tmp_path, bits, said):
    photo = photo_of(tmp_path / "a.png", (0, 200, 90), said, bits)
    np.testing.assert_allclose(srgb_encode(photo.linear[2, 3]) * 255, (0, 200, 90), atol=0.01)
    assert photo.icc is None


def test_a_gamma_counts_beside_chromaticities_that_are_a_mistake(tmp_path):
    for mistake in (chromaticities(*[0] * 8), chromaticities(31270, 32900, *[30000] * 6)):
        photo = photo_of(tmp_path / "a.png", (102, 102, 102), gamma(100_000) + mistake)
        np.testing.assert_allclose(photo.linear, 0.4, atol=1e-3)


def test_a_palette_is_in_the_stated_colours(tmp_path):
    picture = Image.new("P", (8, 6), 3)
    picture.putpalette([0, 255, 0] * 4)
    picture.save(tmp_path / "a.png")
    data = (tmp_path / "a.png").read_bytes()
    (tmp_path / "a.png").write_bytes(data[:33] + numbers(12, 13) + data[33:])
    np.testing.assert_allclose(whole(read_photo(tmp_path / "a.png")), P3_GREEN, atol=2e-3)
