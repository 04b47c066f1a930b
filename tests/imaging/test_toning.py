"""Colour that stands in one small place is colour; what compression makes of a tone is none."""

import io

import numpy as np
import pytest
from PIL import Image

from relight_core.imaging.photo import Photo
from relight_core.imaging.toning import is_grey, is_mostly_grey

SEPIA = (1.1, 1.0, 0.7)
SKIN = (200, 150, 125)


def wall(height=800, width=600):
    """A dark suit before a grey wall, grainy: (H, W) sRGB in [0, 255]."""
    grey = np.full((height, width), 205.0)
    grey[height // 3 :, width // 4 : 3 * width // 4] = 60
    return grey + np.random.default_rng(0).normal(0, 1.5, grey.shape)


def coloured(grey, tone=(1.0, 1.0, 1.0)):
    """(H, W) sRGB in [0, 255] as (H, W, 3) codes, multiplied by a tone in linear light."""
    linear = Photo.from_srgb(np.uint8(np.clip(grey, 0, 255))[..., None].repeat(3, -1)).linear * np.float32(tone)
    return np.uint8(np.rint(255 * np.where(linear < 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)))


def compressed(codes, quality):
    buffer = io.BytesIO()
    Image.fromarray(codes).save(buffer, "JPEG", quality=quality)
    return np.asarray(Image.open(buffer))


def head(codes, colour, top=120, left=270, height=52, width=44):
    """An oval as large as the head of a full-length person, shaded from side to side."""
    y, x = np.mgrid[:height, :width]
    inside = ((y / height - 0.5) ** 2 + (x / width - 0.5) ** 2 < 0.25)[..., None]
    shaded = np.multiply.outer(0.4 + 0.6 * x / width, colour)
    there = codes[top : top + height, left : left + width]
    there[:] = np.where(inside, shaded, there)
    return codes


@pytest.mark.parametrize("quality", [50, 92])
@pytest.mark.parametrize(("top", "left"), [(120, 270), (131, 283), (0, 0), (748, 556)])
def test_a_small_coloured_face_before_grey_is_colour(quality, top, left):
    codes = head(coloured(wall()), SKIN, top, left)
    off_grey = np.ptp(codes.astype(int), axis=-1) > 8
    assert 0.002 < off_grey.mean() < 0.005
    assert not Photo.from_srgb(compressed(codes, quality)).monochrome


@pytest.mark.parametrize("brightness", [4, 25, 240])
def test_a_small_coloured_face_alone_is_colour(brightness):
    codes = head(np.full((800, 600, 3), brightness, np.uint8), SKIN)
    assert not Photo.from_srgb(codes).monochrome


@pytest.mark.parametrize("tone", [(1.0, 1.0, 1.0), SEPIA, (0.98, 1.0, 1.06)])
@pytest.mark.parametrize("brightness", [4, 25, 90])
def test_a_small_bright_face_in_the_dark_has_the_picture_s_tone(tone, brightness):
    # Next to nothing in the picture is as bright as the face, so its tone must be foreseen.
    grey = np.full((800, 600), float(brightness)) + np.random.default_rng(1).normal(0, 1, (800, 600))
    face = head(np.repeat(grey[..., None], 3, -1), (220, 220, 220))[..., 0]
    assert Photo.from_srgb(coloured(face, tone)).monochrome


@pytest.mark.parametrize("quality", [75, 92])
@pytest.mark.parametrize("tone", [SEPIA, (0.98, 1.0, 1.06)])
def test_a_compressed_toned_picture_is_toned(quality, tone):
    # Chroma is stored by halves and in coarse steps, so that edges, of the bright face above all, are off the tone.
    grey = np.full((800, 600), 25.0)
    grey[300:, 150:450] = 60
    face = head(np.repeat(grey[..., None], 3, -1), (220, 220, 220))[..., 0]
    assert Photo.from_srgb(compressed(coloured(face, tone), quality)).monochrome


@pytest.mark.parametrize("tone", [SEPIA, (0.9, 1.0, 1.15)])
def test_what_small_files_add_to_a_tone_is_no_colour(tone):
    codes = coloured(wall(), tone).astype(float)
    codes[..., [0, 2]] += np.random.default_rng(1).normal(0, 1.8, (*codes.shape[:2], 2))
    assert Photo.from_srgb(np.uint8(np.rint(codes.clip(0, 255)))).monochrome


def test_a_faded_photo_is_colour():
    grey = np.broadcast_to(np.linspace(40, 220, 600), (800, 600)).astype(float)
    codes = head(coloured(grey), np.mean(SKIN) + 0.3 * (np.array(SKIN) - np.mean(SKIN)), 200, 150, 400, 300)
    assert not Photo.from_srgb(codes).monochrome


@pytest.mark.parametrize("size", [(1, 1), (1, 70), (3, 5), (9, 700)])
def test_pictures_of_any_shape(size):
    codes = np.full((*size, 3), 90, np.uint8)
    assert Photo.from_srgb(codes).monochrome
    if size != (1, 1):
        codes[:, : size[1] // 2] = (130, 70, 70)
        assert not Photo.from_srgb(codes).monochrome


@pytest.mark.parametrize("colours", [((130, 70, 70), (90, 90, 90)), ((90, 60, 120), (70, 140, 60))])
@pytest.mark.parametrize("across", [False, True])
def test_two_colours_of_one_brightness_are_no_tone_however_they_lie(colours, across):
    codes = np.full((48, 64, 3), colours[0], np.uint8)
    (codes.swapaxes(0, 1) if across else codes)[24:] = colours[1]
    assert not Photo.from_srgb(codes).monochrome


@pytest.mark.parametrize("quality", [50, 75, 95])
@pytest.mark.parametrize("strongest", [(1.351, 1.203, 0.937), (0.5, 0.9, 1.3)])
def test_a_strong_tone_stays_one_where_compression_blurs_it_at_every_edge(quality, strongest):
    # As apps tone photos: codes are multiplied, and end at 255. Hair and cloth have edges all over.
    rng = np.random.default_rng(2)
    fine = rng.uniform(0, 255, (67, 50)).repeat(12, 0).repeat(12, 1)[:800]
    grey = 0.4 * fine + 0.6 * np.linspace(0, 255, 600)
    codes = np.uint8(np.clip(np.multiply.outer(grey, strongest), 0, 255).round())
    assert Photo.from_srgb(compressed(codes, quality)).monochrome


def test_grey_is_what_has_neither_colours_nor_a_tone_but_for_noise_and_a_stray_mark():
    rng = np.random.default_rng(0)
    grey = np.repeat(rng.uniform(0.2, 0.8, (128, 128, 1)), 3, -1)
    assert is_grey(grey)
    assert is_grey(grey + rng.uniform(-0.04, 0.04, grey.shape))
    for tone in ((1.0, 1.0, 0.9), (1.0, 1.0, 1.1), (0.9, 1.0, 1.0), (1.1, 1.0, 1.0)):
        assert not is_grey(grey * tone)
    for side_px, is_stray in ((8, True), (24, False)):
        marked = grey.copy()
        marked[40 : 40 + side_px, 40 : 40 + side_px] = (0.8, 0.1, 0.1)
        assert is_grey(marked) == is_stray


class TestMostlyGrey:
    def photo(self):
        return np.repeat(np.random.default_rng(0).uniform(0.2, 0.8, (128, 128, 1)), 3, -1)

    @pytest.mark.parametrize(("coloured_rows", "remains_grey"), [(0, True), (40, True), (70, False), (128, False)])
    def test_other_colours_may_cover_a_part(self, coloured_rows, remains_grey):
        splashed = self.photo()
        splashed[:coloured_rows, :, 1] *= 0.5
        assert is_mostly_grey(splashed) == remains_grey

    def test_a_pale_colour_all_over_is_one(self):
        assert not is_mostly_grey(self.photo() + (0.01, 0, 0))

    def test_black_and_white_have_no_say(self):
        plain = self.photo()
        plain[:60], plain[60:90] = 0, 1
        assert is_mostly_grey(plain)
        plain[90:, :, 1] *= 0.5
        assert not is_mostly_grey(plain)

    @pytest.mark.parametrize("code", [0.0, 0.05, 1.0])
    def test_black_or_white_alone_is_not_grey(self, code):
        assert not is_mostly_grey(np.full((64, 64, 3), code))


def test_what_a_cut_out_hides_has_no_say_in_its_tone():
    codes, alpha = coloured(wall(), SEPIA), np.ones((800, 600), np.float32)
    codes[:400], alpha[:400] = coloured(wall())[:400], 0
    linear = Photo.from_srgb(codes).linear
    cut_out, shown = Photo(linear, alpha), Photo(linear[400:].copy())
    some = np.array([0.05, 0.6])
    np.testing.assert_allclose(cut_out.tone_at(1.0).at(some), shown.tone_at(1.0).at(some), atol=0.02)


@pytest.mark.parametrize(("side_px", "is_stray"), [(12, True), (28, False)])
def test_a_coloured_spot_is_colour_unless_it_is_a_stray_mark(side_px, is_stray):
    codes = coloured(wall())
    codes[200 : 200 + side_px, 290 : 290 + side_px] = SKIN
    assert Photo.from_srgb(codes).monochrome == is_stray


@pytest.mark.parametrize(("side_px", "is_stray"), [(60, True), (120, False)])
def test_a_faint_colour_is_one_where_it_is_more_than_a_stray_mark(side_px, is_stray):
    # Nowhere is it plainly a colour, and most of the picture has none of it.
    codes = coloured(wall())
    codes[300 : 300 + side_px, 200 : 200 + side_px] += np.array([8, 0, 248], np.uint8)
    assert Photo.from_srgb(codes).monochrome == is_stray


def test_faint_colours_of_a_small_cut_out_are_colours():
    codes, alpha = np.full((800, 600, 3), 128, np.uint8), np.zeros((800, 600), np.float32)
    codes[300:380, 300:330], codes[300:380, 330:360] = (133, 123, 126), (123, 133, 126)
    alpha[300:380, 300:360] = 1
    assert not Photo(Photo.from_srgb(codes).linear, alpha).monochrome


def test_an_exposed_photo_has_its_tone_at_exposed_brightnesses():
    grey = np.linspace(0, 1, 64 * 64, dtype=np.float32).reshape(64, 64, 1)
    photo = Photo(grey * (1 + np.float32([0.2, 0, -0.4]) * 4 * grey * (1 - grey)))
    some = np.float32([0.1, 0.4, 0.9])
    np.testing.assert_allclose(photo.tone_at(4.0).at(4 * some), photo.tone_at(1.0).at(some), atol=2e-3)
    assert np.ptp(photo.tone_at(1.0).at(some)[:, 2]) > 0.1
