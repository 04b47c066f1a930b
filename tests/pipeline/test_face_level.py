"""The level at which a light leaves a face as bright as in its photo: stops, faces in half shadow, nasty views."""

import numpy as np
import pytest

from relight_core.pipeline.results.channels import ViewChange
from relight_core.pipeline.results.face_level import level_as_in_photo_ev

SIZE = 128


def photo_of_a_face():
    photo = np.random.default_rng(0).uniform(0.2, 0.4, (SIZE, SIZE, 3)).astype(np.float32)
    photo[:32] = 5.0
    return photo


def skin():
    likely = np.zeros((SIZE, SIZE), np.float32)
    likely[40:110, 30:100] = 0.9
    return likely


def change(gain, offset=0.0):
    full = np.ones((SIZE, SIZE, 3), np.float32)
    return ViewChange(gain * full, offset * full, 1.0)


@pytest.mark.parametrize("stops", [-3, -1, 0, 2])
@pytest.mark.parametrize("dimmed", [1.0, 0.01])
def test_what_a_light_adds_in_stops_is_taken_away(stops, dimmed):
    photo = photo_of_a_face() * np.float32(dimmed)
    assert level_as_in_photo_ev(photo, change(2.0**-stops), skin()) == pytest.approx(stops, abs=1e-4)


@pytest.mark.parametrize(
    ("gain", "level", "stops"), [(0.5, 2.0**14, 1.0), (0.5, 2.0**-14, 1.0), (0.5, 0.0, 1.0), (0.0, 0.0, 0.0)]
)
def test_of_a_light_of_any_level_counts_what_it_makes_of_the_face(gain, level, stops):
    full = np.ones((SIZE, SIZE, 3), np.float32)
    lit = ViewChange(gain * full, 0.0 * full, level)
    assert level_as_in_photo_ev(photo_of_a_face(), lit, skin()) == pytest.approx(stops, abs=1e-4)


@pytest.mark.parametrize("glint", [20.0, np.inf])
def test_a_glint_on_the_skin_hardly_counts(glint):
    glinting = change(1.0)
    glinting.gain[60:62, 60:62] = glint
    photo = np.full((SIZE, SIZE, 3), 0.3, np.float32)
    assert level_as_in_photo_ev(photo, glinting, skin()) == pytest.approx(0, abs=0.1)


def test_what_surrounds_the_face_does_not_count():
    surroundings = change(1.0)
    surroundings.gain[skin() < 0.5] = 100.0
    for likely in (skin(), np.maximum(skin(), 0.3)):
        assert level_as_in_photo_ev(photo_of_a_face(), surroundings, likely) == pytest.approx(0, abs=0.05)


def test_of_a_face_in_half_shadow_the_lit_half_counts():
    photo = np.full((SIZE, SIZE, 3), 0.3, np.float32)
    halved = change(2.0)
    halved.gain[:, :64] = 0.01
    assert level_as_in_photo_ev(photo, halved, skin()) == pytest.approx(-1, abs=0.1)


def test_what_a_light_adds_counts_too_and_black_skin_says_nothing():
    photo = np.full((SIZE, SIZE, 3), 0.3, np.float32)
    assert level_as_in_photo_ev(photo, change(1.0, offset=0.3), skin()) == pytest.approx(-1, abs=1e-4)
    assert level_as_in_photo_ev(0 * photo, change(1.0, offset=0.3), skin()) == 0.0


@pytest.mark.parametrize("gain", [0.0, np.inf, np.nan, 1e30, 1e-30])
def test_no_light_and_wild_ones_give_stops_that_a_slider_can_hold(gain):
    assert -4.0 <= level_as_in_photo_ev(photo_of_a_face(), change(gain), skin()) <= 4.0
    assert level_as_in_photo_ev(np.zeros((SIZE, SIZE, 3), np.float32), change(gain), skin()) == 0.0


def test_without_skin_nothing_is_metered():
    assert level_as_in_photo_ev(photo_of_a_face(), change(0.1), np.zeros((SIZE, SIZE), np.float32)) == 0.0


@pytest.mark.parametrize("stops", [-30, -10, 6.5, 20])
def test_a_light_in_units_of_its_own_is_brought_to_the_photo_s(stops):
    full = np.ones((SIZE, SIZE, 3), np.float32)
    lit = ViewChange(2.0**-stops * full, 0.0 * full, 2.0**-stops)
    assert level_as_in_photo_ev(photo_of_a_face(), lit, skin(), 40.0) == pytest.approx(stops, abs=1e-4)
    assert level_as_in_photo_ev(photo_of_a_face(), lit, skin()) == np.sign(stops) * 4.0


def test_a_face_in_units_of_its_own_is_no_black_one():
    photo = photo_of_a_face() * np.float32(1e-5)
    lit = ViewChange(np.full((SIZE, SIZE, 3), 1e5, np.float32), np.zeros((SIZE, SIZE, 3), np.float32), 1.0)
    assert level_as_in_photo_ev(photo, lit, skin(), 40.0, exposure=1e5) == pytest.approx(-np.log2(1e5), abs=1e-3)
