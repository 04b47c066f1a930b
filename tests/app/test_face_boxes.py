"""Boxes of faces under the mouse, without a window."""

import numpy as np
import pytest

from app.ui.viewport.face_boxes import corners, dragged, grab
from relight_core.face.crop import Crop
from relight_core.face.find import FaceBox

SIZE = (600, 800)
LEFT, RIGHT = FaceBox(100, 100, 200, 200), FaceBox(500, 200, 600, 320)
INSIDE = FaceBox(130, 130, 160, 160)
LEANING = FaceBox(300, 300, 400, 400, roll_deg=30.0)
REACH = 6.0


def after(boxes, start, end, selected=-1, least_px=8.0):
    held = grab(boxes, selected, start, REACH)
    return dragged(boxes, held, end, SIZE, least_px)


@pytest.mark.parametrize(
    ("at", "kind", "side"),
    [
        ((150, 150), "move", (0, 0)),
        ((108, 150), "move", (0, 0)),
        ((104, 150), "resize", (-1, 0)),
        ((96, 150), "resize", (-1, 0)),
        ((150, 203), "resize", (0, 1)),
        ((203, 197), "resize", (1, 1)),
        ((98, 203), "resize", (-1, 1)),
        ((92, 150), "draw", (0, 0)),
        ((150, 208), "draw", (0, 0)),
    ],
)
def test_what_a_press_takes_hold_of(at, kind, side):
    held = grab((LEFT, RIGHT), -1, at, REACH)
    assert (held.kind, held.side) == (kind, side)
    assert held.index == (2 if kind == "draw" else 0)


def test_the_selected_box_comes_first_then_the_smallest():
    boxes = (INSIDE, LEFT)
    assert grab(boxes, -1, (145, 145), REACH).index == 0
    assert grab(boxes, 1, (145, 145), REACH).index == 1
    assert grab((LEFT, INSIDE), -1, (145, 145), REACH).index == 1


def test_a_box_smaller_than_the_reach_can_be_moved_and_resized():
    tiny = (FaceBox(10, 10, 18, 18),)
    assert grab(tiny, -1, (14, 14), 40.0).kind == "move"
    assert grab(tiny, -1, (18.5, 18.5), 40.0).side == (1, 1)


def test_a_drag_inside_moves_a_box_by_as_much_and_no_other():
    assert after((LEFT, RIGHT), (150, 170), (160, 150)) == (FaceBox(110, 80, 210, 180), RIGHT)


def test_a_corner_follows_the_mouse_and_the_one_opposite_stays():
    assert after((LEFT,), (202, 201), (252, 251)) == (FaceBox(100, 100, 250, 250),)
    assert after((LEFT,), (100, 100), (120, 80)) == (FaceBox(80, 80, 200, 200),), "as large as the hand reaches"


def test_an_edge_keeps_the_proportions_and_the_middle_of_the_one_opposite():
    assert after((LEFT,), (200, 150), (220, 190)) == (FaceBox(100, 90, 220, 210),)
    (box,) = after((RIGHT,), (550, 320), (550, 260))
    assert (box.y0, box.y1) == (200, 260)
    assert (box.x0, box.x1) == (525, 575)


def test_no_box_is_turned_inside_out():
    (box,) = after((LEFT,), (200, 200), (20, 20))
    assert (box.x0, box.y0, box.width, box.height) == (100, 100, 8, 8)
    (box,) = after((RIGHT,), (600, 320), (20, 20))
    assert (box.width, box.height) == pytest.approx((8, 9.6))


def test_a_box_grows_to_twice_the_photo_so_that_a_face_may_reach_beyond_it():
    (box,) = after((LEFT,), (200, 200), (5000, 5000))
    assert (box.width, box.height) == (1600, 1600)


@pytest.mark.parametrize("end", [(340, 260), (260, 340), (260, 180)])
def test_a_new_box_is_square_whichever_way_it_is_drawn(end):
    boxes = after((LEFT,), (300, 240), end)
    assert boxes[0] == LEFT
    box = boxes[1]
    assert box.width == box.height == max(abs(end[0] - 300), abs(end[1] - 240))
    for x, y in ((300, 240), end):
        assert box.x0 <= x <= box.x1
        assert box.y0 <= y <= box.y1
    assert box.roll_deg == 0


def test_a_click_draws_nothing():
    assert after((LEFT,), (300, 240), (303, 243)) == (LEFT,)


@pytest.mark.parametrize("end", [(-5000, 150), (5000, 5000), (150, -900)])
def test_a_quarter_of_a_box_stays_on_the_photo(end):
    for start in ((150, 150), (200, 200)):
        (box,) = after((LEFT,), start, end)
        assert min(box.x1, 800) - max(box.x0, 0) >= 0.25 * box.width - 1e-6
        assert min(box.y1, 600) - max(box.y0, 0) >= 0.25 * box.height - 1e-6


def test_three_quarters_of_a_box_can_lie_beside_the_photo():
    assert after((LEFT,), (150, 150), (-5000, 150)) == (FaceBox(-75, 100, 25, 200),)


def test_a_new_box_may_begin_beside_the_photo_where_that_cuts_a_face():
    assert after((), (-60, 100), (60, 220)) == (FaceBox(-60, 100, 60, 220),)
    assert after((), (-60, 100), (-20, 140)) == (), "nothing of it is on the photo"
    assert after((), (5, 5), (-90, -90)) == ()


def test_a_leaning_box_is_grabbed_where_the_networks_see_its_edges():
    view = Crop(350, 350, 100, 30.0)
    expected = view.to_photo(np.array([[0, 0], [100, 0], [100, 100], [0, 100]]), 100)
    np.testing.assert_allclose(corners(LEANING), expected, atol=1e-9)
    assert grab((LEANING,), -1, tuple(expected[2]), REACH).side == (1, 1)
    assert grab((LEANING,), -1, (302, 302), REACH).kind == "draw", "an upright box would have a corner here"


def test_a_leaning_box_keeps_its_lean_and_the_corner_opposite():
    start = corners(LEANING)[2]
    end = start[0] + 40.0, start[1] + 10.0
    (larger,) = after((LEANING,), start, end)
    assert larger.roll_deg == 30.0
    assert larger.width == larger.height > 120
    np.testing.assert_allclose(corners(larger)[0], corners(LEANING)[0], atol=1e-9)
    (moved,) = after((LEANING,), (350, 350), (360, 340))
    assert moved == FaceBox(310, 290, 410, 390, roll_deg=30.0)
