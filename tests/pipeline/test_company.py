"""People in one photo share its light, and keep how dark they are beside each other."""

from dataclasses import dataclass, field

import numpy as np
import pytest
import torch
from tiny_relighter import EDIT, some_photo

from relight_core.face.find import FaceBox
from relight_core.imaging.view_transform import apply_view
from relight_core.pipeline.company import Company
from relight_core.pipeline.quality import tier_of
from relight_core.pipeline.relighter import Relighter

TIER, PLAN = None, None
LEFT, RIGHT = FaceBox(6, 16, 50, 72), FaceBox(60, 20, 104, 76)


def lamp(column):
    light = np.full((16, 32, 3), 0.1, np.float32)
    light[6, column] = 50
    return light / np.float32(light.mean())


@dataclass
class Face:
    brightness: float = 1.0
    level: float = 1.0
    light: np.ndarray = field(default_factory=lambda: np.ones((16, 32, 3), np.float32))

    def estimate(self, tier):
        return self.light

    def exposure(self, tier):
        return self.brightness

    def model_level(self, tier, plan):
        return self.level


def test_the_light_is_every_faces():
    light = Company([Face(light=lamp(4)), Face(light=lamp(20))]).light(TIER)
    assert light[6, 4, 0] == pytest.approx(light[6, 20, 0], rel=1e-5)
    assert light[6, 4, 0] > 100 * light[6, 12, 0]
    light = Company([Face(light=lamp(4)), Face(light=lamp(20)), Face(light=lamp(4))]).light(TIER)
    assert light[6, 4, 0] == pytest.approx(2 * light[6, 20, 0], rel=0.01)


@pytest.mark.parametrize("ratio", [0.8, 1.0, 1.2])
def test_a_face_that_is_brighter_than_the_other_has_the_brighter_albedo(ratio):
    faces = Face(brightness=3.0 * ratio), Face(brightness=3.0)
    pale, dark = (Company(faces).albedo_gain(face, TIER) for face in faces)
    assert pale / dark == pytest.approx(ratio, rel=0.02)
    assert pale * dark == pytest.approx(1, rel=1e-6)


@pytest.mark.parametrize("exposure", [1e-30, 1e-3, 1e3, 1e30])
def test_what_only_light_explains_is_left_to_the_light(exposure):
    far, faces = Face(brightness=exposure), [Face(), Face()]
    gain = Company([far, *faces]).albedo_gain(far, TIER)
    assert 0.5 <= gain <= 2
    assert (gain - 1) * (exposure - 1) > 0


def test_the_level_is_between_theirs():
    assert Company([Face(level=1.0), Face(level=4.0)]).level(TIER, PLAN) == pytest.approx(2.0)
    assert Company([Face(level=1.0), Face(level=4.0), Face(level=16.0)]).level(TIER, PLAN) == pytest.approx(4.0)
    assert Company([Face(level=1.0), Face(level=1e-4)]).level(TIER, PLAN) == pytest.approx(0.01)


@pytest.mark.parametrize("nothing", [0.0, 1e-9])
def test_a_box_over_black_takes_no_part_in_the_level_of_the_others(nothing):
    faces = Face(brightness=3.0, level=2.0), Face(brightness=nothing, level=nothing)
    assert Company(faces).level(TIER, PLAN) == pytest.approx(2.0)
    assert Company(faces).albedo_gain(faces[0], TIER) == pytest.approx(1.0)
    assert Company([faces[1], faces[1]]).level(TIER, PLAN) < 1e-6


@pytest.mark.usefixtures("small_and_seeing_faces")
@pytest.mark.parametrize("face_boxes", [(LEFT, RIGHT), (RIGHT, LEFT)])
def test_under_their_own_light_all_of_them_are_the_photo(weights, face_boxes):
    photo = some_photo(3)
    photo.linear[:, 56:] *= 0.4
    relighter = Relighter(weights)
    relighter.set_portrait(photo, boxes=face_boxes)
    relit = relighter.relight(relighter.estimated_light("live"), EDIT)
    for box in face_boxes:
        part = np.s_[int(box.y0) + 8 : int(box.y1) - 8, int(box.x0) + 8 : int(box.x1) - 8]
        difference = np.abs(apply_view(relit.image[part]) - apply_view(photo.linear[part]))
        assert difference.mean() < 0.03


@pytest.mark.usefixtures("small_and_seeing_faces")
def test_a_box_that_is_drawn_twice_counts_once_in_the_light_they_share(weights):
    relighter, photo, lights = Relighter(weights), some_photo(3), []
    for face_boxes in ((LEFT, RIGHT), (LEFT, RIGHT, LEFT)):
        relighter.set_portrait(photo, boxes=face_boxes)
        own = relighter.estimated_light("live")
        lights.append(own.level * own.shape)
    np.testing.assert_allclose(*lights, rtol=1e-4)


@pytest.mark.usefixtures("small_and_seeing_faces")
def test_beside_others_a_face_s_albedo_is_scaled_in_its_nearer_view_too(weights, monkeypatch):
    relighter, tier, albedos = Relighter(weights), tier_of("live"), []
    relighter.set_portrait(some_photo(3), boxes=[FaceBox(40, 30, 62, 54), RIGHT])
    face = relighter._faces[0]
    for gain in (1.0, 0.5):
        monkeypatch.setattr(Company, "albedo_gain", lambda *asked, gain=gain: gain)
        relighter.forget("albedo")
        albedos.append([view.flattened(view.prepare(tier)).surface.albedo for view in (face, face.nearer)])
    for whole, half in zip(*albedos, strict=True):
        torch.testing.assert_close(half, 0.5 * whole)
