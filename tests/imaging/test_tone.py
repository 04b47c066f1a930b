"""The colour that a toned picture has at each brightness."""

import numpy as np

from relight_core.imaging.colour import luminance
from relight_core.imaging.tone import tone_of


def sepia(brightness):
    """Sepia (..., 3) that leaves black and white as they are, of luminances (...) in [0, 1]."""
    depth = 4 * brightness * (1 - brightness)
    colour = np.stack([1 + 0.2 * depth, 1 - 0.04 * depth, 1 - 0.2 * depth], axis=-1)
    return (colour / luminance(colour)[..., None] * brightness[..., None]).astype(np.float32)


def test_it_is_the_tone_that_the_picture_has_there():
    brightness = np.random.default_rng(0).uniform(0, 1, 20000) ** 2
    tone = tone_of(sepia(brightness))
    asked = np.linspace(0.02, 1, 50)
    np.testing.assert_allclose(tone.at(asked) * asked[:, None], sepia(asked), atol=0.03)
    np.testing.assert_allclose(luminance(tone.at(asked)), 1, atol=1e-3)
    in_steps = np.diff(tone.at(np.linspace(0.02, 1, 5000)), axis=0)
    assert np.abs(in_steps).max() < 0.002


def test_white_that_is_dimmed_turns_sepia_and_what_stays_stays():
    tone = tone_of(sepia(np.linspace(0, 1, 5000)))
    dimmed = tone.turned(np.ones(1), np.full(1, 0.4))[0]
    np.testing.assert_allclose(dimmed, sepia(np.full(1, 0.4))[0] / 0.4, atol=0.03)
    some = np.linspace(0, 2, 40)
    np.testing.assert_array_equal(tone.turned(some, some), 1)


def test_an_exposed_picture_has_its_tone_at_exposed_brightnesses():
    tone, some = tone_of(sepia(np.linspace(0, 1, 5000))), np.linspace(0, 1, 40)
    np.testing.assert_allclose(tone.exposed(4.0).at(4 * some), tone.at(some), atol=2e-3)


def test_black_under_a_light_without_end_has_the_tone_of_black():
    tone = tone_of(sepia(np.linspace(0, 1, 5000)))
    with np.errstate(invalid="ignore"):
        endless = np.float32([0.0, 0.5, -1.0]) * np.float32(np.inf)
    assert np.isnan(endless[0])
    np.testing.assert_array_equal(tone.at(endless), tone.at(np.float32([0.0, 1.0, 0.0])))
    assert np.isfinite(tone.turned(np.float32([0.0, 0.5, 0.0]), endless)).all()


def test_black_and_white_has_none_nor_has_nothing():
    assert tone_of(np.repeat(np.linspace(0, 1, 500, dtype=np.float32)[:, None], 3, 1)) is None
    assert tone_of(np.zeros((20, 3), np.float32)) is None
    assert tone_of(np.zeros((0, 3), np.float32)) is None


def test_brightnesses_that_the_picture_lacks_lie_between_those_it_has():
    brightness = np.concatenate([np.full(500, 0.1), np.full(500, 0.9)])
    between = tone_of(sepia(brightness)).at(np.full(1, 0.5))[0]
    assert sepia(np.full(1, 0.1))[0, 0] / 0.1 + 1e-3 > between[0] > 1


def test_a_colour_that_the_shadows_lack_is_not_made_without_end():
    red, grey = np.float32([[1, 0, 0]]), np.float32([[1, 1, 1]])
    tone = tone_of(np.concatenate([0.1 * red.repeat(500, 0), 0.9 * grey.repeat(500, 0)]))
    brighter = tone.turned(np.full(1, 0.02), np.full(1, 0.9))
    assert np.isfinite(brighter).all()
    assert brighter.max() < 60


def test_a_faint_tone_is_one():
    brightness = np.linspace(0, 1, 5000, dtype=np.float32)
    tone = tone_of(brightness[:, None] * np.float32([1.02, 1.0, 0.97]))
    assert tone is not None
    red, green, blue = tone.at(np.full(1, 0.5))[0]
    assert red / green > 1.015
    assert blue / green < 0.98


def test_a_few_bright_pixels_tell_of_their_brightness_and_hardly_any_do_not():
    grey, red = np.full((20_000, 3), 0.2, np.float32), np.float32([[1.2, 0.8, 0.8]])
    told = tone_of(np.concatenate([grey, red.repeat(100, 0)])).at(np.full(1, 0.88))[0]
    np.testing.assert_allclose(told, red[0] / luminance(red[0]), rtol=0.02)
    assert tone_of(np.concatenate([grey, red])) is None
