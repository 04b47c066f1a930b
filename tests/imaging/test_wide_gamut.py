"""Colours outside Rec.709: kept on reading, and written back."""

import cv2
import numpy as np
import pytest
import tifffile
from PIL import Image

from relight_core.imaging.colour import luminance
from relight_core.imaging.formats.exr import read_exr
from relight_core.imaging.formats.icc_making import DISPLAY_P3, REC2020, primaries_profile
from relight_core.imaging.photo import Photo
from relight_core.imaging.read import read_photo
from relight_core.imaging.write import FileStyle, cut, write_bands, write_exr_layers

P3 = primaries_profile(DISPLAY_P3)
P3_RED = (1.2249, -0.0420, -0.0196)
SATURATED = np.uint8([[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 0], [250, 10, 180], [255, 255, 255], [0, 0, 0]])


def wide(photo):
    return photo.linear if photo.beyond is None else photo.linear + photo.beyond.astype(np.float32)


def patches():
    return np.repeat(np.repeat(SATURATED[None], 9, axis=0), 6, axis=1)


def test_the_photo_is_clipped_and_what_was_clipped_is_kept(tmp_path):
    Image.fromarray(patches()).save(tmp_path / "a.png", icc_profile=P3)
    photo = read_photo(tmp_path / "a.png")
    np.testing.assert_array_equal(photo.linear[0, 0], (1, 0, 0))
    np.testing.assert_allclose(wide(photo)[0, 0], P3_RED, atol=2e-3)
    np.testing.assert_array_equal(photo.beyond[0, -1], 0)
    assert (photo.linear.min(), photo.linear.max()) == (0, 1)


def test_dim_colours_outside_rec709_are_kept_too(tmp_path):
    Image.fromarray(np.full((2, 2, 3), (40, 0, 0), np.uint8)).save(tmp_path / "a.png", icc_profile=P3)
    level = ((40 / 255 + 0.055) / 1.055) ** 2.4
    np.testing.assert_allclose(wide(read_photo(tmp_path / "a.png"))[0, 0], np.float32(P3_RED) * level, atol=1e-5)


def test_all_rows_of_a_high_photo_keep_what_lies_outside(tmp_path):
    codes = np.zeros((400, 2, 3), np.uint8)
    codes[[0, 130, 399]] = (255, 0, 0)
    Image.fromarray(codes).save(tmp_path / "a.png", icc_profile=P3)
    colours = wide(read_photo(tmp_path / "a.png"))
    np.testing.assert_allclose(colours[[0, 130, 399], 0], [P3_RED] * 3, atol=2e-3)
    assert np.abs(colours[[1, 129, 131, 398]]).max() == 0


def test_turning_turns_what_was_clipped_too(tmp_path):
    exif = Image.Exif()
    exif[274] = 6
    Image.fromarray(patches()).save(tmp_path / "a.png", icc_profile=P3, exif=exif)
    photo = read_photo(tmp_path / "a.png")
    np.testing.assert_allclose(wide(photo)[0, 0], P3_RED, atol=2e-3)
    np.testing.assert_allclose(wide(photo)[6, -1], (-0.2249, 1.042, -0.0786), atol=2e-3)


def test_a_photo_within_rec709_has_nothing_beyond(tmp_path):
    greys = np.repeat(np.arange(256, dtype=np.uint8)[None, :, None], 3, axis=2)
    Image.fromarray(greys).save(tmp_path / "a.png", icc_profile=P3)
    assert read_photo(tmp_path / "a.png").beyond is None


@pytest.mark.parametrize("icc", [P3, primaries_profile(REC2020)])
@pytest.mark.parametrize(("suffix", "bits"), [(".png", 8), (".png", 16), (".tif", 16)])
def test_every_colour_of_a_wide_profile_comes_back(tmp_path, icc, suffix, bits):
    rng = np.random.default_rng(3)
    codes = np.concatenate([SATURATED, rng.integers(0, 256, (4096 - len(SATURATED), 3))]).reshape(64, 64, 3)
    codes = codes.astype(np.uint8) if bits == 8 else (codes * 257).astype(np.uint16)
    tifffile.imwrite(tmp_path / "in.tif", codes, photometric="rgb", iccprofile=icc)
    photo = read_photo(tmp_path / "in.tif")
    style = FileStyle(bits, icc=photo.icc)
    write_bands(tmp_path / f"out{suffix}", (64, 64), cut(wide(photo), None), False, style)
    stored = cv2.imread(str(tmp_path / f"out{suffix}"), cv2.IMREAD_UNCHANGED)[..., ::-1]
    # Half floats hold what lies beyond: half a code of 8 bits at the worst, where a channel is nearly black.
    np.testing.assert_allclose(stored.astype(int), codes.astype(int), atol=1 if bits == 8 else 140)
    # Clipped to Rec.709 first, as what is shown is, they would not.
    assert np.abs(wide(photo) - photo.linear).max() > 0.2


def test_radiance_above_1_stays_within_the_profile_and_keeps_its_hue(tmp_path):
    hot = np.float32(P3_RED) * np.float32(1.5)
    write_bands(tmp_path / "a.png", (2, 2), cut(np.tile(hot, (2, 2, 1)), None), False, FileStyle(16, icc=P3))
    red, green, blue = np.asarray(wide(read_photo(tmp_path / "a.png")))[0, 0]
    assert red > 1
    assert abs(green - blue) < 0.1 * red


@pytest.mark.parametrize("codes", [(80, 80, 255), (255, 40, 40)])
def test_radiance_a_little_above_1_keeps_its_luminance_in_a_wide_profile(tmp_path, codes):
    icc = primaries_profile(REC2020)
    Image.fromarray(np.full((2, 2, 3), codes, np.uint8)).save(tmp_path / "in.png", icc_profile=icc)
    hot = np.float32(1.1) * wide(read_photo(tmp_path / "in.png"))
    write_bands(tmp_path / "out.png", (2, 2), cut(hot, None), False, FileStyle(16, icc=icc))
    shown = wide(read_photo(tmp_path / "out.png"))
    np.testing.assert_allclose(luminance(shown), luminance(hot), rtol=0.004)


def test_exr_holds_them(tmp_path):
    colours = np.tile(np.float32(P3_RED), (4, 4, 1))
    write_bands(tmp_path / "a.exr", (4, 4), cut(colours, None), False, FileStyle(32, exposure_ev=1.0))
    stored, _ = read_exr(tmp_path / "a.exr")
    np.testing.assert_allclose(stored[0, 0], 2 * np.float32(P3_RED), rtol=1e-5)
    photo = read_photo(tmp_path / "a.exr")
    assert photo.linear.min() == 0
    np.testing.assert_allclose(wide(photo), stored, atol=1e-4)


def test_negative_infinity_and_no_number_in_an_exr_are_black(tmp_path):
    values = np.full((2, 2, 3), 0.5, np.float32)
    values[0, 0], values[0, 1] = -np.inf, np.nan
    write_exr_layers(tmp_path / "a.exr", {"RGB": values}, half=False)
    photo = read_photo(tmp_path / "a.exr")
    np.testing.assert_array_equal(photo.linear[0], 0)
    assert np.isfinite(wide(photo)).all()


def test_a_photo_refuses_what_does_not_fit():
    linear = np.zeros((2, 2, 3), np.float32)
    with pytest.raises(ValueError, match="beyond"):
        Photo(linear, beyond=np.zeros((2, 2), np.float16))
