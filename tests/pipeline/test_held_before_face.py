"""Phones, cards and stickers before a face: found by background within it, and whole though half of them is skin."""

import numpy as np
import pytest
import torch
from plain_face import (
    CLOTH,
    FOREHEAD,
    HAIR,
    LEFT_EYE,
    MASKS,
    RIGHT_EYE,
    SKIN,
    TONE,
    WALL,
    face,
    take_apart_seeing,
    view_of,
)

from relight_core.pipeline.per_photo.held_before_face import find_held_before_face

PHONE, CHEEK = np.s_[26:66, 50:72], np.s_[50:80, 24:46]
BACKGROUND = 0


def held(colour, phone=PHONE, as_background=0.5):
    """A face with a phone over its left eye; the parsing takes a share of its columns for background, else for skin."""
    seen = face()
    rows, columns = phone
    end = columns.stop - round((1 - as_background) * (columns.stop - columns.start))
    seen.photo[0][:, rows, columns] = torch.tensor(colour, dtype=torch.float32)[:, None, None]
    seen.parsing[0][:, rows, columns] = 0
    seen.parsing[0, SKIN, rows, columns] = 1
    seen.parsing[0][:, rows, columns.start : end] = 0
    seen.parsing[0, BACKGROUND, rows, columns.start : end] = 1
    return seen


def inner(place, by=2):
    return tuple(slice(one.start + by, one.stop - by) for one in place)


def outside(share, place, by=3):
    rest = share.clone()
    rest[tuple(slice(one.start - by, one.stop + by) for one in place)] = 0
    return rest


@pytest.mark.parametrize("as_background", [1.0, 0.5, 0.2])
@pytest.mark.parametrize("colour", MASKS)
def test_it_is_whole_however_much_of_it_is_skin_to_the_parsing(colour, as_background):
    share = find_held_before_face(held(MASKS[colour], as_background=as_background)).share[0, 0]
    assert share[inner(PHONE)].min() == 1
    assert outside(share, PHONE).max() == 0


def test_a_plain_face_has_nothing_before_it():
    assert find_held_before_face(face()) is None
    assert find_held_before_face(held(MASKS["red"], as_background=0.0)) is None


def test_skin_that_is_taken_for_background_is_nothing_before_it():
    assert find_held_before_face(held(TONE)) is None
    assert find_held_before_face(held(tuple(0.5 * np.float32(TONE)))) is None


def test_a_speck_is_nothing():
    assert find_held_before_face(held(MASKS["white"], np.s_[50:55, 30:35], as_background=1.0)) is None


@pytest.mark.parametrize("columns", [(2, 20), (76, 92)])
def test_the_wall_beside_a_face_is_none_of_it(columns):
    beside = held(MASKS["white"], np.s_[40:60, slice(*columns)], as_background=0.0)
    beside.parsing[0, :, 40:60, columns[0] : columns[1]] = torch.eye(14)[BACKGROUND][:, None, None]
    assert find_held_before_face(beside) is None


def test_without_an_eye_or_skin_there_is_no_face_to_hold_it_before():
    blind = held(MASKS["red"])
    blind.parsing[:, [LEFT_EYE, RIGHT_EYE]] = 0
    assert find_held_before_face(blind) is None
    bare = held(MASKS["red"])
    bare.parsing[:, SKIN] = 0
    assert find_held_before_face(bare) is None


def test_lighter_and_darker_places_of_one_colour_belong_to_it():
    shaded = held(MASKS["blue"])
    shaded.photo[0][:, PHONE[0], PHONE[1]] *= torch.linspace(0.5, 1.3, 40)[:, None]
    assert find_held_before_face(shaded).share[0, 0][inner(PHONE)].min() == 1


def test_hair_beside_it_is_no_part_of_it():
    fringe = held(MASKS["black"])
    fringe.photo[..., 14:26, 50:72] = torch.tensor(MASKS["black"])[:, None, None]
    fringe.parsing[:, :, 14:26, 50:72] = torch.eye(14)[HAIR][:, None, None]
    share = find_held_before_face(fringe).share[0, 0]
    assert share[inner(PHONE)].min() == 1
    assert share[:23].max() == 0


def test_what_sticks_out_beyond_the_face_belongs_to_it_but_a_wall_of_its_colour_does_not():
    phone = np.s_[36:66, 50:88]
    share = find_held_before_face(held(MASKS["red"], phone, as_background=1.0)).share[0, 0]
    assert share[inner(phone)].min() == 1
    share = find_held_before_face(held(WALL, phone, as_background=1.0)).share[0, 0]
    assert share[inner(np.s_[36:66, 50:78])].min() == 1
    assert share[:, 86:].max() == share[:, :45].max() == 0


def test_a_face_is_de_lit_as_if_nothing_were_before_it(monkeypatch):
    seen = held(MASKS["red"])
    view = view_of(seen)
    found, views = take_apart_seeing(monkeypatch, seen)
    first, again = views
    np.testing.assert_allclose(first, view, atol=1e-6)
    np.testing.assert_allclose(again[inner(PHONE)].mean((0, 1)), TONE, rtol=0.1)
    np.testing.assert_array_equal(again[FOREHEAD[0], :46], view[FOREHEAD[0], :46])
    np.testing.assert_array_equal(again[CHEEK], view[CHEEK])
    assert found.parsing[0, CLOTH][inner(PHONE)].min() == 1
    np.testing.assert_allclose(found.albedo[0][:, *inner(PHONE)].mean((1, 2)), MASKS["red"], rtol=0.1)
