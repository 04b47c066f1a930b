"""Photos of every kind, and what is none."""

import io
import struct
import zlib

import cv2
import numpy as np
import OpenEXR
import pytest
import tifffile
from PIL import Image

from relight_core.errors import InputError
from relight_core.imaging.formats.png import SIGNATURE, chunk
from relight_core.imaging.read import read_photo, read_radiance

# Four quarters of different colours: no orientation of it looks like another.
QUARTERS = np.zeros((16, 24, 3), np.uint8)
QUARTERS[:8, :12] = (255, 0, 0)
QUARTERS[:8, 12:] = (0, 255, 0)
QUARTERS[8:, :12] = (0, 0, 255)
QUARTERS[8:, 12:] = (255, 255, 255)


def saved(path, pixels, **options):
    Image.fromarray(pixels).save(path, **options)
    return path


def corner_colours(photo):
    linear = photo.linear
    corners = [linear[1, 1], linear[1, -2], linear[-2, 1], linear[-2, -2]]
    return [tuple(np.rint(corner).astype(int)) for corner in corners]


RED, GREEN, BLUE, WHITE = (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)


@pytest.mark.parametrize("name", ["a.png", "a.jpg", "a.tif", "a.webp", "a.bmp"])
def test_formats_of_8_bits(tmp_path, name):
    options = {"quality": 100} if name.endswith(("jpg", "webp")) else {}
    photo = read_photo(saved(tmp_path / name, QUARTERS, **options))
    assert corner_colours(photo) == [RED, GREEN, BLUE, WHITE]
    assert photo.bits == 8
    assert photo.alpha is None
    assert photo.path == tmp_path / name
    assert photo.linear.dtype == np.float32
    assert photo.linear.flags.c_contiguous


def test_the_name_does_not_decide_the_format(tmp_path):
    saved(tmp_path / "a.png", QUARTERS)
    (tmp_path / "a.png").rename(tmp_path / "a.jpg")
    assert corner_colours(read_photo(tmp_path / "a.jpg")) == [RED, GREEN, BLUE, WHITE]


@pytest.mark.parametrize("extension", [".png", ".tif"])
def test_16_bits_stay_16_bits(tmp_path, extension):
    ramp = np.arange(20000, 20000 + 64, dtype=np.uint16)
    pixels = np.repeat(np.repeat(ramp[None, :, None], 2, 0), 3, 2)
    _, encoded = cv2.imencode(extension, pixels)
    path = tmp_path / f"deep{extension}"
    path.write_bytes(encoded.tobytes())
    photo = read_photo(path)
    assert photo.bits == 16
    assert len(np.unique(photo.linear[0, :, 0])) == 64
    assert photo.linear[0, 0, 0] == pytest.approx(((20000 / 65535 + 0.055) / 1.055) ** 2.4, rel=1e-4)


def test_16_bit_channels_keep_their_order_and_alpha(tmp_path):
    bgra = np.zeros((3, 4, 4), np.uint16)
    bgra[...] = (0, 0, 65535, 13107)
    _, encoded = cv2.imencode(".png", bgra)
    (tmp_path / "a.png").write_bytes(encoded.tobytes())
    photo = read_photo(tmp_path / "a.png")
    np.testing.assert_allclose(photo.linear[0, 0], RED, atol=1e-6)
    np.testing.assert_allclose(photo.alpha, 0.2, atol=1e-5)


@pytest.mark.parametrize("extension", [".png", ".tif"])
def test_grey_images_become_three_equal_channels(tmp_path, extension):
    grey8 = read_photo(saved(tmp_path / f"8{extension}", np.full((4, 5), 128, np.uint8)))
    np.testing.assert_allclose(grey8.linear, np.full((4, 5, 3), 0.21586), atol=1e-5)
    grey16 = read_photo(saved(tmp_path / f"16{extension}", np.full((4, 5), 32896, np.uint16)))
    np.testing.assert_allclose(grey16.linear, 0.21586, atol=1e-5)
    assert grey16.linear.shape == (4, 5, 3)
    assert grey16.bits == 16


def test_palette_one_bit_and_cmyk(tmp_path):
    Image.fromarray(QUARTERS).quantize(8).save(tmp_path / "p.png")
    assert corner_colours(read_photo(tmp_path / "p.png")) == [RED, GREEN, BLUE, WHITE]
    Image.fromarray(QUARTERS).convert("CMYK").save(tmp_path / "c.jpg", quality=100)
    assert corner_colours(read_photo(tmp_path / "c.jpg")) == [RED, GREEN, BLUE, WHITE]
    Image.fromarray(QUARTERS[..., 0] > 0).save(tmp_path / "1.png")
    assert corner_colours(read_photo(tmp_path / "1.png")) == [WHITE, (0, 0, 0), (0, 0, 0), WHITE]


def test_alpha_is_read_straight(tmp_path):
    pixels = np.dstack([QUARTERS, np.full((16, 24), 51, np.uint8)])
    for name in ("a.png", "a.tif", "a.webp"):
        photo = read_photo(saved(tmp_path / name, pixels, **({"lossless": True} if "webp" in name else {})))
        np.testing.assert_allclose(photo.alpha, 0.2, atol=1e-6)
        assert corner_colours(photo) == [RED, GREEN, BLUE, WHITE]


def test_multiplied_alpha_of_a_deep_tiff_is_divided_out(tmp_path):
    pixels = np.zeros((4, 4, 4), np.uint16)
    pixels[...] = (30000, 0, 0, 30000)
    tifffile.imwrite(tmp_path / "a.tif", pixels, photometric="rgb", extrasamples=["assocalpha"])
    photo = read_photo(tmp_path / "a.tif")
    np.testing.assert_allclose(photo.linear[0, 0], RED, atol=1e-4)
    np.testing.assert_allclose(photo.alpha, 30000 / 65535, atol=1e-5)


# Where the stored corners (red, green, blue, white) are to be seen, by EXIF orientation.
UPRIGHT = {
    1: [RED, GREEN, BLUE, WHITE],
    2: [GREEN, RED, WHITE, BLUE],
    3: [WHITE, BLUE, GREEN, RED],
    4: [BLUE, WHITE, RED, GREEN],
    5: [RED, BLUE, GREEN, WHITE],
    6: [BLUE, RED, WHITE, GREEN],
    7: [WHITE, GREEN, BLUE, RED],
    8: [GREEN, WHITE, RED, BLUE],
}


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("name", ["a.jpg", "a.png", "a.tif"])
def test_exif_orientation(tmp_path, name, orientation):
    exif = Image.Exif()
    exif[274] = orientation
    photo = read_photo(saved(tmp_path / name, QUARTERS, exif=exif))
    assert corner_colours(photo) == UPRIGHT[orientation]
    assert photo.linear.shape[:2] == ((16, 24) if orientation < 5 else (24, 16))


@pytest.mark.parametrize("orientation", range(1, 9))
def test_orientation_of_a_deep_tiff(tmp_path, orientation):
    pixels = QUARTERS.astype(np.uint16) * 257
    tag = [(274, "H", 1, orientation, True)]
    tifffile.imwrite(tmp_path / "a.tif", pixels, photometric="rgb", extratags=tag, metadata=None)
    assert corner_colours(read_photo(tmp_path / "a.tif")) == UPRIGHT[orientation]


def test_alpha_turns_with_the_photo(tmp_path):
    alpha = np.full((16, 24), 255, np.uint8)
    alpha[0, 0] = 0
    exif = Image.Exif()
    exif[274] = 6
    photo = read_photo(saved(tmp_path / "a.png", np.dstack([QUARTERS, alpha]), exif=exif))
    assert photo.alpha[0, -1] == 0.0
    assert photo.alpha.sum() == 16 * 24 - 1


def test_float_tiff_is_linear_and_cleaned(tmp_path):
    pixels = np.full((4, 5, 3), 2.5, np.float32)
    pixels[0, 0], pixels[0, 1], pixels[0, 2] = np.nan, np.inf, -3.0
    tifffile.imwrite(tmp_path / "f.tif", pixels, photometric="rgb")
    photo = read_photo(tmp_path / "f.tif")
    assert photo.bits == 32
    np.testing.assert_array_equal(photo.linear[0, :, 0], [0.0, 2.5, 0.0, 2.5, 2.5])


def write_exr(path, channels, **header):
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, **header}
    with OpenEXR.File(header, channels) as file:
        file.write(str(path))
    return path


def test_exr_is_read_and_cleaned_as_a_photo_and_left_alone_as_radiance(tmp_path):
    pixels = np.full((3, 4, 3), 7.0, np.float32)
    pixels[0, 0], pixels[0, 1], pixels[0, 2] = np.nan, np.inf, -1.0
    path = write_exr(tmp_path / "a.exr", {"RGB": pixels})
    np.testing.assert_array_equal(read_photo(path).linear[0, :, 1], [0.0, 7.0, 0.0, 7.0])
    np.testing.assert_array_equal(read_radiance(path), pixels)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_file_without_any_finite_value_is_refused_as_a_photo(tmp_path, value):
    pixels = np.full((3, 4, 3), value, np.float32)
    tifffile.imwrite(tmp_path / "a.tif", pixels, photometric="rgb")
    for path in (write_exr(tmp_path / "a.exr", {"RGB": pixels}), tmp_path / "a.tif"):
        with pytest.raises(InputError, match=f"{path.name}: none of its values is a finite number; export it again"):
            read_photo(path)


def test_exr_alpha_is_divided_out(tmp_path):
    pixels = np.zeros((2, 2, 4), np.float32)
    pixels[..., :] = (1.0, 0.5, 0.0, 0.5)
    pixels[0, 0] = 0.0
    photo = read_photo(write_exr(tmp_path / "a.exr", {"RGBA": pixels}))
    np.testing.assert_allclose(photo.linear[1, 1], (2.0, 1.0, 0.0))
    np.testing.assert_array_equal(photo.linear[0, 0], 0.0)
    assert photo.alpha[0, 0] == 0.0
    assert photo.alpha[1, 1] == 0.5


def test_alpha_of_an_exr_that_is_no_share_counts_as_the_nearest(tmp_path):
    pixels = np.full((2, 4, 4), 0.5, np.float32)
    pixels[0, :, 3] = np.nan, -1.0, 2.0, np.inf
    photo = read_photo(write_exr(tmp_path / "a.exr", {"RGBA": pixels}))
    np.testing.assert_array_equal(photo.alpha, [[0, 0, 1, 1], [0.5] * 4])
    np.testing.assert_array_equal(photo.linear[..., 0], [[0.5] * 4, [1.0] * 4])


def test_an_exr_of_luminance_and_chroma_is_refused_for_what_it_is(tmp_path):
    plane = np.full((4, 4), 0.5, np.float32)
    path = write_exr(tmp_path / "a.exr", {"Y": plane, "RY": plane, "BY": plane})
    with pytest.raises(InputError, match="luminance and chroma; export it as RGB"):
        read_photo(path)


@pytest.mark.parametrize(
    ("corner", "seen_share"),
    [((60, 0), 0), ((0, 60), 0), ((500, 500), 0), ((-40, -40), 0), ((20, 10), 0.25), ((0, 0), 1)],
)
def test_an_exr_whose_data_lie_beside_its_display_window_is_black_there(tmp_path, corner, seen_share):
    # 40 x 40 pixels of data; the display shows 40 x 20.
    data = np.array(corner, np.int32), np.array(corner, np.int32) + 39
    display = np.array((0, 0), np.int32), np.array((39, 19), np.int32)
    pixels = np.full((40, 40, 3), 0.5, np.float32)
    path = write_exr(tmp_path / "a.exr", {"RGB": pixels}, dataWindow=data, displayWindow=display)
    linear = read_photo(path).linear
    assert linear.shape == (20, 40, 3)
    assert linear.mean() == pytest.approx(0.5 * seen_share)


def test_enormous_radiance_is_limited_to_what_can_be_reckoned_with(tmp_path):
    pixels = np.full((2, 3, 3), 0.5, np.float32)
    pixels[0, 0], pixels[0, 1, 2] = 3.4e38, -3.4e38
    photo = read_photo(write_exr(tmp_path / "a.exr", {"RGB": pixels}))
    assert photo.linear[0, 0, 0] == np.float32(1e16)
    assert photo.linear[1, 2, 0] == 0.5
    assert photo.beyond[0, 1, 2] == -65504.0
    see_through = np.dstack([pixels, np.full((2, 3), 1e-6, np.float32)])
    photo = read_photo(write_exr(tmp_path / "b.exr", {"RGBA": see_through}))
    assert photo.linear.max() == np.float32(1e16)
    np.testing.assert_allclose(photo.linear[1], 5e5, rtol=1e-5)


def test_exr_of_one_channel_or_one_layer(tmp_path):
    grey = write_exr(tmp_path / "y.exr", {"Y": np.full((2, 4), 3.0, np.float32)})
    np.testing.assert_array_equal(read_radiance(grey), np.full((2, 4, 3), 3.0))
    layer = write_exr(tmp_path / "l.exr", {"beauty": np.full((2, 4, 3), 2.0, np.float32)})
    np.testing.assert_array_equal(read_radiance(layer), np.full((2, 4, 3), 2.0))


def test_exr_of_a_renderer_is_its_picture_and_not_the_pass_that_comes_before_it(tmp_path):
    passes = {"ViewLayer.AO": 1.0, "ViewLayer.Combined": 2.0, "ViewLayer.Denoised": 3.0}
    layers = {name: np.full((2, 4, 3), value, np.float32) for name, value in passes.items()}
    np.testing.assert_array_equal(read_radiance(write_exr(tmp_path / "p.exr", layers)), np.full((2, 4, 3), 2.0))
    depth = write_exr(tmp_path / "z.exr", {"Z": np.ones((2, 4), np.float32)})
    with pytest.raises(InputError, match="z.exr"):
        read_radiance(depth)


def test_exr_in_other_primaries_is_converted(tmp_path):
    wide = np.array([0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767], np.float32)
    grey = np.full((2, 4, 3), 0.5, np.float32)
    path = write_exr(tmp_path / "aces.exr", {"RGB": grey}, chromaticities=tuple(float(c) for c in wide))
    np.testing.assert_allclose(read_radiance(path), 0.5, atol=1e-4)
    red = np.zeros((2, 4, 3), np.float32)
    red[..., 0] = 1.0
    path = write_exr(tmp_path / "red.exr", {"RGB": red}, chromaticities=tuple(float(c) for c in wide))
    assert read_radiance(path)[0, 0, 0] == pytest.approx(2.52, abs=0.03)
    assert (read_photo(path).linear >= 0).all()


def test_radiance_hdr(tmp_path):
    pixels = np.linspace(0.1, 100, 8 * 16 * 3, dtype=np.float32).reshape(8, 16, 3)
    _, encoded = cv2.imencode(".hdr", np.ascontiguousarray(pixels[..., ::-1]))
    (tmp_path / "a.hdr").write_bytes(encoded.tobytes())
    np.testing.assert_allclose(read_radiance(tmp_path / "a.hdr"), pixels, rtol=0.02, atol=0.5)
    assert read_photo(tmp_path / "a.hdr").bits == 32


def png_header(width, height):
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    end = chunk(b"IDAT", zlib.compress(b"\0")) + chunk(b"IEND", b"")
    return SIGNATURE + chunk(b"IHDR", header) + end


def encoded_as(kind):
    noise = np.random.default_rng(1).integers(0, 256, (40, 80, 3)).astype(np.uint8)
    buffer = io.BytesIO()
    if kind in ("deep.png", "deep.tif"):
        return cv2.imencode(kind[-4:], noise.astype(np.uint16) * 257)[1].tobytes()
    if kind == "a.hdr":
        return cv2.imencode(".hdr", noise.astype(np.float32))[1].tobytes()
    if kind == "float.tif":
        tifffile.imwrite(buffer, noise.astype(np.float32), photometric="rgb")
        return buffer.getvalue()
    formats = {"jpg": "JPEG", "png": "PNG", "tif": "TIFF", "ebp": "WEBP"}
    Image.fromarray(noise).save(buffer, formats[kind[-3:]])
    return buffer.getvalue()


KINDS = ["a.jpg", "a.png", "a.tif", "a.webp", "deep.png", "deep.tif", "float.tif", "a.hdr"]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_truncated_files_are_refused_in_one_line(tmp_path, kind, share, capfd):
    data = encoded_as(kind)
    path = tmp_path / kind
    path.write_bytes(data[: int(len(data) * share)])
    with pytest.raises(InputError) as refusal:
        read_photo(path)
    assert kind in str(refusal.value)
    assert "\n" not in str(refusal.value)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("progressive", [False, True])
def test_a_jpeg_that_lacks_nothing_but_its_end_is_whole(tmp_path, progressive, capfd):
    noise, buffer = np.random.default_rng(2).integers(0, 256, (40, 56, 3)).astype(np.uint8), io.BytesIO()
    Image.fromarray(noise).save(buffer, "JPEG", progressive=progressive)
    path, whole = tmp_path / "a.jpg", buffer.getvalue()
    path.write_bytes(whole)
    pixels = read_photo(path).linear
    for missing in (1, 2):
        path.write_bytes(whole[:-missing])
        np.testing.assert_array_equal(read_photo(path).linear, pixels)
    for missing in (4, 6, 20, 200):
        path.write_bytes(whole[:-missing])
        with pytest.raises(InputError, match="truncated or damaged"):
            read_photo(path)
    assert capfd.readouterr() == ("", "")


def test_a_progressive_jpeg_that_ends_between_two_scans_is_truncated(tmp_path):
    noise, buffer = np.random.default_rng(2).integers(0, 256, (40, 56, 3)).astype(np.uint8), io.BytesIO()
    Image.fromarray(noise).save(buffer, "JPEG", progressive=True, comment=b"\xff\xda\xff\xd9")
    whole, path = buffer.getvalue(), tmp_path / "a.jpg"
    parts = [at for at in range(len(whole)) if whole[at : at + 2] in (b"\xff\xc4", b"\xff\xda")][3:]
    assert len(parts) > 10
    for at in parts:
        path.write_bytes(whole[: at + 1])
        with pytest.raises(InputError, match="truncated or damaged"):
            read_photo(path)
    path.write_bytes(whole[:-2])
    assert read_photo(path).linear.shape == (40, 56, 3)


@pytest.mark.parametrize("share", [0.02, 0.3, 0.9])
def test_truncated_exr_is_refused_quietly(tmp_path, share, capfd):
    noise = np.random.default_rng(1).random((64, 64, 3)).astype(np.float32)
    data = write_exr(tmp_path / "whole.exr", {"RGB": noise}).read_bytes()
    (tmp_path / "cut.exr").write_bytes(data[: int(len(data) * share)])
    with pytest.raises(InputError, match="cut.exr"):
        read_radiance(tmp_path / "cut.exr")
    assert capfd.readouterr() == ("", "")


def test_what_is_no_image_is_named(tmp_path):
    (tmp_path / "empty.jpg").touch()
    (tmp_path / "text.jpg").write_text("hello " * 100)
    (tmp_path / "bomb.png").write_bytes(png_header(30000, 20000))
    cases = {
        "missing.jpg": "no such file",
        "empty.jpg": "the file is empty",
        "text.jpg": "not an image",
        "bomb.png": "400 megapixels",
        ".": "folder",
        "a\0b": "can't be read",
    }
    for name, fault in cases.items():
        with pytest.raises(InputError, match=fault) as refusal:
            read_photo(tmp_path / name)
        assert "\n" not in str(refusal.value)


def test_a_photo_is_no_radiance_map(tmp_path):
    with pytest.raises(InputError, match=r"\.hdr or \.exr"):
        read_radiance(saved(tmp_path / "a.png", QUARTERS))


def test_other_bytes_never_raise_anything_else(tmp_path):
    rng = np.random.default_rng(3)
    path = tmp_path / "x"
    for kind in KINDS:
        data = bytearray(encoded_as(kind))
        for _ in range(12):
            damaged = bytearray(data)
            for position in rng.integers(0, min(len(data), 400), 6):
                damaged[position] = rng.integers(0, 256)
            path.write_bytes(bytes(damaged))
            try:
                photo = read_photo(path)
            except InputError:
                continue
            assert np.isfinite(photo.linear).all()
            assert (photo.linear >= 0).all()
