"""A photo whose blacks are lifted: no light lights what lies over all of it, and it lies over the new picture too."""

from dataclasses import replace

import numpy as np
import pytest
from tiny_relighter import EDIT, some_light, some_photo

from relight_core.imaging import photo
from relight_core.imaging.photo import Photo
from relight_core.pipeline.face_taken_apart import Workshop
from relight_core.pipeline.relighter import Relighter
from relight_core.pipeline.results.layers import photo_layers

BLACK = np.float32([0.02, 0.03, 0.05])
DARKER = (3, 100)
"""A pixel of the photo that is darker than what lies over all of it."""


def lifted_photo():
    linear = BLACK + (1 - BLACK) * some_photo().linear
    linear[DARKER] = 0.001
    return Photo(np.ascontiguousarray(linear, np.float32))


@pytest.fixture
def lifted(weights, small_and_seeing_faces, person_on_the_left, monkeypatch):
    monkeypatch.setattr(photo, "light_over", lambda *seen: BLACK)
    relighter = Relighter(weights)
    relighter.set_portrait(lifted_photo())
    return relighter


def test_networks_see_the_photo_without_it_and_the_user_with_it(lifted, monkeypatch):
    seen, delight = [], Workshop.delight
    monkeypatch.setattr(Workshop, "delight", lambda shop, *args: seen.append(args[0]) or delight(shop, *args))
    relit = lifted.relight(some_light(), EDIT)
    assert len(seen) > 0
    assert all(view[..., 2].min() < 0.8 * (0.05 + BLACK[2]) for view in seen)
    assert relit.channels["photo"][..., 2].min() > 0.9 * (0.05 + BLACK[2])


def test_a_kept_background_stays_as_it_is_also_where_it_is_darker(lifted):
    behind = lifted.relight(some_light(), replace(EDIT, background="transparent")).alpha == 0
    kept = lifted.relight(some_light(), EDIT).image
    assert behind[DARKER]
    np.testing.assert_allclose(kept[behind], lifted_photo().linear[behind], atol=2e-7)


def test_in_darkness_a_person_is_as_black_as_the_photo_can_be(lifted):
    alpha = lifted.relight(some_light(), replace(EDIT, background="transparent")).alpha
    dark = lifted.relight(some_light(level=0.0), EDIT)
    np.testing.assert_allclose(dark.image[alpha == 1], np.broadcast_to(BLACK, dark.image.shape)[alpha == 1], atol=1e-6)
    composition = dark.channels["composition"][:, :20]
    np.testing.assert_allclose(composition, np.broadcast_to(BLACK, composition.shape), atol=1e-6)


def test_a_new_background_has_it_too_and_a_colour_is_the_one_that_was_chosen(lifted):
    behind = lifted.relight(some_light(), replace(EDIT, background="transparent")).alpha == 0
    unlit = lifted.relight(some_light(level=0.0), replace(EDIT, background="light"))
    np.testing.assert_allclose(unlit.image[behind], np.broadcast_to(BLACK, unlit.image.shape)[behind], atol=1e-6)
    for colour, linear in (("#808080", 0.2159), ("#000000", 0.0)):
        chosen = lifted.relight(some_light(), replace(EDIT, background=colour)).image
        np.testing.assert_allclose(chosen[behind], linear, atol=1e-3)


def test_a_screens_copy_and_a_part_show_what_the_whole_does(lifted):
    relit = lifted.relight(some_light(), EDIT)
    small = lifted.relight(some_light(), EDIT, longest_side_px=56).image
    of_whole = relit.image.reshape(48, 2, 56, 2, 3).mean((1, 3))
    behind = lifted.relight(some_light(), replace(EDIT, background="transparent")).alpha == 0
    behind = behind.reshape(48, 2, 56, 2).all((1, 3))
    np.testing.assert_allclose(small[behind], of_whole[behind], atol=1e-5)
    assert np.abs(small - of_whole).mean() < 0.02 * of_whole.mean()
    np.testing.assert_allclose(relit.full.part((10, 20, 60, 70))[0], relit.image[20:70, 10:60], atol=1e-6)


def test_the_picture_less_its_background_is_the_person_times_the_matte(lifted):
    relit = lifted.relight(some_light(), EDIT)
    layers = photo_layers(relit, ["background", "matte"])
    person = layers["RGB"] - layers["background"]
    solid, nobody = layers["matte"] == 1, layers["matte"] == 0
    assert nobody[DARKER]
    np.testing.assert_allclose(layers["background"][solid], 0, atol=1e-6)
    np.testing.assert_allclose(person[nobody], 0, atol=1e-6)
