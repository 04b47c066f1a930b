"""Pictures with eyes that mirror the light: what changes, where, and what makes it go away."""

from dataclasses import replace

import numpy as np
import pytest
from drawn_eye import draw_eyes
from tiny_relighter import EDIT, some_light, states

from relight_core.face.find import FaceBox
from relight_core.face.irises import Iris
from relight_core.imaging.photo import Photo
from relight_core.lighting.environment import Environment
from relight_core.lighting.sphere import directions
from relight_core.pipeline import face_relighter, face_taken_apart
from relight_core.pipeline.per_light.catchlights import Catchlight, LitEye
from relight_core.pipeline.relighter import Relighter

IRISES = (Iris(40.0, 40.0, 6.0), Iris(62.0, 40.0, 6.0))
SQUARES = (slice(32, 48), slice(32, 70))
WITHOUT = replace(EDIT, forced_off=frozenset({"catchlights"}))


@pytest.fixture
def portrait(monkeypatch, weights, small_and_seeing_faces):
    monkeypatch.setattr(face_taken_apart, "find_irises", lambda *seen: IRISES)

    def opened(tone=(1.0, 0.8, 0.7)):
        drawn = [(iris.x, iris.y, iris.radius) for iris in IRISES]
        photo = draw_eyes(drawn, (96, 112), specks=((42, 38, 1.2), (64, 38, 1.2))) * np.float32(tone)
        relighter = Relighter(weights)
        relighter.set_portrait(Photo(photo), face_index=0)
        return relighter

    return opened


def lamp_before():
    """A large lamp before the face, in an even room."""
    radiance = 0.2 + 40.0 * (directions(64, 128) @ (0.3, 0.4, 0.866) > 0.97)
    return Environment.from_radiance(np.repeat(radiance[..., None], 3, -1).astype(np.float32))


def change(relighter, edit=EDIT, light=None):
    """What the eyes mirror, as it changes the picture."""
    light = light or lamp_before()
    return relighter.relight(light, edit).image - relighter.relight(light, replace(edit, **off(edit))).image


def off(edit):
    return {"forced_off": edit.forced_off | {"catchlights"}}


def test_they_change_the_eyes_alone(portrait):
    changed = np.abs(change(portrait())).max(-1) > 1e-6
    assert changed[SQUARES].any()
    changed[SQUARES] = False
    assert not changed.any()


def test_the_lamp_comes_and_the_photos_own_goes(portrait):
    changed = change(portrait())
    assert changed.max() > 1e-3
    assert changed[38, 42].max() < 0


def test_a_darker_light_is_mirrored_darker(portrait):
    relighter, light = portrait(), lamp_before()
    bright = change(relighter, light=light)
    np.testing.assert_allclose(change(relighter, light=light.at_level(light.level / 8)) * 8, bright, atol=1e-4)


def test_it_follows_the_specular_slider(portrait):
    relighter = portrait()
    none, half, whole = (change(relighter, replace(EDIT, specular=gain)) for gain in (0.0, 0.5, 1.0))
    assert none.max() <= 1e-6
    assert half.max() < whole.max()


def test_in_a_black_and_white_photo_it_has_no_colour(portrait):
    radiance = lamp_before().shape * (1.0, 0.4, 0.1)
    changed = change(portrait((1.0, 1.0, 1.0)), light=Environment.from_radiance(radiance.astype(np.float32)))
    assert np.abs(changed).max() > 0.01
    assert np.ptp(changed, axis=-1).max() < 1e-5


def test_a_grey_face_s_eyes_have_none_beside_a_face_of_colours(weights, small_and_seeing_faces, monkeypatch):
    irises = Iris(46.0, 40.0, 6.0), Iris(194.0, 40.0, 6.0)
    photo = draw_eyes([(iris.x, iris.y, iris.radius) for iris in irises], (96, 240))
    photo *= np.random.default_rng(0).uniform(0.8, 1, (96, 240, 1)).astype(np.float32)
    photo[:48, :120] *= np.float32((1.0, 0.8, 0.7))
    photo[48:, :120] *= np.float32((0.7, 0.8, 1.0))
    monkeypatch.setattr(face_taken_apart, "find_irises", lambda *seen: (irises[seen[-1].centre_x > 120],))
    relighter = Relighter(weights)
    relighter.set_portrait(Photo(photo), boxes=[FaceBox(28, 16, 64, 72), FaceBox(176, 16, 212, 72)])
    radiance = lamp_before().shape * (1.0, 0.4, 0.1)
    relit = relighter.relight(Environment.from_radiance(radiance.astype(np.float32)), EDIT)
    own, printed = (np.ptp(eye.added, axis=-1).max() / np.abs(eye.added).max() for eye in relit.full.catchlights)
    assert own > 0.3
    assert printed < 1e-4


def test_someone_s_eyes_mirror_though_the_largest_face_has_its_own_shut(weights, small_and_seeing_faces, monkeypatch):
    iris = Iris(194.0, 40.0, 6.0)
    photo = draw_eyes([(iris.x, iris.y, iris.radius)], (96, 240)) * np.float32((1.0, 0.8, 0.7))
    monkeypatch.setattr(face_taken_apart, "find_irises", lambda *seen: (iris,) if seen[-1].centre_x > 120 else ())
    relighter = Relighter(weights)
    relighter.set_portrait(Photo(photo), boxes=[FaceBox(20, 10, 68, 80), FaceBox(176, 16, 212, 72)])
    changed = np.abs(change(relighter)).max(-1) > 1e-6
    assert changed[32:48, 186:202].any()
    assert not changed[:, :180].any()


def test_under_the_photos_own_light_its_own_stay(portrait):
    relighter = portrait()
    own = relighter.estimated_light("live")
    assert np.abs(change(relighter, light=own)).max() < 1e-4
    assert np.abs(change(relighter, replace(EDIT, yaw_deg=120.0), own)).max() > 1e-4
    unnamed = replace(EDIT, forced_off=frozenset({"source_light", "flattening", "residual"}))
    assert np.abs(change(relighter, unnamed, own)).max() < 1e-4


def test_what_is_hidden_from_an_eye_is_not_mirrored_unless_nothing_is_to_be_hidden(portrait, monkeypatch):
    hidden = LitEye(np.zeros((16, 32), np.float32), np.zeros(3, np.float32))
    monkeypatch.setattr(face_relighter, "light_about", lambda *of_light: hidden)
    relighter = portrait()
    assert change(relighter).max() <= 1e-6
    for effect in ("shadow", "relief"):
        assert change(relighter, replace(EDIT, forced_off=frozenset({effect}))).max() > 1e-3
    assert change(relighter).max() <= 1e-6, "whatever was asked for before"


@pytest.mark.parametrize("background", ["transparent", "#808080"])
def test_where_more_is_taken_away_than_there_is_an_eye_is_black(portrait, monkeypatch, background):
    monkeypatch.setattr(Catchlight, "change", lambda catchlight, gain: np.full_like(catchlight.mirrored, -9.0))
    image = portrait().relight(lamp_before(), replace(EDIT, background=background)).image
    assert image.min() >= 0


def test_under_a_black_light_nothing_is_mirrored(portrait):
    relit = portrait().relight(lamp_before().at_level(0.0), EDIT)
    assert relit.image[SQUARES].max() == 0
    assert states(relit)["catchlights"] == "skipped"


def test_a_turn_is_mirrored_anew_and_the_same_again_is_not(portrait):
    relighter = portrait()
    first = relighter.relight(some_light(), EDIT).image
    turned = relighter.relight(some_light(), replace(EDIT, yaw_deg=30.0))
    again = relighter.relight(some_light(), replace(EDIT, yaw_deg=30.0))
    assert np.abs(turned.image - first).max() > 1e-4
    assert states(again)["catchlights"] == "reused"
    np.testing.assert_array_equal(again.image, turned.image)
    np.testing.assert_array_equal(relighter.relight(some_light(), EDIT).image, first)


@pytest.mark.parametrize(
    "slider", [{"shadow": 0.5}, {"shadow_softness": 0.5}, {"specular": 0.5}, {"specular_tint": 0.5}]
)
def test_a_slider_mirrors_nothing_anew(portrait, slider):
    relighter = portrait()
    relighter.relight(lamp_before(), EDIT)
    moved = relighter.relight(lamp_before(), replace(EDIT, **slider))
    assert states(moved)["catchlights"] == "reused"
    np.testing.assert_array_equal(moved.image, portrait().relight(lamp_before(), replace(EDIT, **slider)).image)


def test_with_sliders_turned_off_eyes_mirror_as_if_none_was_moved(portrait):
    relighter, still = portrait(), replace(EDIT, forced_off=frozenset({"sliders"}))
    duller = relighter.relight(lamp_before(), replace(still, specular=0.0)).image
    np.testing.assert_array_equal(relighter.relight(lamp_before(), still).image, duller)
    np.testing.assert_array_equal(portrait().relight(lamp_before(), still).image, duller)


def test_a_recipe_has_them_too(portrait):
    recipe = portrait().relight(lamp_before(), EDIT, 1000, for_shader=True).recipe
    assert len(recipe.eyes) == 2
    assert recipe.catchlights.shape[0] == 2 * recipe.catchlights.shape[1]


def test_photos_without_irises_say_so(weights, small_and_seeing_faces, monkeypatch):
    monkeypatch.setattr(face_taken_apart, "find_irises", lambda *seen: ())
    relighter = Relighter(weights)
    relighter.set_portrait(Photo(draw_eyes((), (96, 112))), face_index=0)
    relit = relighter.relight(lamp_before(), EDIT, 1000, for_shader=True)
    assert states(relit)["catchlights"] == "skipped"
    assert relit.recipe.catchlights is None


def test_an_eye_that_cant_be_taken_apart_leaves_both_alone(portrait, monkeypatch):
    found = iter([None, object()])
    monkeypatch.setattr(face_taken_apart, "find_cornea", lambda *seen: next(found))
    assert states(portrait().relight(lamp_before(), EDIT))["catchlights"] == "skipped"
