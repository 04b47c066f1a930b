"""Where the person network looks for a person, and how often."""

from dataclasses import replace

import numpy as np
import pytest
from tiny_networks import tiny_bundle_with_person

from relight_core.face.crop import Crop
from relight_core.face.find import FaceBox
from relight_core.face.person_view import person_view
from relight_core.imaging.photo import Photo
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import BundleConfig, NetworkBundle
from relight_core.pipeline.cache import StageCache
from relight_core.pipeline.face_taken_apart import FaceTakenApart, Workshop
from relight_core.pipeline.per_photo.outline import outline_person
from relight_core.pipeline.per_photo.portrait import Portrait

FACE = FaceBox(110.0, 60.0, 150.0, 100.0)


def face_in(height, width, *, person=True, roll_deg=20.0, mirrored=False):
    bundle = tiny_bundle_with_person() if person else NetworkBundle(BundleConfig.tiny())
    linear = np.random.default_rng(0).random((height, width, 3), np.float32)
    photo = Photo(np.ascontiguousarray(linear[:, ::-1]) if mirrored else linear)
    crop, view = (Crop(130.0, 80.0, side, roll_deg) for side in (52.0, 88.0))
    shop = Workshop(bundle.for_inference(), ReflectionTable(), "cpu")
    return FaceTakenApart(shop, Portrait(photo, FACE, FACE, crop, view), StageCache())


def test_an_upright_person_in_a_mirror_has_the_mirrored_outline():
    """One of the two looks is at the mirror image, which then is the other one of the mirrored photo."""
    there, back = (face_in(200, 260, roll_deg=0.0, mirrored=mirrored).outline() for mirrored in (False, True))
    assert there.view == back.view
    assert np.ptp(there.likely) > 0.01
    np.testing.assert_allclose(back.likely, there.likely[:, ::-1], atol=1e-4)


def test_a_leaning_person_is_seen_as_the_head_leans_and_as_the_photo_lies():
    face, bundle = face_in(200, 260), tiny_bundle_with_person().for_inference()
    photo, leaning, level = face.portrait.photo, face.portrait.crop, replace(face.portrait.crop, roll_deg=0.0)
    one = outline_person(bundle, photo, leaning, person_view(leaning, (200, 260)), "cpu")
    other = outline_person(bundle, photo, level, person_view(level, (200, 260)), "cpu", mirrors=(True,))
    there, known = other.seen_in(one.view, 256)
    both = face.outline().likely
    apart = known > 0.999
    assert 0.3 < apart.mean() < 1
    odds = [np.log(p[apart] / (1 - p[apart])) for p in (one.likely, there, both)]
    np.testing.assert_allclose(odds[2], (odds[0] + odds[1]) / 2, atol=0.01)
    np.testing.assert_allclose(both[known == 0], one.likely[known == 0], atol=1e-4)


def test_where_a_photo_shows_more_of_a_body_a_wider_look_follows_turned_as_the_photo_lies():
    (near, near_view), (wider, wider_view) = face_in(400, 300).looks()
    assert near_view.roll_deg == 20
    assert wider_view.roll_deg == 0
    assert wider_view.side == pytest.approx(4.8 * 52 * 196 / 256)
    assert near.shape == wider.shape == (256, 256)


@pytest.mark.parametrize(("photo", "person"), [((140, 140), True), ((400, 300), False)])
def test_else_there_is_one_look(photo, person):
    face = face_in(*photo, person=person)
    (likely, view), mask = *face.looks(), face.mask()
    np.testing.assert_array_equal(likely, mask[0])
    assert view == mask[1]


def test_a_wider_look_is_taken_once():
    face = face_in(400, 300)
    assert face.looks()[1][0] is face.looks()[1][0]
