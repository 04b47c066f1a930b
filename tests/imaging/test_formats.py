"""Colour profiles written back, metadata carried, files in bands, and files that are no pictures yet."""

import io

import cv2
import numpy as np
import pytest
import tifffile
from PIL import Image, ImageCms

from relight_core.errors import InputError
from relight_core.imaging.photo import Photo
from relight_core.imaging.read import read_photo
from relight_core.imaging.write import FileStyle, write_bands, write_image

RNG = np.random.default_rng(4)


def adobe_like_profile():
    """A matrix profile of gamma 2.2 and wide primaries, built on sRGB's bytes."""
    import struct

    icc = bytearray(ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes())
    wide = {
        b"rXYZ": (0.60974, 0.31111, 0.01947),
        b"gXYZ": (0.20528, 0.62567, 0.06087),
        b"bXYZ": (0.14919, 0.06322, 0.74457),
    }
    (count,) = struct.unpack_from(">I", icc, 128)
    for index in range(count):
        name, offset, _ = struct.unpack_from(">4sII", icc, 132 + 12 * index)
        if name in wide:
            struct.pack_into(">3i", icc, offset + 8, *(round(v * 65536) for v in wide[name]))
    return bytes(icc)


def picture(size=(20, 24)):
    return RNG.uniform(0.1, 0.8, (*size, 3)).astype(np.float32)


@pytest.mark.parametrize("suffix", [".png", ".tif", ".jpg"])
def test_a_profile_is_converted_and_written_back(tmp_path, suffix):
    icc = adobe_like_profile()
    path = tmp_path / f"wide{suffix}"
    linear = np.broadcast_to(picture((1, 1)), (16, 16, 3)).copy()
    bits = 8 if suffix == ".jpg" else 16
    write_bands(path, (16, 16), [(slice(0, 16), linear, None)], False, FileStyle(bits, 100, icc=icc))
    back = read_photo(path)
    np.testing.assert_allclose(back.linear, linear, atol=0.012 if bits == 8 else 0.001)
    assert back.icc == icc
    stored = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)[0, 0, ::-1] / (2**bits - 1)
    plain = tmp_path / f"srgb{suffix}"
    write_image(plain, linear, bits=bits, quality=100)
    assert np.abs(stored - cv2.imread(str(plain), cv2.IMREAD_UNCHANGED)[0, 0, ::-1] / (2**bits - 1)).max() > 0.02


def test_an_srgb_photo_remembers_no_profile(tmp_path):
    write_image(tmp_path / "plain.png", picture())
    assert read_photo(tmp_path / "plain.png").icc is None


def test_a_profile_that_is_no_matrix_is_refused(tmp_path):
    with pytest.raises(InputError, match="profile"):
        write_bands(tmp_path / "x.png", (4, 4), [], False, FileStyle(icc=b"nonsense"))
    assert not (tmp_path / "x.png").exists()


@pytest.mark.parametrize("suffix", [".png", ".tif", ".jpg", ".exr"])
@pytest.mark.parametrize("with_alpha", [False, True])
def test_bands_make_the_same_file_as_the_whole(tmp_path, suffix, with_alpha):
    linear = 3 * picture((30, 10))
    alpha = RNG.random((30, 10), np.float32) if with_alpha else None
    write_image(tmp_path / f"whole{suffix}", linear, alpha)
    parts = [slice(0, 7), slice(7, 29), slice(29, 30)]
    bands = ((rows, linear[rows], None if alpha is None else alpha[rows]) for rows in parts)
    write_bands(tmp_path / f"bands{suffix}", (30, 10), bands, with_alpha, FileStyle())
    whole, cut = (read_photo(tmp_path / f"{name}{suffix}") for name in ("whole", "bands"))
    np.testing.assert_array_equal(whole.linear, cut.linear)
    if whole.alpha is not None:
        np.testing.assert_array_equal(whole.alpha, cut.alpha)


def exif_of(**tags):
    exif = Image.Exif()
    numbers = {"make": 271, "orientation": 274, "artist": 315}
    for name, value in tags.items():
        exif[numbers[name]] = value
    return exif


@pytest.mark.parametrize("suffix", [".png", ".jpg"])
def test_metadata_is_carried_and_stands_upright(tmp_path, suffix):
    source = tmp_path / "camera.jpg"
    Image.fromarray(np.full((8, 12, 3), 90, np.uint8)).save(
        source, exif=exif_of(make="Maker", orientation=6, artist="A")
    )
    photo = read_photo(source)
    assert photo.linear.shape == (12, 8, 3)
    result = tmp_path / f"result{suffix}"
    write_bands(result, (12, 8), [(slice(0, 12), photo.linear, None)], False, FileStyle(exif=photo.exif))
    with Image.open(result) as written:
        carried = written.getexif()
        assert (carried[271], carried[315]) == ("Maker", "A")
        assert carried.get(274, 1) == 1
    assert read_photo(result).linear.shape == (12, 8, 3)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_deep_tiffs_stand_upright_too(tmp_path, orientation):
    codes = RNG.integers(0, 65536, (6, 9, 3), np.uint16)
    tifffile.imwrite(tmp_path / "deep.tif", codes, photometric="rgb", extratags=[(274, "H", 1, orientation, True)])
    tifffile.imwrite(
        tmp_path / "flat.tif",
        (codes >> 8).astype(np.uint8),
        photometric="rgb",
        extratags=[(274, "H", 1, orientation, True)],
    )
    deep, flat = (read_photo(tmp_path / name).linear for name in ("deep.tif", "flat.tif"))
    assert deep.shape == flat.shape
    np.testing.assert_allclose(deep, flat, atol=0.02)


@pytest.mark.parametrize(("kind", "options"), [("WEBP", {"lossless": True}), ("AVIF", {"quality": 100})])
def test_webp_and_avif_are_read(tmp_path, kind, options):
    from PIL import features

    if not features.check(kind.lower()):
        pytest.skip(f"this Pillow reads no {kind}")
    codes = np.full((16, 16, 3), (200, 120, 40), np.uint8)
    buffer = io.BytesIO()
    Image.fromarray(codes).save(buffer, kind, **options)
    path = tmp_path / f"photo.{kind.lower()}"
    path.write_bytes(buffer.getvalue())
    np.testing.assert_allclose(read_photo(path).linear, Photo.from_srgb(codes).linear, atol=0.03)


def test_a_cmyk_jpeg_is_read_in_colour(tmp_path):
    Image.new("CMYK", (12, 10), (0, 200, 200, 20)).save(tmp_path / "cmyk.jpg", quality=95)
    red, green, blue = read_photo(tmp_path / "cmyk.jpg").linear.mean((0, 1))
    assert red > 3 * max(green, blue)


@pytest.mark.parametrize("depth", [np.uint8, np.uint16])
def test_grey_photos_become_grey_colour(tmp_path, depth):
    codes = np.full((10, 12), np.iinfo(depth).max // 2, depth)
    for name in ("grey.png", "grey.tif"):
        cv2.imwrite(str(tmp_path / name), codes)
        linear = read_photo(tmp_path / name).linear
        assert linear.shape == (10, 12, 3)
        np.testing.assert_allclose(linear, 0.212, atol=0.003)


@pytest.mark.parametrize("share", [0.2, 0.9])
@pytest.mark.parametrize("brand", [b"avif", b"mif1"])
def test_an_avif_that_was_cut_is_damaged_and_not_no_image(tmp_path, share, brand):
    from PIL import features

    if not features.check("avif"):
        pytest.skip("this Pillow reads no AVIF")
    Image.fromarray(np.full((64, 48, 3), 90, np.uint8)).save(tmp_path / "a.avif")
    data = bytearray((tmp_path / "a.avif").read_bytes())
    data[8:12] = brand
    (tmp_path / "a.avif").write_bytes(data[: int(share * len(data))])
    with pytest.raises(InputError, match="truncated or damaged image"):
        read_photo(tmp_path / "a.avif")
