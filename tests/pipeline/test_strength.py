"""The new light and the photo's own, mixed: light adds up."""

from dataclasses import replace

import numpy as np
import pytest
from drawn_eye import draw_eyes
from tiny_relighter import EDIT, computed, some_light, some_photo

from relight_core.face.irises import Iris
from relight_core.imaging.photo import Photo
from relight_core.lighting.environment import Environment
from relight_core.lighting.sphere import directions
from relight_core.pipeline import face_taken_apart
from relight_core.pipeline.plan import Scene, make_plan
from relight_core.pipeline.quality import TIERS
from relight_core.pipeline.relighter import Relighter

pytestmark = pytest.mark.usefixtures("small_and_seeing_faces")

SCENE = Scene(TIERS["final"], "light", 0.0, None, 1.0, irises=2)


@pytest.mark.parametrize("background", ["keep", "light", "#305070"])
def test_half_of_it_is_the_mean_of_the_whole_and_of_none(relighter, background):
    none, half, whole = (
        relighter.relight(some_light(), replace(EDIT, background=background, strength=strength)).image
        for strength in (0.0, 0.5, 1.0)
    )
    assert np.abs(whole - none).max() > 0.01
    np.testing.assert_allclose(half, (none + whole) / 2, atol=1e-6)


def test_none_of_it_is_the_photo(relighter):
    photo = some_photo()
    relighter.set_portrait(photo)
    none = replace(EDIT, strength=0.0)
    np.testing.assert_allclose(relighter.relight(some_light(), none).image, photo.linear, atol=1e-6)
    dimmed = relighter.relight(some_light(level=0.01), replace(none, background="match", shadow=2.0)).image
    np.testing.assert_allclose(dimmed, photo.linear, atol=1e-6)


def test_the_person_cut_out_is_as_photographed(relighter):
    photo = some_photo()
    relighter.set_portrait(photo)
    relit = relighter.relight(some_light(level=3.0), replace(EDIT, background="transparent", strength=0.0))
    inside = relit.alpha > 0.999
    assert inside.any()
    np.testing.assert_allclose(relit.image[inside], photo.linear[inside], atol=2e-3)


def test_what_eyes_mirror_is_mixed_too(monkeypatch, weights):
    irises = (Iris(40.0, 40.0, 6.0), Iris(62.0, 40.0, 6.0))
    monkeypatch.setattr(face_taken_apart, "find_irises", lambda *seen: irises)
    drawn = draw_eyes([(one.x, one.y, one.radius) for one in irises], (96, 112), specks=((42, 38, 1.2), (64, 38, 1.2)))
    relighter = Relighter(weights)
    relighter.set_portrait(Photo(drawn * np.float32([1.0, 0.8, 0.7])), face_index=0)
    lamp = 0.2 + 40.0 * (directions(64, 128) @ (0.3, 0.4, 0.866) > 0.97)
    light = Environment.from_radiance(np.repeat(lamp[..., None], 3, -1).astype(np.float32))

    def mirrored(strength):
        edit = replace(EDIT, strength=strength)
        without = replace(edit, forced_off=frozenset({"catchlights"}))
        return relighter.relight(light, edit).image - relighter.relight(light, without).image

    assert np.abs(mirrored(1.0)).max() > 0.01
    np.testing.assert_allclose(mirrored(0.25), mirrored(1.0) / 4, atol=1e-5)
    assert not mirrored(0.0).any()


def test_it_repeats_no_more_than_the_mixture_and_what_follows(relighter):
    relighter.relight(some_light(), EDIT)
    mixed = relighter.relight(some_light(), replace(EDIT, strength=0.5))
    assert computed(mixed) == {"strength", "paste"}
    assert computed(relighter.relight(some_light(), replace(EDIT, strength=0.5))) == set()


def test_channels_are_those_of_the_new_light_alone(relighter):
    whole, half = (relighter.relight(some_light(), replace(EDIT, strength=strength)) for strength in (1.0, 0.5))
    assert whole.channels.keys() == half.channels.keys()
    for name, channel in whole.channels.items():
        np.testing.assert_array_equal(half.channels[name], channel)


def test_a_shader_draws_the_same_mixture(relighter):
    edit = replace(EDIT, strength=0.5, channels=())
    recipe = relighter.relight(some_light(), edit, for_shader=True).recipe
    image = relighter.relight(some_light(), edit).image
    np.testing.assert_array_equal(recipe.picture.render()[0], image)
    np.testing.assert_array_equal(recipe.gain, np.concatenate([one.gain for one in recipe.picture.changes]))
    np.testing.assert_array_equal(recipe.rest, recipe.picture.rest)


def test_none_of_it_calls_for_nothing_that_answers_the_light_unless_that_is_looked_at():
    answers = ("flattening", "relief", "shadow", "specular", "correction", "residual", "catchlights")
    unseen = make_plan(SCENE, replace(EDIT, strength=0.0, channels=()))
    assert [name for name in answers if unseen.runs(name)] == []
    assert unseen.effect("shadow").bound == 0
    for channel in ("shadow", "specular", "composition"):
        assert make_plan(SCENE, replace(EDIT, strength=0.0, channels=(channel,))).runs("shadow")
    faint = make_plan(SCENE, replace(EDIT, strength=0.01, channels=()))
    assert [name for name in answers if not faint.runs(name)] == []
