"""The mouse on soft boxes, and lamps placed by a click on a face."""

import numpy as np
import pytest

from app.ui.viewport.box_tools import Grab, aimed, dragged, grab, lamp_for_spot, with_box, without_box
from app.ui.viewport.placing import _no_face_at
from relight_core.face.crop import Crop
from relight_core.face.find import FaceBox
from relight_core.lighting.light_edit import LightEdit
from relight_core.lighting.soft_box import SoftBox, corners
from relight_core.lighting.sphere import turned, uv_of

FRONT = SoftBox(0.0, 0.0, 40.0, 40.0)
LEFT = SoftBox(-90.0, 0.0, 30.0, 30.0)
POLE = SoftBox(20.0, 90.0, 30.0, 30.0)


def seen_at(box, yaw_deg):
    u, v = uv_of(box.direction)
    return u + yaw_deg / 360.0, v


@pytest.mark.parametrize("yaw_deg", [0.0, 35.0, -170.0, 179.0])
@pytest.mark.parametrize("index", [0, 1, 2])
def test_a_press_finds_the_box_however_the_light_is_turned(yaw_deg, index):
    boxes = (FRONT, LEFT, POLE)
    u, v = seen_at(boxes[index], yaw_deg)
    for turns in (0, 1, -1):
        assert grab(boxes, -1, u + turns, v, yaw_deg, 2.0).index == index
    assert grab(boxes, -1, u + 0.5, 0.8, yaw_deg, 2.0) == Grab("turn")


def test_a_box_at_the_seam_is_grabbed_on_both_sides_of_it():
    for u in (0.97, 0.03):
        assert grab((FRONT,), -1, u, 0.5, 0.0, 2.0).kind == "move"
    for u in (0.992, 0.008):
        assert grab((SoftBox(0.0, 0.0, 3.0, 3.0),), -1, u, 0.5, 0.0, 10.0).kind == "move", "a sun, from beside it"


def test_only_the_selected_box_has_corners():
    u, v = uv_of(corners(LEFT)[0])
    assert grab((LEFT,), 0, u, v, 0.0, 2.0).kind == "resize"
    assert grab((LEFT,), -1, u + 0.001, v - 0.02, 0.0, 2.0).kind == "turn"


def test_corners_reach_no_farther_on_the_panorama_where_the_sphere_is_narrow():
    high = SoftBox(-45.0, 60.0, 30.0, 30.0)
    u, v = uv_of(corners(high)[0])
    assert grab((high,), 0, u + 5.0 / 360.0, v, 0.0, 6.0).kind == "resize"
    assert grab((high,), 0, u + 9.0 / 360.0, v, 0.0, 6.0).kind != "resize"


def test_a_box_smaller_than_its_corners_reach_can_still_be_moved():
    small = SoftBox(-90.0, 0.0, 4.0, 4.0)
    u, v = uv_of(small.direction)
    assert grab((small,), 0, u + 0.5 / 360.0, v, 0.0, 10.0).kind == "move"
    assert grab((small,), -1, u + 3.0 / 360.0, v - 3.0 / 180.0, 0.0, 10.0).kind == "move", "beside it, but near"
    assert grab((small,), 0, u + 5.0 / 360.0, v - 5.0 / 180.0, 0.0, 10.0).kind == "resize"
    assert grab((small,), -1, u + 5.0 / 360.0, v - 5.0 / 180.0, 0.0, 10.0).kind == "turn"


@pytest.mark.parametrize("form", ["rectangle", "disc"])
def test_a_corner_that_is_taken_from_beside_it_does_not_jump(form):
    small = SoftBox(-90.0, 0.0, 6.0, 6.0, form=form)
    u, v = uv_of(small.direction)
    u, v = u + 5.0 / 360.0, v - 5.0 / 180.0
    held = grab((small,), 0, u, v, 0.0, 9.0)
    assert held.kind == "resize"
    still = dragged(held, u, v, 0.0)
    assert (still.width_deg, still.height_deg) == pytest.approx((6.0, 6.0), abs=1e-3)
    larger = dragged(held, u + 8.0 / 360.0, v - 8.0 / 180.0, 0.0)
    assert larger.width_deg > 15.0


def test_a_small_lamp_before_a_large_one_can_be_taken():
    sun, window = SoftBox(-90.0, 0.0, 3.0, 3.0), SoftBox(-90.0, 0.0, 80.0, 80.0)
    u, v = uv_of(sun.direction)
    assert grab((sun, window), -1, u, v + 0.01, 0.0, 10.0).index == 1, "of two middles the newest"
    u, v = uv_of(SoftBox(-70.0, 10.0).direction)
    assert grab((SoftBox(-70.0, 10.0, 3.0, 3.0), window), -1, u, v, 0.0, 10.0).index == 0


def test_of_boxes_that_overlap_the_selected_one_is_taken():
    boxes = (FRONT, FRONT)
    assert grab(boxes, -1, 0.0, 0.5, 0.0, 2.0).index == 1
    assert grab(boxes, 0, 0.0, 0.5, 0.0, 2.0).index == 0


@pytest.mark.parametrize("yaw_deg", [0.0, 120.0])
def test_a_box_follows_the_mouse_without_jumping_across_the_seam(yaw_deg):
    u, v = 0.95 + yaw_deg / 360.0, 0.55
    held = grab((FRONT,), -1, u, v, yaw_deg, 2.0)
    still = dragged(held, u, v, yaw_deg)
    assert np.allclose(still.direction, FRONT.direction, atol=1e-6)
    moved = dragged(held, u + 0.25, v - 0.1, yaw_deg)
    assert moved.azimuth_deg == pytest.approx(-90.0)
    assert moved.elevation_deg == pytest.approx(18.0)
    above = dragged(held, u, v - 3.0, yaw_deg)
    assert above.elevation_deg == pytest.approx(90.0)


def test_dragging_a_corner_resizes_about_the_middle():
    u, v = uv_of(corners(LEFT)[0])
    held = grab((LEFT,), 0, u, v, 0.0, 2.0)
    u, v = uv_of(corners(SoftBox(-90.0, 0.0, 60.0, 20.0))[0])
    resized = dragged(held, u, v, 0.0)
    assert (resized.width_deg, resized.height_deg) == pytest.approx((60.0, 20.0))
    assert (resized.azimuth_deg, resized.elevation_deg) == (-90.0, 0.0)


def test_a_box_in_the_hand_is_not_taken_for_one_that_has_come_into_its_place():
    held = Grab("move", 1, box=LEFT)
    assert held.is_among((FRONT, LEFT))
    assert not held.is_among((LEFT, POLE))
    assert not held.is_among((LEFT,))
    assert Grab("turn").is_among(())


def test_boxes_are_replaced_and_removed_by_index():
    assert with_box((FRONT, LEFT), 0, POLE) == (POLE, LEFT)
    assert without_box((FRONT, LEFT, POLE), 1) == (FRONT, POLE)


def test_a_lamp_is_aimed_in_camera_space_whatever_the_lights_turn():
    toward = np.array([0.6, 0.0, 0.8])
    edit, index = aimed(LightEdit(), -1, toward, 70.0)
    assert index == 0
    assert np.allclose(turned(edit.boxes[0].direction, 70.0), toward, atol=1e-6)
    again, index = aimed(edit, 0, np.array([0.0, 1.0, 0.0]), 70.0)
    assert (len(again.boxes), index) == (1, 0)
    assert again.boxes[0].elevation_deg == pytest.approx(90.0)
    full = LightEdit(boxes=(FRONT,) * 16)
    assert aimed(full, -1, toward, 0.0) == (full, -1)


def face():
    normal = np.zeros((50, 50, 3), np.float32)
    normal[..., 2] = 1.0
    normal[:, 25:] = [np.sin(0.5), 0.0, np.cos(0.5)]
    labels = np.ones((50, 50), np.int32)
    labels[:5] = 0
    return {"normal": normal, "parsing": labels}


def test_a_click_on_the_face_reads_the_normal_there():
    view = Crop(150.0, 250.0, 100.0)
    bright = lamp_for_spot(face(), view, 190.0, 250.0, "bright")
    assert np.allclose(bright, [np.sin(0.5), 0.0, np.cos(0.5)], atol=1e-6)
    shine = lamp_for_spot(face(), view, 190.0, 250.0, "highlight")
    assert np.allclose(shine, [np.sin(1.0), 0.0, np.cos(1.0)], atol=1e-6)
    assert np.allclose(lamp_for_spot(face(), view, 120.0, 250.0, "highlight"), [0, 0, 1])
    beside_the_ridge = lamp_for_spot(face(), view, 155.0, 250.0, "bright")
    assert np.allclose(beside_the_ridge, [np.sin(0.5), 0.0, np.cos(0.5)], atol=1e-6)


def test_a_tilted_heads_normals_are_turned_back_to_the_camera():
    up_in_the_head = {"normal": np.zeros((8, 8, 3), np.float32), "parsing": np.ones((8, 8), np.int32)}
    up_in_the_head["normal"][..., 1] = 1.0
    tilted = Crop(50.0, 50.0, 100.0, roll_deg=90.0)
    assert np.allclose(lamp_for_spot(up_in_the_head, tilted, 50, 50, "bright"), [-1.0, 0.0, 0.0], atol=1e-6)


@pytest.mark.parametrize("spot", [(150, 203), (99, 250), (201, 250), (150, 400)])
def test_a_click_beside_the_person_places_nothing(spot):
    assert lamp_for_spot(face(), Crop(150.0, 250.0, 100.0), *spot, "bright") is None
    assert lamp_for_spot({}, Crop(150.0, 250.0, 100.0), 150, 250, "bright") is None
    assert lamp_for_spot(face(), None, 150, 250, "bright") is None


@pytest.mark.parametrize(
    ("only", "x", "says"),
    [
        (None, 35, "alone first: 2,"),
        (None, 10, "no face there"),
        (None, 90, "no face there"),
        (0, 35, "alone first: 2,"),
        (1, 10, "alone first: 1,"),
        (1, 35, "no face there"),
    ],
)
def test_a_click_on_another_face_than_the_one_at_hand_tells_how_to_get_a_lamp_there(only, x, says):
    faces = FaceBox(0, 0, 20, 20), FaceBox(30, 0, 45, 15)
    assert says in _no_face_at(faces, only, x, 10)
