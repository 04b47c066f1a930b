"""Colour profiles: read as LittleCMS does, broken ones as none."""

import io
import struct
import zlib

import cv2
import numpy as np
import pytest
import tifffile
from PIL import Image, ImageCms

from relight_core.errors import InputError
from relight_core.imaging.formats.icc import matrix_profile, stated_transfer
from relight_core.imaging.formats.png import SIGNATURE, chunk
from relight_core.imaging.read import read_photo
from relight_core.imaging.write import FileStyle, cut, write_bands

SRGB = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()

# XYZ (D50) of the primaries of Display P3, as its published profiles have them.
P3 = [(0.51512, 0.24120, -0.00105), (0.29198, 0.69225, 0.04189), (0.15710, 0.06657, 0.78407)]


def fixed(value):
    return struct.pack(">i", round(value * 65536))


def profile_bytes(space, tags):
    names = list(tags)
    offset = 132 + 12 * len(names)
    table, body = struct.pack(">I", len(names)), b""
    for name in names:
        content = tags[name] + b"\0" * (-len(tags[name]) % 4)
        table += struct.pack(">4sII", name, offset + len(body), len(tags[name]))
        body += content
    size = offset + len(body)
    header = struct.pack(">I4sI4s4s4s", size, b"lcms", 0x02400000, b"mntr", space, b"XYZ ")
    header = header.ljust(36, b"\0") + b"acsp"
    header = header.ljust(68, b"\0") + fixed(0.9642) + fixed(1.0) + fixed(0.8249)
    return header.ljust(128, b"\0") + table + body


def gamma(value):
    return b"curv\0\0\0\0" + struct.pack(">IH", 1, round(value * 256))


def xyz(values):
    return b"XYZ \0\0\0\0" + b"".join(fixed(value) for value in values)


def rgb_profile(*curves, columns=P3, more=()):
    """A profile with a curve for each of red, green and blue, or one for all."""
    tags = {b"wtpt": xyz((0.9642, 1.0, 0.8249)), **dict(more)}
    for letter, column, curve in zip(b"rgb", columns, curves * (3 // len(curves)), strict=True):
        tags[bytes([letter]) + b"XYZ"] = xyz(column)
        tags[bytes([letter]) + b"TRC"] = curve
    return profile_bytes(b"RGB ", tags)


def test_srgb_profile_changes_nothing(tmp_path):
    pixels = np.random.default_rng(0).integers(0, 256, (8, 9, 3)).astype(np.uint8)
    Image.fromarray(pixels).save(tmp_path / "with.png", icc_profile=SRGB)
    Image.fromarray(pixels).save(tmp_path / "without.png")
    photos = [read_photo(tmp_path / name) for name in ("with.png", "without.png")]
    np.testing.assert_array_equal(photos[0].linear, photos[1].linear)
    assert photos[0].icc is None


def test_matrix_profile_agrees_with_littlecms(tmp_path):
    profile = rgb_profile(gamma(2.2))
    pixels = np.random.default_rng(1).integers(60, 200, (16, 16, 3)).astype(np.uint8)
    Image.fromarray(pixels).save(tmp_path / "a.jpg", icc_profile=profile, quality=100, subsampling=0)
    stored = Image.open(tmp_path / "a.jpg")
    source = ImageCms.ImageCmsProfile(io.BytesIO(profile))
    reference = ImageCms.profileToProfile(
        stored, source, ImageCms.createProfile("sRGB"), renderingIntent=1, outputMode="RGB"
    )
    linear = read_photo(tmp_path / "a.jpg").linear
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055) * 255
    assert np.abs(encoded - np.asarray(reference)).max() < 1.6


def test_white_stays_white_and_wide_red_is_clipped(tmp_path):
    pixels = np.array([[[255, 255, 255], [255, 0, 0], [0, 0, 0]]], np.uint8)
    Image.fromarray(pixels).save(tmp_path / "a.png", icc_profile=rgb_profile(gamma(2.2)))
    white, red, black = read_photo(tmp_path / "a.png").linear[0]
    np.testing.assert_allclose(white, 1.0, atol=1e-6)
    np.testing.assert_allclose(red, (1.0, 0.0, 0.0), atol=1e-6)
    np.testing.assert_array_equal(black, 0.0)


@pytest.mark.parametrize("extension", [".png", ".tif"])
def test_16_bits_with_a_profile_stay_16_bits(tmp_path, extension):
    ramp = np.arange(30000, 30064, dtype=np.uint16)
    pixels = np.repeat(np.repeat(ramp[None, :, None], 2, 0), 3, 2)
    profile = rgb_profile(gamma(1.8))
    if extension == ".tif":
        tifffile.imwrite(tmp_path / "a.tif", pixels, photometric="rgb", iccprofile=profile)
    else:
        png = cv2.imencode(".png", pixels)[1].tobytes()
        chunk = b"iCCP" + b"p\0\0" + zlib.compress(profile)
        chunk = struct.pack(">I", len(chunk) - 4) + chunk + struct.pack(">I", zlib.crc32(chunk))
        (tmp_path / "a.png").write_bytes(png[:33] + chunk + png[33:])
    photo = read_photo(tmp_path / f"a{extension}")
    assert photo.bits == 16
    assert len(np.unique(photo.linear[0, :, 0])) == 64
    np.testing.assert_allclose(photo.linear[0, 0], (30000 / 65535) ** 1.8, rtol=2e-3)


def test_grey_profile(tmp_path):
    profile = profile_bytes(b"GRAY", {b"wtpt": xyz((0.9642, 1.0, 0.8249)), b"kTRC": gamma(1.0)})
    Image.fromarray(np.full((4, 4), 51, np.uint8)).save(tmp_path / "a.png", icc_profile=profile)
    np.testing.assert_allclose(read_photo(tmp_path / "a.png").linear, 0.2, atol=1e-4)


@pytest.mark.parametrize(("kind", "scale"), [(np.uint8, 1), (np.uint16, 257)])
def test_a_grey_profile_may_give_lightness(tmp_path, kind, scale):
    through_lab = bytearray(grey_profile(1.0))
    through_lab[20:24] = b"Lab "
    codes = np.repeat(np.array([[255, 128, 5, 0]], kind) * kind(scale), 3, axis=0)
    Image.fromarray(codes).save(tmp_path / "a.png", icc_profile=bytes(through_lab))
    photo = read_photo(tmp_path / "a.png")
    # CIE's formulas of L* = 100, 50.2, 1.96 and 0.
    np.testing.assert_allclose(photo.linear[1, :, 0], [1, 0.18584, 0.002171, 0], atol=2e-5)
    assert photo.bits == 8 * kind(0).itemsize


@pytest.mark.parametrize(
    ("kind", "numbers", "expected_at_half"),
    [
        (0, (2.0,), 0.25),
        (1, (2.0, 1.2, -0.2), 0.16),
        (2, (2.0, 1.0, -0.25, 0.1), 0.1625),
        (3, (2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045), 0.21404),
        (4, (2.0, 1.0, 0.0, 0.5, 0.75, 0.0, 0.05), 0.30),
    ],
)
def test_parametric_curves(kind, numbers, expected_at_half):
    curve = b"para\0\0\0\0" + struct.pack(">HH", kind, 0) + b"".join(fixed(number) for number in numbers)
    profile = matrix_profile(rgb_profile(curve, columns=P3), 3)
    at_half = np.interp(0.5, np.linspace(0, 1, 4096), profile.curves[0])
    assert at_half == pytest.approx(expected_at_half, abs=2e-3)


@pytest.mark.parametrize(("samples", "at_half"), [((), 0.5), ((0, 16384, 65535), 0.25)])
def test_sampled_curves(samples, at_half):
    curve = b"curv\0\0\0\0" + struct.pack(f">I{len(samples)}H", len(samples), *samples)
    linear = matrix_profile(rgb_profile(curve), 3).decode(np.uint8([[[0] * 3, [128] * 3, [255] * 3]]))
    np.testing.assert_allclose(linear[0, :, 1], [0, at_half, 1], atol=4e-3)
    assert linear[0, 2, 1] == pytest.approx(1, abs=1e-6)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("kind", "numbers"), [(0, (-2.0,)), (1, (2.2, 0.0, 0.5)), (3, (9e3, 9e3, 9e3, 9e3, 1.0))])
def test_damaged_numbers_in_a_profile_are_read_without_warnings(kind, numbers):
    curve = b"para\0\0\0\0" + struct.pack(">HH", kind, 0) + b"".join(fixed(number) for number in numbers)
    assert np.isfinite(matrix_profile(rgb_profile(curve), 3).curves).all()
    assert matrix_profile(rgb_profile(gamma(2.2), columns=3 * [(0.0, 0.0, 0.0)]), 3) is None


def test_a_broken_or_foreign_profile_counts_as_none(tmp_path):
    pixels = np.full((4, 4, 3), 128, np.uint8)
    grey = profile_bytes(b"GRAY", {b"kTRC": gamma(1.0)})
    curves = b"para" + b"\xff" * 20, b"text" + bytes(20)
    nothing, broken = profile_bytes(b"RGB ", {}), [rgb_profile(curve) for curve in curves]
    for index, profile in enumerate((b"rubbish" * 40, SRGB[:200], grey, nothing, *broken)):
        path = tmp_path / f"{index}.png"
        Image.fromarray(pixels).save(path, icc_profile=profile)
        np.testing.assert_allclose(read_photo(path).linear, 0.21586, atol=1e-4)


def float_tiff(path, pixels, **options):
    tifffile.imwrite(path, np.asarray(pixels, np.float32), photometric="rgb", **options)
    return read_photo(path)


def test_floats_in_a_profile_keep_highlights_and_what_lies_beyond(tmp_path):
    bright = np.full((4, 5, 3), 4.0)
    photo = float_tiff(tmp_path / "a.tif", bright, iccprofile=rgb_profile(gamma(1)))
    np.testing.assert_allclose(photo.linear, 4.0, rtol=1e-3)
    assert photo.bits == 32
    green = np.zeros((4, 5, 3))
    green[..., 1] = 3.0
    photo = float_tiff(tmp_path / "b.tif", green, iccprofile=rgb_profile(gamma(1)))
    whole = photo.linear + photo.beyond
    # Display P3's green in Rec.709 (Bradford's adaptation makes no difference between whites of D65).
    np.testing.assert_allclose(whole[0, 0], np.array([-0.2249, 1.0421, -0.0786]) * 3, atol=0.01)


def test_floats_in_a_curved_profile_go_on_beyond_white(tmp_path):
    steps = np.array([0.5, 1.0, 1.25, 1.5])[None, :, None] * np.ones((2, 1, 3))
    linear = float_tiff(tmp_path / "a.tif", steps, iccprofile=rgb_profile(gamma(2))).linear[0, :, 0]
    np.testing.assert_allclose(linear, [0.25, 1.0, 1.5, 2.0], atol=0.01)


@pytest.mark.parametrize("profile", [None, rgb_profile(gamma(1))])
def test_floats_are_turned_upright_and_keep_what_the_file_says(tmp_path, profile):
    pixels = np.zeros((4, 6, 3))
    pixels[0, 0] = 1.0
    turned = [(274, "H", 1, 6, True), (271, "s", 7, "Camera", True)]
    photo = float_tiff(tmp_path / "a.tif", pixels, iccprofile=profile, extratags=turned)
    assert photo.linear.shape == (6, 4, 3)
    assert photo.linear[0, 3].min() > 0.99 > photo.linear.sum() / 4
    assert b"Camera" in photo.exif


@pytest.mark.parametrize("profile", [None, rgb_profile(gamma(1))])
@pytest.mark.parametrize("extra", ["unassalpha", "assocalpha"])
@pytest.mark.parametrize("planes", ["contig", "separate"])
def test_floats_with_alpha_are_turned_upright_and_divided_by_it_where_it_is_in_them(tmp_path, profile, extra, planes):
    rng = np.random.default_rng(1)
    grey, alpha = rng.uniform(0.1, 3, (4, 6, 1)).repeat(3, 2), rng.uniform(0.2, 1, (4, 6))
    stored = np.dstack([grey * alpha[..., None] if extra == "assocalpha" else grey, alpha])
    stored = stored if planes == "contig" else np.moveaxis(stored, -1, 0)
    how = {"extrasamples": [extra], "planarconfig": planes, "extratags": [(274, "H", 1, 6, True)]}
    photo = float_tiff(tmp_path / "a.tif", stored, iccprofile=profile, **how)
    np.testing.assert_allclose(photo.alpha, np.rot90(alpha, -1), rtol=1e-6)
    np.testing.assert_allclose(photo.linear, np.rot90(grey, -1), rtol=1e-3)
    assert photo.icc == profile


def grey_profile(value):
    return profile_bytes(b"GRAY", {b"wtpt": xyz((0.9642, 1.0, 0.8249)), b"kTRC": gamma(value)})


@pytest.mark.parametrize("profile", [None, grey_profile(1)])
def test_grey_floats_become_three_equal_channels(tmp_path, profile):
    tifffile.imwrite(tmp_path / "a.tif", np.full((4, 5), 2.5, np.float32), photometric="minisblack", iccprofile=profile)
    photo = read_photo(tmp_path / "a.tif")
    np.testing.assert_allclose(photo.linear, np.full((4, 5, 3), 2.5), rtol=1e-3)
    assert photo.icc is None


@pytest.mark.parametrize("suffix", [".png", ".tif"])
def test_grey_with_alpha_is_in_its_grey_profile(tmp_path, suffix):
    grey = np.full((6, 7), 128, np.uint8)
    half = np.full((6, 7), 51, np.uint8)
    for name, pixels in (("l", grey), ("la", np.dstack([grey, half]))):
        path = tmp_path / f"{name}{suffix}"
        Image.fromarray(pixels).save(path, icc_profile=grey_profile(1.0))
        np.testing.assert_allclose(read_photo(path).linear, 128 / 255, atol=1e-4)
    np.testing.assert_allclose(read_photo(path).alpha, 0.2, atol=1e-6)


def test_grey_whose_alpha_is_one_code_is_in_its_grey_profile(tmp_path):
    grey = np.full((6, 7), 128, np.uint8)
    grey[0] = 3
    Image.fromarray(grey).save(tmp_path / "a.png", icc_profile=grey_profile(1.0), transparency=3)
    photo = read_photo(tmp_path / "a.png")
    np.testing.assert_allclose(photo.linear[1:], 128 / 255, atol=1e-4)
    np.testing.assert_array_equal(photo.alpha[:2, 0], [0, 1])


def test_deep_grey_with_alpha_is_in_its_grey_profile(tmp_path):
    pixels = np.full((4, 5, 2), (32896, 13107), ">u2")
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    chunks = chunk(b"IHDR", struct.pack(">IIBBBBB", 5, 4, 16, 4, 0, 0, 0))
    chunks += chunk(b"iCCP", b"icc\0\0" + zlib.compress(grey_profile(1.0)))
    chunks += chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    (tmp_path / "a.png").write_bytes(SIGNATURE + chunks)
    photo = read_photo(tmp_path / "a.png")
    assert photo.bits == 16
    np.testing.assert_allclose(photo.linear, 32896 / 65535, atol=1e-4)
    np.testing.assert_allclose(photo.alpha, 0.2, atol=1e-5)


def test_an_enormous_float_in_a_profile_stays_the_brightest(tmp_path):
    pixels = np.full((4, 5, 3), 0.5)
    pixels[0, 0] = 3.4e38
    photo = float_tiff(tmp_path / "a.tif", pixels, iccprofile=rgb_profile(gamma(2)))
    np.testing.assert_allclose(photo.linear[0, 0], 1e16)
    np.testing.assert_allclose(photo.linear[1, 1], 0.25, atol=1e-3)


def test_a_profile_whose_colours_lie_in_a_plane_is_none_to_write_in():
    red, green, _ = P3
    assert matrix_profile(rgb_profile(gamma(2.2)), 3) is not None
    assert matrix_profile(rgb_profile(gamma(2.2), columns=[red, green, red]), 3) is None


@pytest.mark.parametrize(("transfer", "name"), [(16, "PQ"), (18, "HLG"), (13, None)])
@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif"])
def test_a_profile_that_says_hdr_is_refused_as_hdr_numbers_are(tmp_path, transfer, name, suffix):
    p3 = rgb_profile(gamma(2.2))
    said = rgb_profile(gamma(2.2), more={b"cicp": b"cicp\0\0\0\0" + bytes([9, transfer, 0, 1])})
    grey = Image.new("RGB", (16, 12), (90, 120, 150))
    grey.save(tmp_path / ("plain" + suffix), icc_profile=p3)
    grey.save(tmp_path / ("said" + suffix), icc_profile=said)
    if name is None:
        plain, photo = (read_photo(tmp_path / (stem + suffix)) for stem in ("plain", "said"))
        np.testing.assert_array_equal(photo.linear, plain.linear)
        return
    with pytest.raises(InputError, match=rf"HDR picture \({name}\)"):
        read_photo(tmp_path / ("said" + suffix))


def test_every_channel_has_its_own_curve(tmp_path):
    profile, codes = rgb_profile(gamma(1.5), gamma(2.0), gamma(3.0)), np.full((4, 5, 3), 32768, np.uint16)
    tifffile.imwrite(tmp_path / "a.tif", codes, photometric="rgb", iccprofile=profile)
    photo = read_photo(tmp_path / "a.tif")
    own = np.linalg.solve(matrix_profile(profile, 3).matrix, photo.linear[1, 1])
    np.testing.assert_allclose(own, [0.5**1.5, 0.5**2, 0.5**3], atol=1e-3)
    write_bands(tmp_path / "b.png", (4, 5), cut(photo.linear, None), False, FileStyle(16, icc=photo.icc))
    back = cv2.imread(str(tmp_path / "b.png"), cv2.IMREAD_UNCHANGED)
    np.testing.assert_allclose(back.astype(int), 32768, atol=30)


def test_a_matrix_counts_before_a_table_that_is_there_too():
    table = {b"A2B0": b"mft2" + bytes(60)}
    assert matrix_profile(rgb_profile(gamma(2.2), more=table), 3) is not None
    assert matrix_profile(profile_bytes(b"RGB ", table), 3) is None


def test_a_transfer_function_that_is_cut_or_something_else_is_none():
    for said in (b"cicp\0\0\0\0", b"text\0\0\0\0\x09\x10\0\1"):
        assert stated_transfer(rgb_profile(gamma(2.2), more={b"cicp": said})) is None


@pytest.mark.parametrize("curve", [gamma(0), b"curv\0\0\0\0" + struct.pack(">IHH", 2, 40000, 40100)])
def test_a_profile_with_a_flat_curve_counts_as_none(tmp_path, curve):
    pixels = np.random.default_rng(3).integers(0, 256, (8, 9, 3)).astype(np.uint8)
    Image.fromarray(pixels).save(tmp_path / "plain.png")
    Image.fromarray(pixels).save(tmp_path / "flat.png", icc_profile=rgb_profile(gamma(2.2), curve, gamma(2.2)))
    Image.fromarray(pixels[..., 0]).save(tmp_path / "grey.png", icc_profile=profile_bytes(b"GRAY", {b"kTRC": curve}))
    plain, flat, grey = (read_photo(tmp_path / f"{name}.png") for name in ("plain", "flat", "grey"))
    np.testing.assert_array_equal(flat.linear, plain.linear)
    np.testing.assert_array_equal(grey.linear, np.repeat(plain.linear[..., :1], 3, axis=2))
    assert flat.icc is None


def table_profile():
    """An RGB profile of tables, as printers and scanners have, for which a code is a share of Lab's lightness."""
    identity = np.tile(np.arange(256, dtype=np.uint8), 3).tobytes()
    matrix = b"".join(fixed(value) for value in np.eye(3).ravel())
    corners = bytes(c for r in (0, 1) for g in (0, 1) for b in (0, 1) for c in (255 * (r + g + b) // 3, 128, 128))
    table = b"mft1\0\0\0\0" + bytes([3, 3, 2, 0]) + matrix + identity + corners + identity
    profile = profile_bytes(b"RGB ", {b"wtpt": xyz((0.9642, 1.0, 0.8249)), b"A2B0": table})
    return profile[:20] + b"Lab " + profile[24:]


def test_deep_codes_in_a_profile_of_tables_are_those_of_8_bits(tmp_path):
    codes = np.random.default_rng(0).integers(0, 256, (8, 9, 1)).repeat(3, 2).astype(np.uint8)
    deep = codes.astype(np.uint16) * 256 + np.arange(9, dtype=np.uint16)[:, None] * 20
    for name, values in (("flat", codes), ("deep", deep)):
        tifffile.imwrite(tmp_path / f"{name}.tif", values, photometric="rgb", iccprofile=table_profile())
    flat, of_deep = (read_photo(tmp_path / f"{name}.tif") for name in ("flat", "deep"))
    lightness = codes[..., 1] / 255
    luminance = np.where(lightness > 0.08, ((lightness + 0.16) / 1.16) ** 3, lightness / 9.033)
    np.testing.assert_allclose(flat.linear[..., 1], luminance, atol=0.01)
    np.testing.assert_array_equal(of_deep.linear, flat.linear)
    assert (of_deep.bits, of_deep.icc) == (8, None)
