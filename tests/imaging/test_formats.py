"""Colour profiles written back, metadata carried, files in bands, and files that are no pictures yet."""

import io

import cv2
import numpy as np
import pytest
from PIL import Image, ImageCms, features

from relight_core.errors import InputError
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


@pytest.mark.parametrize("suffix", [".png", ".tif", ".jpg"])
def test_a_file_says_that_its_colours_are_srgb(tmp_path, suffix):
    write_image(tmp_path / f"a{suffix}", picture())
    with Image.open(tmp_path / f"a{suffix}") as image:
        said = image.info
    if suffix == ".png":
        assert said["srgb"] == 0
    else:
        profile = ImageCms.ImageCmsProfile(io.BytesIO(said["icc_profile"]))
        assert "sRGB" in ImageCms.getProfileDescription(profile)


def test_texts_of_a_png_are_read_as_they_were_written(tmp_path):
    notes = {"relightLight": "Abendlicht über 東京", "relightYawDeg": -30.5}
    write_image(tmp_path / "a.png", picture(), notes=notes)
    with Image.open(tmp_path / "a.png") as image:
        assert image.text == {"relightLight": "Abendlicht über 東京", "relightYawDeg": "-30.5"}


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
    assert (cut.alpha is not None) == (with_alpha and suffix != ".jpg")
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


def test_avif_is_read(tmp_path):
    if not features.check("avif"):
        pytest.skip("this Pillow reads no AVIF")
    Image.new("RGB", (16, 16), (200, 120, 40)).save(tmp_path / "a.avif", quality=100)
    # Each code by sRGB's formula: ((code / 255 + 0.055) / 1.055) ** 2.4.
    np.testing.assert_allclose(
        read_photo(tmp_path / "a.avif").linear, np.full((16, 16, 3), (0.578, 0.188, 0.021)), atol=0.03
    )


@pytest.mark.parametrize("share", [0.2, 0.9])
@pytest.mark.parametrize("brand", [b"avif", b"mif1"])
def test_an_avif_that_was_cut_is_damaged_and_not_no_image(tmp_path, share, brand):
    if not features.check("avif"):
        pytest.skip("this Pillow reads no AVIF")
    Image.fromarray(np.full((64, 48, 3), 90, np.uint8)).save(tmp_path / "a.avif")
    data = bytearray((tmp_path / "a.avif").read_bytes())
    data[8:12] = brand
    (tmp_path / "a.avif").write_bytes(data[: int(share * len(data))])
    with pytest.raises(InputError, match="truncated or damaged image"):
        read_photo(tmp_path / "a.avif")
