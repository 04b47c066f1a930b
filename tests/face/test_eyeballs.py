"""Eyes bulge, whatever the normals found there say."""

import numpy as np

from relight_core.face.eyeballs import eye_place, eye_sockets, with_eyeballs
from relight_core.face.parsing import INDEX

SIZE = 64
EYES = {"right_eye": (20, 30), "left_eye": (44, 30)}


def parsing_with_eyes(half_width=6):
    """Skin with two eyes in it."""
    y, x = np.mgrid[:SIZE, :SIZE]
    parsing = np.zeros((14, SIZE, SIZE), np.float32)
    for name, (middle_x, middle_y) in EYES.items():
        parsing[INDEX[name]] = np.hypot((x - middle_x) / half_width, 2 * (y - middle_y) / half_width) < 1
    parsing[INDEX["skin"]] = 1 - parsing.sum(0)
    return parsing


def hollow_normals():
    """Sockets that are bowls: every normal points to the middle of its eye."""
    y, x = np.mgrid[:SIZE, :SIZE].astype(np.float32)
    normal = np.zeros((3, SIZE, SIZE), np.float32)
    normal[2] = 1
    for middle_x, middle_y in EYES.values():
        near = np.hypot(x - middle_x, y - middle_y) < 9
        normal[0][near], normal[1][near] = ((middle_x - x) / 15)[near], ((y - middle_y) / 15)[near]
    return normal / np.linalg.norm(normal, axis=0)


def test_hollow_eyes_bulge_and_what_is_far_stays():
    before = hollow_normals()
    after = with_eyeballs(before, parsing_with_eyes())
    assert after.dtype == np.float32
    np.testing.assert_allclose(np.linalg.norm(after, axis=0), 1, atol=1e-5)
    for x, y in EYES.values():
        assert before[0, y, x + 4] < -0.2 < 0.2 < after[0, y, x + 4]
        assert before[0, y, x - 4] > 0.2 > -0.2 > after[0, y, x - 4]
        assert after[1, y - 2, x] > after[1, y + 2, x]
        assert after[2, y, x] > 0.95
    np.testing.assert_allclose(after[:, 50:], before[:, 50:], atol=1e-6)


def test_the_eyes_of_a_turned_head_look_where_it_looks():
    normal = np.zeros((3, SIZE, SIZE), np.float32)
    normal[0], normal[2] = 0.6, 0.8
    after = with_eyeballs(normal, parsing_with_eyes())
    for x, y in EYES.values():
        np.testing.assert_allclose(after[:, y, x], [0.6, 0, 0.8], atol=0.05)


def test_one_eye_is_enough_and_none_changes_nothing():
    normal, parsing = hollow_normals(), parsing_with_eyes()
    parsing[INDEX["left_eye"]] = 0
    after = with_eyeballs(normal, parsing)
    assert after[0, 30, 24] > 0.2
    np.testing.assert_allclose(after[:, :, 40:], normal[:, :, 40:], atol=1e-6)
    parsing[INDEX["right_eye"]] = 0
    parsing[INDEX["right_eye"], 30, 20] = 1
    assert with_eyeballs(normal, parsing) is normal


def test_sockets_lie_about_the_eyes():
    sockets = eye_sockets(parsing_with_eyes())
    assert sockets.dtype == np.float32
    assert sockets[30, 20] == sockets[30, 44] == 1
    assert 0.02 < sockets[35, 20] < 1
    assert sockets[50:].max() == 0
    assert eye_sockets(np.zeros((14, SIZE, SIZE), np.float32)).max() == 0


def facing(x):
    """Normals that all point so far to the right."""
    normal = np.zeros((3, SIZE, SIZE), np.float32)
    normal[0], normal[2] = x, np.sqrt(1 - x * x)
    return normal


def test_a_ball_is_a_little_wider_than_the_eye_that_shows_of_it():
    after = with_eyeballs(facing(0.0), parsing_with_eyes())
    for x, y in EYES.values():
        np.testing.assert_allclose(after[0, y, [x - 4, x - 2, x + 2, x + 4]], [-0.47, -0.23, 0.23, 0.47], atol=0.06)


def test_no_ball_turns_away_from_the_camera():
    after = with_eyeballs(facing(0.8), parsing_with_eyes())
    assert after[2, 28:33, 15:50].min() > 0.5


def test_eyes_that_face_each_other_look_half_as_far_aside():
    normal = facing(0.0)
    normal[:, :, :32], normal[:, :, 32:] = facing(0.5)[:, :, :32], facing(-0.5)[:, :, 32:]
    after = with_eyeballs(normal, parsing_with_eyes())
    assert 0.15 < after[0, 30, 20] < 0.4
    assert -0.4 < after[0, 30, 44] < -0.15


def test_lids_bulge_by_degrees():
    before, after = facing(0.0), with_eyeballs(facing(0.0), parsing_with_eyes())
    assert 0.03 < after[1, 26, 20] < after[1, 28, 20] + 0.2
    np.testing.assert_array_equal(after[:, :12], before[:, :12])


def test_eyes_of_ten_pixels_bulge_and_those_at_the_border_too():
    small = with_eyeballs(facing(0.0), parsing_with_eyes(2.5))
    assert small[0, 30, 21] > 0.2 > -0.2 > small[0, 30, 19]
    at_border = with_eyeballs(facing(0.0), np.roll(parsing_with_eyes(), (-28, -16), (1, 2)))
    assert at_border[0, 2, 7] > 0.2
    assert at_border[0, 2, 1] < -0.2


def test_a_speck_elsewhere_does_not_move_an_eye():
    share = parsing_with_eyes()[INDEX["left_eye"]]
    eye = eye_place(share)
    assert (eye.middle_x, eye.middle_y) == (44, 30)
    share[50:53, 4:7] = 1
    assert (eye_place(share).middle_x, eye_place(share).half_width) == (eye.middle_x, eye.half_width)
