"""Where the person network looks for a person, and how often."""

import numpy as np
import pytest
from tiny_networks import tiny_bundle_with_person

from relight_core.face.crop import Crop
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import BundleConfig, NetworkBundle
from relight_core.pipeline.cache import StageCache
from relight_core.pipeline.face_taken_apart import FaceTakenApart, Workshop
from relight_core.pipeline.per_photo.portrait import Portrait

FACE = FaceBox(110.0, 60.0, 150.0, 100.0)
CROP, VIEW = Crop(130.0, 80.0, 52.0, 20.0), Crop(130.0, 80.0, 88.0, 20.0)


def face_in(height, width, *, person=True):
    bundle = tiny_bundle_with_person() if person else NetworkBundle(BundleConfig.tiny())
    photo = Photo(np.random.default_rng(0).random((height, width, 3), np.float32))
    shop = Workshop(bundle.for_inference(), ReflectionTable(), "cpu")
    return FaceTakenApart(shop, Portrait(photo, FACE, FACE, CROP, VIEW), StageCache())


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
