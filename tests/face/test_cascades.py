"""What hits of cascades count as a face: how many agree, whether eyes are seen, and where its box lies."""

import numpy as np
import pytest

from relight_core.face import cascades
from relight_core.face.cascades import every_hit, every_profile_hit, frontal_candidates, overlap, profile_candidates

FRONTAL = ("frontalface_default", "frontalface_alt", "frontalface_alt2")


class Cascade:
    """Hits a square of 100 pixels where the image has its brightest pixel, with so many votes; or several times."""

    def __init__(self, votes, eyes, moved=0):
        self.votes, self.eyes, self.moved = votes, eyes, moved

    def detectMultiScale2(self, grey, *_):
        row, column = np.unravel_index(grey.argmax(), grey.shape)
        votes = np.atleast_1d(self.votes)
        side = np.array([[column + self.moved, row, 100, 100]] * len(votes))
        return (side, votes) if votes.any() else ((), ())

    def detectMultiScale(self, view, *_):
        return np.zeros((self.eyes, 4))


@pytest.fixture
def seen(monkeypatch):
    """Lets cascades hit with so many votes each, and find so many eyes."""

    def let(votes, eyes=0, moved=None):
        known = {name: Cascade(count, eyes, (moved or {}).get(name, 0)) for name, count in votes.items()}
        monkeypatch.setattr(cascades, "_cascade", lambda name: known.get(name, Cascade(0, eyes)))

    return let


def bright_at(column, row=60, width=300):
    grey = np.zeros((240, width), np.uint8)
    grey[row, column] = 255
    return grey


@pytest.mark.parametrize(
    ("votes", "eyes_needed"),
    [
        ((5, 5, 5), 0),
        ((13, 1, 1), 0),
        ((5, 5, 4), 1),
        ((10, 30, 0), 1),
        ((4, 0, 4), 1),
        ((8, 0, 0), 2),
        ((90, 0, 0), 2),
        (((20, 30), 0, 0), 2),
    ],
)
def test_the_fewer_cascades_agree_the_more_eyes_a_face_has_to_show(seen, votes, eyes_needed):
    for eyes in (0, 1, 2):
        seen(dict(zip(FRONTAL, votes, strict=True)), eyes)
        assert len(frontal_candidates(bright_at(100))) == (eyes >= eyes_needed)


@pytest.mark.parametrize("votes", [(7, 0, 0), (3, 4, 0), (2, 2, 3)])
def test_too_few_votes_are_no_face_whatever_eyes_there_are(seen, votes):
    seen(dict(zip(FRONTAL, votes, strict=True)), eyes=2)
    assert frontal_candidates(bright_at(100)) == []
    assert len(every_hit(bright_at(100))) == 1


def test_two_of_the_frontal_cascades_guess(seen):
    seen({"frontalface_alt2": 30})
    assert every_hit(bright_at(100)) == []


def test_a_box_is_from_brow_to_chin_and_the_mean_of_its_votes(seen):
    seen({"frontalface_default": 30, "frontalface_alt": 10}, moved={"frontalface_alt": 20})
    (found,) = every_hit(bright_at(100))
    np.testing.assert_allclose(found.box, [109.5 + 5, 86, 190.5 + 5, 166.5])
    assert (found.votes, found.cascades) == (40, 2)


def test_hits_beside_each_other_are_two_faces_and_the_likelier_comes_first(seen):
    seen({"frontalface_default": 10, "frontalface_alt": 30}, moved={"frontalface_alt": 60})
    assert [(found.votes, found.cascades) for found in every_hit(bright_at(100))] == [(30, 1), (10, 1)]


@pytest.mark.parametrize(("votes", "eyes", "is_face"), [(15, 0, True), (14, 0, False), (8, 1, True), (7, 2, False)])
def test_a_profile_has_many_votes_or_shows_an_eye(seen, votes, eyes, is_face):
    seen({"profileface": votes}, eyes)
    assert len(profile_candidates(bright_at(100))) == (2 if is_face else 0)


def test_who_looks_to_the_right_is_found_as_in_a_mirror(seen):
    seen({"profileface": 9})
    to_the_left, to_the_right = every_profile_hit(bright_at(40, width=400))
    np.testing.assert_allclose(to_the_left.box, [40 - 5, 80, 40 + 76, 160])
    np.testing.assert_allclose(to_the_right.box, [41 - 76, 80, 41 + 5, 160])


def test_boxes_overlap_by_what_they_share_of_both():
    one = np.array([0.0, 0.0, 10.0, 10.0])
    assert overlap(one, one) == 1
    assert overlap(one, np.array([5.0, 0.0, 15.0, 10.0])) == pytest.approx(1 / 3)
    assert overlap(one, np.array([10.0, 0.0, 20.0, 10.0])) == overlap(one, np.array([0.0, 10.0, 10.0, 20.0])) == 0
    assert overlap(one, np.array([20.0, 20.0, 30.0, 30.0])) == 0
