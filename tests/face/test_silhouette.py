"""The solid person: holes filled, strangers left out, and nothing claimed where there is no face."""

import numpy as np

from relight_core.face.posterior import posterior
from relight_core.face.silhouette import person_with_headwear, rows_above_the_eyes, solid_person

BACKGROUND, SKIN, HAIR, HAT, CLASSES = 0, 1, 10, 11, 14


def parsing_of(labels: np.ndarray) -> np.ndarray:
    return np.eye(CLASSES, dtype=np.float32)[labels].transpose(2, 0, 1)


def head_with_hole() -> np.ndarray:
    labels = np.full((96, 96), BACKGROUND)
    labels[20:80, 30:70] = SKIN
    labels[44:50, 46:52] = BACKGROUND
    return labels


def test_a_hole_in_the_face_is_person():
    assert solid_person(parsing_of(head_with_hole()))[44:50, 46:52].min() > 0.9


def test_what_hangs_on_to_no_face_is_left_out():
    labels = head_with_hole()
    labels[5:40, 82:94] = HAIR
    assert solid_person(parsing_of(labels))[10:35, 84:92].max() == 0.0


def test_hair_that_touches_the_face_stays():
    labels = head_with_hole()
    labels[8:20, 30:70] = HAIR
    assert solid_person(parsing_of(labels))[9:19, 32:68].min() > 0.9


def test_without_a_face_the_parsing_stands():
    labels = np.full((64, 64), BACKGROUND)
    labels[10:30, 10:30] = HAIR
    person = solid_person(parsing_of(labels))
    assert person[12:28, 12:28].min() == 1.0
    assert person[40:, 40:].max() == 0.0


def test_unsure_parsing_stays_within_bounds():
    noise = np.random.default_rng(0).dirichlet(np.ones(CLASSES), (48, 48)).transpose(2, 0, 1).astype(np.float32)
    person = solid_person(noise)
    assert np.isfinite(person).all()
    assert person.min() >= 0
    assert person.max() <= 1


def faint_hat(share: float) -> np.ndarray:
    """A face with eyes, above it a quarter of the view that is hat by so much."""
    parsing = parsing_of(head_with_hole())
    parsing[:, 40:43, 36:44] = np.eye(CLASSES, dtype=np.float32)[4][:, None, None]
    parsing[HAT, :24] = share * parsing[BACKGROUND, :24]
    parsing[BACKGROUND, :24] -= parsing[HAT, :24]
    return parsing


def test_a_hat_that_is_faintly_seen_counts_for_more_above_the_eyes_only():
    parsing = faint_hat(0.45)
    plain, raised = 1 - posterior(parsing)[BACKGROUND], person_with_headwear(parsing)
    assert plain[10, 10] < 0.45
    assert 0.6 < raised[10, 10] < 0.85
    np.testing.assert_array_equal(raised[42:], plain[42:])
    assert raised.min() >= 0.0
    assert raised.max() <= 1.0


def test_next_to_no_hat_and_a_hat_without_eyes_change_nothing():
    for parsing in (faint_hat(0.02), faint_hat(0.05), parsing_of(np.full((32, 32), HAT))):
        np.testing.assert_array_equal(person_with_headwear(parsing), 1 - posterior(parsing)[BACKGROUND])


def test_what_is_said_half_heartedly_of_many_classes_is_background():
    parsing = parsing_of(head_with_hole())
    parsing[:, :10] = 0.0
    parsing[[BACKGROUND, HAIR, HAT, CLASSES - 1], :10] = np.array([0.48, 0.19, 0.01, 0.32])[:, None, None]
    assert person_with_headwear(parsing)[:10].max() < 0.45


def test_narrow_gaps_close_and_wide_ones_stay_open():
    labels = np.full((192, 192), BACKGROUND)
    labels[20:180, 20:180] = SKIN
    labels[20:100, 50:55] = BACKGROUND
    labels[20:100, 100:124] = BACKGROUND
    person = solid_person(parsing_of(labels))
    assert person[40:90, 51:54].min() > 0.9
    assert person[40:90, 106:118].max() == 0


def test_what_is_person_stays_as_sure_and_what_lies_beyond_its_edge_as_unsure():
    labels = head_with_hole()
    parsing = parsing_of(labels)
    parsing[:, 20:80, 30] = 0
    parsing[[BACKGROUND, SKIN], 20:80, 30] = np.array([[0.4], [0.6]])
    person = solid_person(parsing)
    assert (person[20:80, 30:70] > 0.59).all()
    assert (person[22:78, 34:66] == 1).all()
    outside = np.ones(labels.shape, bool)
    outside[20:80, 30:70] = False
    assert person[outside].max() == 0


def test_a_hint_of_person_far_from_the_body_is_left_out():
    parsing = parsing_of(head_with_hole())
    hint = 0.3 * parsing[BACKGROUND]
    parsing[HAIR] += hint
    parsing[BACKGROUND] -= hint
    person = solid_person(parsing)
    assert person[15].max() == 0
    assert person[18, 40] > 0.25


def test_what_lies_above_eyes_or_glasses_is_known_by_either_and_where_neither_is_seen_by_nothing():
    for label in (4, 5, 12):
        parsing = np.zeros((CLASSES, 100, 100), np.float32)
        parsing[label, 50, 40:60] = 1
        rows = rows_above_the_eyes(parsing)[:, 0]
        np.testing.assert_allclose(rows[[0, 44, 45, 48, 49, 50, 99]], [1, 1, 1, 0.4, 0.2, 0, 0], atol=1e-5)
    assert rows_above_the_eyes(np.zeros((CLASSES, 100, 100), np.float32)).max() == 0
