"""Eyes bulge, whatever the normals found there say."""

import numpy as np

from relight_core.face.eyeballs import eye_sockets, with_eyeballs
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
