"""Which of what cascades hit are faces, companions or guesses, and in which order."""

import numpy as np
import pytest

from relight_core.face import find
from relight_core.face.cascades import Candidate
from relight_core.face.find import FaceBox, find_faces, guess_companions, guess_faces
from relight_core.imaging.photo import Photo


def hit(x, y, width, votes, roll_deg=0.0):
    return Candidate(np.array([x, y, x + width, y + width], float), votes, 3, roll_deg)


def even_photo(height, width):
    return Photo(np.full((height, width, 3), 0.2, np.float32))


def places(boxes):
    return [(box.x0, box.y0, box.width) for box in boxes]


def test_what_lies_in_a_better_face_or_is_tiny_and_doubtful_beside_it_is_none(monkeypatch):
    face, mouth, beside = hit(300, 300, 190, 45), hit(420, 380, 100, 30), hit(440, 300, 120, 20)
    tiny, sure, other = hit(20, 20, 60, 39), hit(600, 20, 60, 4000), hit(600, 600, 100, 10)
    monkeypatch.setattr(find, "frontal_candidates", lambda *_: [tiny, other, mouth, sure, face, beside])
    found = find_faces(even_photo(800, 800))
    assert places(found) == [(300, 300, 190), (440, 300, 120), (600, 20, 60), (600, 600, 100)]
    assert all(box.doubtful for box in found)


def test_who_is_in_the_dark_quarter_of_a_photo_is_looked_for_last_of_those_upright(monkeypatch):
    looks = []
    monkeypatch.setattr(find, "frontal_candidates", lambda grey, *_: looks.append(grey.mean()) or [])
    monkeypatch.setattr(find, "_turned_away", lambda grey: [])
    linear = np.full((400, 400, 3), 0.9, np.float32)
    linear[:240], linear[:120] = 0.03, 0.001
    assert find_faces(Photo(linear)) == []
    _, as_it_is, *lying, brighter, brightest = looks
    assert lying == [as_it_is] * 3
    assert as_it_is < brighter < brightest


def test_who_leans_is_looked_for_only_where_nobody_is_seen_from_the_side(monkeypatch):
    turned = []
    monkeypatch.setattr(find, "frontal_candidates", lambda *_: [])
    monkeypatch.setattr(find, "_when_turned", lambda look, grey, tilts: turned.append(tilts) or [hit(9, 9, 80, 9, 30)])
    monkeypatch.setattr(find, "profile_candidates", lambda grey: [hit(100, 100, 80, 20)])
    assert places(find_faces(even_photo(800, 800))) == [(100, 100, 80)]
    assert turned == []
    monkeypatch.setattr(find, "profile_candidates", lambda grey: [])
    (found,) = find_faces(even_photo(800, 800))
    assert (places([found]), found.roll_deg, turned) == ([(9, 9, 80)], 30, [(-30.0, 30.0)])


def test_a_place_is_guessed_once_at_each_angle_and_three_from_the_side_come_first(monkeypatch):
    sides = [hit(60 * i, 300, 30, i + 1) for i in range(5)]
    hits = [hit(100, 100, 60, 30, 30), hit(108, 100, 60, 40), hit(100, 100, 60, 50), hit(250, 100, 60, 45, 60)]
    monkeypatch.setattr(find, "every_profile_hit", lambda grey: sides)
    monkeypatch.setattr(find, "_when_turned", lambda *_: hits)
    *guesses, filling = guess_faces(even_photo(400, 400))
    from_the_side = [(240, 300, 30), (180, 300, 30), (120, 300, 30)]
    assert places(guesses) == [*from_the_side, (100, 100, 60), (250, 100, 60), (100, 100, 60)]
    assert [guess.roll_deg for guess in guesses] == [0, 0, 0, 0, 60, 30]
    assert places([filling]) == [(pytest.approx(20), pytest.approx(20), pytest.approx(360))]


class TestCompanions:
    @pytest.fixture
    def companions(self, monkeypatch):
        """Guesses in a photo of 500 x 400 beside known faces from hits; and the tilts at which was looked."""

        def guesses(known, hits, tilts=None):
            looked = [] if tilts is None else tilts
            found = iter([hits])
            monkeypatch.setattr(find, "_when_turned", lambda _, grey, at: looked.append(*at) or next(found, []))
            return places(guess_companions(even_photo(500, 400), known))

        return guesses

    def test_are_beside_each_other_and_those_known(self, companions):
        hits = [hit(60, 55, 40, 20), hit(50, 50, 40, 30), hit(77, 50, 40, 25), hit(50, 77, 40, 24)]
        hits += [hit(220, 215, 40, 90), hit(227, 200, 40, 10)]
        known = [FaceBox(200, 200, 240, 240)]
        assert companions(known, hits) == [(50, 50, 40), (77, 50, 40), (50, 77, 40), (227, 200, 40)]

    def test_are_about_as_large_as_the_largest_of_those_known(self, companions):
        hits = [hit(350, 400, 19, 9), hit(300, 400, 21, 8), hit(20, 300, 65, 7), hit(120, 400, 63, 6)]
        known = [FaceBox(10, 10, 25, 25), FaceBox(200, 200, 240, 240)]
        assert companions(known, hits) == [(300, 400, 21), (120, 400, 63)]

    def test_are_sixteen_at_the_most(self, companions):
        hits = [hit(20 * i, 400, 20, 50 - i) for i in range(19)]
        assert companions([FaceBox(10, 10, 30, 30)], hits) == [(20 * i, 400, 20) for i in range(16)]

    @pytest.mark.parametrize(
        ("width", "roll_deg", "count", "has_room"),
        [(64, 0, 1, True), (66, 0, 1, False), (66, 30, 1, False), (66, 90, 1, True), (124, -90, 1, True)]
        + [(126, 180, 1, False), (126, 0, 2, True)],
    )
    def test_have_room_beside_one_face_that_is_small_or_lies_and_beside_several(
        self, companions, width, roll_deg, count, has_room
    ):
        known = [FaceBox(10, 10, 10 + width, 10 + width, roll_deg)] * count
        assert companions(known, [hit(200, 300, width, 9)]) == ([(200, 300, width)] if has_room else [])

    @pytest.mark.parametrize(("roll_deg", "lies_deg"), [(20, 0), (60, 90), (-100, -90), (180, 180)])
    def test_lie_as_those_known_do(self, companions, roll_deg, lies_deg):
        tilts = []
        companions([FaceBox(10, 10, 50, 50, roll_deg)], [], tilts)
        assert tilts == [tilt_deg - lies_deg for tilt_deg in (0, 0, -30, 30)]
