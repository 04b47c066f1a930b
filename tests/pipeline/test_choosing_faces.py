"""Which of the boxes that cascades found, guesses and located faces are taken for faces."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from relight_core.errors import InputError
from relight_core.face.find import FaceBox, find_faces
from relight_core.imaging.photo import Photo
from relight_core.pipeline.per_photo import choosing_faces
from relight_core.pipeline.per_photo.choosing_faces import choose_faces, those_chosen

SURE, DOUBTFUL = FaceBox(0, 0, 9, 9), FaceBox(10, 0, 15, 5, doubtful=True)
GUESSES = [FaceBox(1, 1, 3, 3, 90.0, True), FaceBox(4, 4, 8, 8, 180.0, True)]


@pytest.fixture
def photo():
    return Photo(np.zeros((20, 20, 3), np.float32))


def chosen_by(photo, evidence, locate=lambda view: None, look_closer=lambda box: 0, glimpse=lambda box: 0):
    """The faces that are chosen with eyes that judge places so."""
    eyes = SimpleNamespace(evidence=evidence, locate=locate, look_closer=look_closer, glimpse=glimpse)
    return choose_faces(photo, eyes)


def seeing(monkeypatch, found, guesses=(), small=()):
    monkeypatch.setattr(choosing_faces, "find_faces", lambda photo, *judge: list(found))
    monkeypatch.setattr(choosing_faces, "guess_faces", lambda photo: list(guesses))
    monkeypatch.setattr(choosing_faces, "find_small_faces", lambda photo: list(small))


def test_a_doubtful_box_needs_two_parts_of_a_face(monkeypatch, photo):
    seeing(monkeypatch, [SURE, DOUBTFUL])
    assert chosen_by(photo, lambda box: 1) == [SURE]
    assert len(chosen_by(photo, lambda box: 2)) == 2


def test_a_box_beyond_doubt_is_not_judged(monkeypatch, photo):
    seeing(monkeypatch, [SURE])
    assert chosen_by(photo, lambda box: pytest.fail("judged")) == [SURE]


def test_the_best_guess_takes_the_place_of_what_is_no_face(monkeypatch, photo):
    seeing(monkeypatch, [DOUBTFUL], GUESSES)
    chosen = chosen_by(photo, lambda box: {90.0: 2, 180.0: 3}.get(box.roll_deg, 0))
    assert [face.roll_deg for face in chosen] == [180.0]
    assert find_faces(photo) == chosen


def test_what_lies_and_hides_a_part_is_a_face_only_if_that_part_is_suspected(monkeypatch, photo):
    lying, standing = FaceBox(1, 1, 3, 3, 90.0, True), FaceBox(4, 4, 8, 8, 0.0, True)
    for suspected, guesses, chosen in (
        (3, [lying], [90.0]),
        (2, [lying], []),
        (2, [standing], [0.0]),
        (2, [lying, standing], [0.0]),
        (3, [standing, lying], [90.0]),
    ):
        seeing(monkeypatch, [], guesses)
        glimpse = {90.0: suspected, 0.0: 2}
        try:
            faces = chosen_by(photo, lambda box: 2, glimpse=lambda box, seen=glimpse: seen[box.roll_deg])
        except InputError:
            faces = []
        assert [face.roll_deg for face in faces] == chosen, (suspected, guesses)


@pytest.mark.parametrize(("suspected", "roll_deg"), [(3, 0.0), (2, -30.0)])
def test_an_upright_face_in_profile_goes_before_the_same_one_askew(monkeypatch, photo, suspected, roll_deg):
    upright, askew = FaceBox(1, 1, 9, 9, 0.0, True), FaceBox(2, 2, 9, 9, -30.0, True)
    seeing(monkeypatch, [], [askew, upright])
    seen, glimpse = {0.0: 1, -30.0: 2}, {0.0: suspected, -30.0: 3}
    chosen = chosen_by(photo, lambda box: seen[box.roll_deg], glimpse=lambda box: glimpse[box.roll_deg])
    assert [face.roll_deg for face in chosen] == [roll_deg]


def test_where_nothing_is_confirmed_a_hint_of_a_face_is_enough(monkeypatch, photo):
    seeing(monkeypatch, [DOUBTFUL], GUESSES)
    assert chosen_by(photo, lambda box: int(box == DOUBTFUL)) == [DOUBTFUL]


@pytest.mark.parametrize(("found", "evidence"), [([DOUBTFUL], 0), ([], 1)])
def test_neither_what_shows_nothing_of_a_face_nor_a_guess_that_shows_one_part_is_one(
    monkeypatch, photo, found, evidence
):
    seeing(monkeypatch, found, GUESSES)
    with pytest.raises(InputError, match="no face found"):
        chosen_by(photo, lambda box: evidence)


def test_small_faces_are_looked_for_where_nothing_else_is(monkeypatch, photo):
    seeing(monkeypatch, [], GUESSES, [DOUBTFUL])
    assert chosen_by(photo, lambda box: 2 * (box == DOUBTFUL)) == [replace(DOUBTFUL, doubtful=False)]
    assert chosen_by(photo, lambda box: 1 * (box == DOUBTFUL)) == [DOUBTFUL]
    assert choose_faces(photo) == [DOUBTFUL]
    assert [face.roll_deg for face in chosen_by(photo, lambda box: 2, glimpse=lambda box: 3)] == [90.0]
    with pytest.raises(InputError, match="no face"):
        chosen_by(photo, lambda box: 0)


@pytest.mark.parametrize("found", [SURE, DOUBTFUL])
def test_small_faces_are_not_looked_for_beside_larger_ones(monkeypatch, photo, found):
    seeing(monkeypatch, [found], GUESSES)
    monkeypatch.setattr(choosing_faces, "find_small_faces", lambda photo: pytest.fail("looked"))
    assert choose_faces(photo) == [found]
    assert chosen_by(photo, lambda box: 1 * (box == found)) == [found]


def test_a_face_that_no_cascade_sees_is_located_by_its_parsing(monkeypatch, photo):
    seeing(monkeypatch, [DOUBTFUL], GUESSES)
    located = FaceBox(2, 2, 12, 14, doubtful=True)
    places = iter([None, located])
    chosen = chosen_by(photo, lambda box: 3 if box == located else 1, lambda view: next(places, None))
    assert [(face.x0, face.y1, face.doubtful) for face in chosen] == [(2, 14, False)]


def test_what_is_located_must_show_parts_of_a_face(monkeypatch, photo):
    seeing(monkeypatch, [])
    with pytest.raises(InputError, match="no face"):
        chosen_by(photo, lambda box: 1, lambda view: FaceBox(2, 2, 12, 14))


@pytest.mark.parametrize(
    ("leading", "suspected", "confirmed"), [(4, 3, True), (3, 3, False), (5, 2, True), (4, 2, False), (10, 1, False)]
)
def test_a_face_in_part_is_located_where_several_windows_lead_to_it(monkeypatch, photo, leading, suspected, confirmed):
    # Ten windows; the others end at other places, each of which looks as much like a face.
    seeing(monkeypatch, [])
    ends = [FaceBox(2, 2 + i / 8, 12, 14 + i / 8, doubtful=True) for i in range(leading)]
    ends += [FaceBox(30 * i, 0, 30 * i + 9, 9, doubtful=True) for i in range(1, 11 - leading)]
    places = iter(ends)

    def search():
        return chosen_by(photo, lambda box: 1, lambda view: next(places), glimpse=lambda box: suspected)

    if confirmed:
        assert [(face.x0, face.doubtful) for face in search()] == [(2, False)]
    else:
        with pytest.raises(InputError, match="no face"):
            search()


def test_a_speck_that_shows_half_a_face_gives_way_to_a_face_that_is_located(monkeypatch, photo):
    speck, face = FaceBox(18, 18, 19, 19, doubtful=True), FaceBox(2, 2, 12, 14, doubtful=True)
    seen = {speck: 2, face: 3}
    seeing(monkeypatch, [speck])
    assert [chosen.x0 for chosen in chosen_by(photo, lambda box: seen.get(box, 0), lambda view: face)] == [2]
    # All of a face, or nothing better anywhere: then a small one it is.
    for shown, place in ((3, face), (2, None)):
        seen[speck] = shown
        seeing(monkeypatch, [speck])
        chosen = chosen_by(photo, lambda box: seen.get(box, 0), lambda view, place=place: place)
        assert [found.x0 for found in chosen] == [18]


def test_a_speck_beside_which_no_face_is_located_gives_way_to_a_larger_one_that_lies(monkeypatch, photo):
    speck, place = FaceBox(18, 18, 19, 19, doubtful=True), FaceBox(2, 2, 12, 14, doubtful=True)
    lying, small = FaceBox(3, 3, 12, 14, 90.0, True), FaceBox(3, 3, 5, 5, 90.0, True)
    for located, guess, left in ((None, lying, 3), (None, small, 18), (place, lying, 2)):
        seeing(monkeypatch, [speck], [guess])
        chosen = chosen_by(photo, lambda box: 2 if box == speck else 3, lambda view, at=located: at)
        assert [face.x0 for face in chosen] == [left]


def test_a_whole_face_that_lies_goes_before_one_that_is_only_suspected_to_stand(monkeypatch, photo):
    speck, place = FaceBox(18, 18, 19, 19, doubtful=True), FaceBox(2, 2, 12, 14, doubtful=True)
    lying = FaceBox(3, 3, 12, 14, 90.0, True)
    for seen_in_guess, left in ((3, 3), (2, 2)):
        seeing(monkeypatch, [speck], [lying])
        evidence = {speck: 2, lying: seen_in_guess}
        chosen = chosen_by(photo, lambda box, of=evidence: of.get(box, 1), lambda view: place, glimpse=lambda box: 3)
        assert [face.x0 for face in chosen] == [left]


@pytest.mark.parametrize(("seen", "left"), [(1, 2), (2, 10)])
def test_a_small_face_that_is_only_suspected_gives_way_to_a_much_wider_one(monkeypatch, photo, seen, left):
    # 3 of the photo's 20 pixels: no speck, if two of its parts are seen.
    small, face = FaceBox(10, 10, 13, 13, doubtful=True), FaceBox(2, 2, 12, 14, doubtful=True)
    seeing(monkeypatch, [small])
    evidence = {small: seen, face: 3}
    chosen = chosen_by(photo, lambda box: evidence[box], lambda view: face, glimpse=lambda box: 3)
    assert [found.x0 for found in chosen] == [left]


def test_of_several_specks_the_widest_is_what_a_face_must_exceed(monkeypatch, photo):
    # The finder sorts by confidence too, so the first need not be the widest.
    specks = [FaceBox(18, 18, 18.5, 18.5, doubtful=True), FaceBox(15, 2, 16.5, 3.5, doubtful=True)]
    face = FaceBox(2, 2, 6, 6, doubtful=True)
    seeing(monkeypatch, specks)
    chosen = chosen_by(photo, lambda box: 3 if box == face else 2, lambda view: face)
    assert [found.x0 for found in chosen] == [18, 15]


@pytest.mark.parametrize(("seen_in_guess", "seen_in_place", "left"), [(2, 3, 2), (3, 3, 4), (2, 1, 4)])
def test_a_guess_that_shows_half_a_face_gives_way_to_a_whole_one(
    monkeypatch, photo, seen_in_guess, seen_in_place, left
):
    leaves, face = FaceBox(4, 4, 8, 8, 120.0, True), FaceBox(2, 2, 12, 14, doubtful=True)
    seeing(monkeypatch, [], [leaves])
    evidence = {leaves: seen_in_guess, face: seen_in_place}
    chosen = chosen_by(photo, lambda box: evidence[box], lambda view: face, glimpse=lambda box: 3)
    assert [found.x0 for found in chosen] == [left]


@pytest.mark.parametrize(("width", "roll_deg", "left"), [(5, 120, 2), (5, -120, 2), (5, 0, 4), (10, 120, 4)])
def test_a_guess_that_lies_in_a_much_larger_face_that_stands_gives_way_to_it(monkeypatch, photo, width, roll_deg, left):
    half, face = FaceBox(4, 4, 4 + width, 4 + width, roll_deg, True), FaceBox(2, 2, 12, 14, doubtful=True)
    seeing(monkeypatch, [], [half])
    chosen = chosen_by(photo, lambda box: 2, lambda view: face, glimpse=lambda box: 3)
    assert [found.x0 for found in chosen] == [left]


def test_of_guesses_that_show_as_much_one_that_stands_is_chosen(monkeypatch, photo):
    seeing(monkeypatch, [], [GUESSES[1], FaceBox(3, 3, 9, 9, -30.0, True)])
    assert [face.roll_deg for face in chosen_by(photo, lambda box: 2)] == [-30.0]
    seeing(monkeypatch, [], [FaceBox(3, 3, 9, 9, -30.0, True), GUESSES[1]])
    chosen = chosen_by(photo, lambda box: {180.0: 3}.get(box.roll_deg, 2))
    assert [face.roll_deg for face in chosen] == [180.0]


def test_companions_that_show_enough_of_a_face_join_in_by_size(monkeypatch, photo):
    seeing(monkeypatch, [DOUBTFUL])
    larger, no_face = FaceBox(9, 9, 19, 19, doubtful=True), FaceBox(10, 0, 14, 4, doubtful=True)
    monkeypatch.setattr(choosing_faces, "guess_companions", lambda photo, known: [no_face, larger])
    chosen = chosen_by(photo, lambda box: 3, look_closer=lambda box: 2 if box == larger else 1)
    assert [(face.x0, face.doubtful) for face in chosen] == [(9, False), (10, False)]
    assert find_faces(photo) == chosen


def test_companions_are_looked_for_once_and_not_where_nobody_can_judge_them(monkeypatch, photo):
    monkeypatch.setattr(choosing_faces, "guess_companions", lambda photo, known: pytest.fail("looked for"))
    seeing(monkeypatch, [DOUBTFUL])
    assert choose_faces(photo) == [DOUBTFUL]
    seeing(monkeypatch, [SURE])
    assert chosen_by(photo, lambda box: 3, look_closer=lambda box: 3) == [SURE]


@pytest.mark.parametrize(("suspected", "confirmed"), [(3, True), (2, False)])
def test_all_parts_of_a_face_may_be_suspected_only_where_cascades_agree(monkeypatch, photo, suspected, confirmed):
    seeing(monkeypatch, [DOUBTFUL], GUESSES)
    glimpse = {"glimpse": lambda box: suspected if box == DOUBTFUL else 3}
    chosen = chosen_by(photo, lambda box: int(box == DOUBTFUL), **glimpse)
    assert [(face.x0, face.doubtful) for face in chosen] == [(10, not confirmed)]


def test_windows_that_lead_near_a_face_are_no_agreement_about_it(monkeypatch, photo):
    seeing(monkeypatch, [])
    # Neighbours share three fifths of their union, and those next to them a third.
    places = iter([FaceBox(2 + 3 * i, 2, 14 + 3 * i, 14, doubtful=True) for i in range(10)])
    with pytest.raises(InputError, match="no face"):
        chosen_by(photo, lambda box: 1, lambda view: next(places), glimpse=lambda box: 3)


@pytest.mark.parametrize(("left", "top", "is_part"), [(4, 4, True), (4, 13, False), (11, 4, False), (-3, 4, False)])
def test_a_guess_that_lies_below_or_beside_a_face_is_no_part_of_it(monkeypatch, photo, left, top, is_part):
    part, face = FaceBox(left, top, left + 5, top + 5, 120.0, True), FaceBox(2, 2, 12, 14, doubtful=True)
    seeing(monkeypatch, [], [part])
    chosen = chosen_by(photo, lambda box: 2, lambda view: face, glimpse=lambda box: 3)
    assert [found.x0 for found in chosen] == [2 if is_part else left]


@pytest.mark.parametrize("size", [(20, 60), (60, 20)])
def test_how_small_a_speck_is_goes_by_the_photo_s_shorter_side(monkeypatch, size):
    small, face = FaceBox(10, 10, 13, 13, doubtful=True), FaceBox(2, 2, 14, 16, doubtful=True)
    seeing(monkeypatch, [small])
    wide = Photo(np.zeros((*size, 3), np.float32))
    chosen = chosen_by(wide, lambda box: 2 if box == small else 3, lambda view: face)
    assert [found.x0 for found in chosen] == [10]


def test_of_whole_faces_one_that_stands_goes_before_one_of_which_more_is_suspected(monkeypatch, photo):
    standing = FaceBox(3, 3, 9, 9, -30.0, True)
    seeing(monkeypatch, [], [*GUESSES, standing])
    chosen = chosen_by(photo, lambda box: 3, glimpse=lambda box: 0 if box == standing else 3)
    assert [face.roll_deg for face in chosen] == [-30.0]


def test_after_a_whole_face_that_stands_no_guess_is_judged(monkeypatch, photo):
    standing, other, judged = FaceBox(3, 3, 9, 9, 0.0, True), FaceBox(1, 1, 9, 9, 0.0, True), []
    seeing(monkeypatch, [], [standing, other])
    chosen_by(photo, lambda box: judged.append(box) or 3)
    assert other not in judged


def test_one_face_is_chosen_by_its_number(photo):
    assert those_chosen(photo, [SURE, DOUBTFUL], None) == [SURE, DOUBTFUL]
    assert those_chosen(photo, [SURE, DOUBTFUL], 1) == [DOUBTFUL]
    for number in (-1, 2):
        with pytest.raises(InputError, match=f"no face number {number}; it has 2 faces, numbers 0 to 1"):
            those_chosen(photo, [SURE, DOUBTFUL], number)
    with pytest.raises(InputError, match="it has 1 face, number 0"):
        those_chosen(photo, [SURE], 1)
    named = replace(photo, path=Path("group.jpg"))
    with pytest.raises(InputError, match="^group.jpg: there is no face number 1"):
        those_chosen(named, [SURE], 1)
    with pytest.raises(InputError, match="^group.jpg: no face found"):
        those_chosen(named, [], None)
