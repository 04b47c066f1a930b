"""The view of a face that the networks see."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from relight_core.errors import InputError
from relight_core.face.crop import Crop, crop_with_padding
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.pipeline.per_photo.portrait import checked_boxes, frame, framed, located, refine, straightened

PHOTO = Photo(np.full((400, 360, 3), 0.4, np.float32))
FOUND = FaceBox(150.0, 170.0, 210.0, 250.0)
BACKGROUND, SKIN, LEFT_EYE, RIGHT_EYE = 0, 1, 4, 5
SIZE = 128


def places_in(view):
    """(S, S, 2) x, y in the photo of the pixels of a view."""
    across, down = np.meshgrid(np.arange(SIZE) + 0.5, np.arange(SIZE) + 0.5)
    return view.to_photo(np.dstack([across, down]).reshape(-1, 2), SIZE).reshape(SIZE, SIZE, 2)


def parsing_of(view, *box):
    """(14, S, S) of a view of a photo in which x0, y0, x1, y1 is a face."""
    at = places_in(view)
    face = ((at > box[:2]) & (at < box[2:])).all(-1)
    parsing = np.zeros((14, SIZE, SIZE), np.float32)
    parsing[SKIN], parsing[BACKGROUND] = face, ~face
    return parsing


def eyes_at(leaning_deg):
    """x, y in the photo of both eyes of a head whose line of eyes goes down to the left by so much."""
    right, down = 22 * np.cos(np.radians(leaning_deg)), 22 * np.sin(np.radians(leaning_deg))
    return np.array([[180 - right, 200 + down], [180 + right, 200 - down]])


def eyes_in(view, eyes):
    """(S, S) labels of a view of two eyes."""
    labels = np.full((SIZE, SIZE), SKIN)
    for place, label in zip(eyes, (RIGHT_EYE, LEFT_EYE), strict=True):
        labels[np.linalg.norm(places_in(view) - place, axis=-1) < 5] = label
    return labels


@pytest.mark.parametrize(
    ("x", "y", "width", "height"),
    [(20, 30, 40, 56), (130, 20, 40, 56), (70, 60, 40, 56), (140, 150, 40, 56), (60.3, 60.4, 100, 120)],
)
def test_a_view_is_wider_than_its_crop_and_shows_nothing_beyond_the_photo(x, y, width, height):
    portrait = frame(Photo(np.full((240, 200, 3), 0.4, np.float32)), FaceBox(x, y, x + width, y + height))
    x0, y0, x1, y1 = portrait.view.window
    assert 0 <= x0 < x1 <= 200
    assert 0 <= y0 < y1 <= 240
    left, top, right, bottom = portrait.crop.window
    assert x0 <= max(left, 0) + 0.5
    assert y0 <= max(top, 0) + 0.5
    assert x1 >= min(right, 200) - 0.5
    assert y1 >= min(bottom, 240) - 0.5
    assert all(edge == round(edge) for edge in portrait.view.window), "pixels of the photo are not mixed"
    assert portrait.view.side == round(min(1.7 * portrait.crop.side, 200))


def test_a_face_as_large_as_its_photo_is_seen_whole_and_no_wider():
    portrait = frame(Photo(np.full((120, 100, 3), 0.4, np.float32)), FaceBox(10, 20, 90, 110))
    assert portrait.view.side == round(portrait.crop.side)
    assert portrait.crop.side > 100


def test_a_view_wider_than_its_photo_shows_as_much_beyond_it_on_either_side():
    portrait = frame(Photo(np.full((400, 60, 3), 0.4, np.float32)), FaceBox(0.0, 170.0, 60.0, 250.0))
    assert portrait.view.side > 100
    assert portrait.view.centre_x == pytest.approx(30, abs=0.5)


def test_the_view_of_a_leaning_face_stays_about_it_where_the_photo_ends():
    portrait = frame(PHOTO, FaceBox(0.0, 10.0, 60.0, 90.0, 30.0))
    assert portrait.view == replace(portrait.crop, side=portrait.view.side)
    assert portrait.view.roll_deg == 30


@pytest.mark.parametrize(
    ("found_deg", "leaning_deg"), [(0, 12), (0, -12), (0, 25), (20, 25), (20, 14), (-20, -40), (-20, -26)]
)
def test_a_head_that_leans_is_turned_upright(found_deg, leaning_deg):
    portrait, eyes = frame(PHOTO, replace(FOUND, roll_deg=float(found_deg))), eyes_at(leaning_deg)
    upright = straightened(portrait, eyes_in(portrait.view, eyes)).view
    (left, left_down), (right, right_down) = upright.from_photo(eyes, SIZE)
    assert left < right
    assert left_down == pytest.approx(right_down, abs=1)


@pytest.mark.parametrize(("found_deg", "leaning_deg"), [(0, 8), (0, -8), (20, 21.5), (-20, -18.5)])
def test_a_head_that_hardly_leans_is_left_as_it_is_found(found_deg, leaning_deg):
    portrait = frame(PHOTO, replace(FOUND, roll_deg=float(found_deg)))
    assert straightened(portrait, eyes_in(portrait.view, eyes_at(leaning_deg))) is None


def test_the_face_is_where_the_parsing_has_it():
    portrait = frame(PHOTO, FOUND)
    refined = refine(portrait, parsing_of(portrait.view, 158, 160, 224, 245))
    box = refined.face
    assert [box.x0, box.y0, box.x1, box.y1] == pytest.approx([158, 160, 224, 245], abs=1.5)
    assert refined.found == FOUND
    assert refined.crop == crop_with_padding(box)
    assert [refined.view.centre_x, refined.view.centre_y] == pytest.approx([191, 202.5], abs=2)
    assert refined.view.side == pytest.approx(1.7 * refined.crop.side, abs=1)


@pytest.mark.parametrize(
    "box",
    [(150, 170, 193, 250), (150, 170, 233, 250), (150, 170, 210, 226), (150, 150, 210, 280)],
    ids=["narrower", "wider", "lower", "taller"],
)
def test_a_parsing_that_has_somewhat_less_or_more_of_the_face_is_believed(box):
    portrait = frame(PHOTO, FOUND)
    face = refine(portrait, parsing_of(portrait.view, *box)).face
    assert [face.x0, face.y0, face.x1, face.y1] == pytest.approx(box, abs=1.5)


@pytest.mark.parametrize(
    "box",
    [
        (186, 170, 246, 250),
        (150, 225, 210, 305),
        (163, 170, 197, 250),
        (130, 170, 228, 250),
        (150, 190, 210, 235),
        (150, 120, 210, 272),
    ],
    ids=["aside", "below", "narrow", "wide", "low", "tall"],
)
def test_a_parsing_that_has_another_face_than_was_found_is_not_believed(box):
    portrait = frame(PHOTO, FOUND)
    assert refine(portrait, parsing_of(portrait.view, *box)) is portrait


def test_nor_is_one_that_has_a_face_elsewhere_or_none():
    portrait = frame(PHOTO, FaceBox(0.0, 0.0, 40.0, 40.0))
    assert portrait.view.window[2] >= 110
    assert refine(portrait, parsing_of(portrait.view, 70, 70, 110, 110)) is portrait
    assert refine(portrait, parsing_of(portrait.view, 0, 0, 0, 0)) is portrait


def test_a_face_is_framed_upright_as_the_parsing_has_it():
    eyes, looked = eyes_at(25), []

    def parsed(view):
        looked.append(view.roll_deg)
        middle = parsing_of(view, 150, 165, 212, 248)
        for place, label in zip(eyes, (RIGHT_EYE, LEFT_EYE), strict=True):
            eye = np.linalg.norm(places_in(view) - place, axis=-1) < 5
            middle[:, eye], middle[label, eye] = 0, 1
        return middle

    portrait = framed(PHOTO, FOUND, parsed)
    assert looked == [0, portrait.view.roll_deg]
    across = portrait.view.from_photo(eyes, SIZE)
    assert across[0, 1] == pytest.approx(across[1, 1], abs=1)


def test_a_face_is_looked_at_three_times_from_nearer_and_nearer():
    looked = []

    def parsed(view):
        looked.append(view)
        return parsing_of(view, 100, 120, 140, 172)

    box = located(PHOTO, Crop(180.0, 200.0, 360.0), parsed)
    assert [box.x0, box.y0, box.x1, box.y1] == pytest.approx([100, 120, 140, 172], abs=1)
    assert len(looked) == 3
    assert looked[0].side > 1.5 * looked[1].side
    assert looked[1].side == pytest.approx(looked[2].side, rel=0.1)


def test_a_face_that_is_lost_from_near_stays_where_it_was_seen():
    seen = [(100, 120, 140, 172), (0, 0, 0, 0)]
    box = located(PHOTO, Crop(180.0, 200.0, 360.0), lambda view: parsing_of(view, *seen.pop(0)))
    assert [box.x0, box.y0, box.x1, box.y1] == pytest.approx([100, 120, 140, 172], abs=3)
    assert located(PHOTO, Crop(180.0, 200.0, 360.0), lambda view: parsing_of(view, 0, 0, 0, 0)) is None


@pytest.mark.parametrize(
    "box",
    [
        FaceBox(10.0, 10.0, 10.5, 60.0),
        FaceBox(10.0, 10.0, 60.0, 10.5),
        FaceBox(float("nan"), 10.0, 60.0, 60.0),
        FaceBox(10.0, 10.0, float("inf"), 60.0),
        FaceBox(10.0, 10.0, 60.0, 60.0, float("nan")),
        FaceBox(-60.0, 10.0, -10.0, 60.0),
        FaceBox(10.0, -60.0, 60.0, -10.0),
        FaceBox(365.0, 10.0, 420.0, 60.0),
        FaceBox(10.0, 405.0, 60.0, 460.0),
        FaceBox(-700.0, 10.0, 1000.0, 60.0),
        FaceBox(10.0, -700.0, 60.0, 1000.0),
    ],
)
def test_boxes_that_hold_no_face_are_refused(box):
    with pytest.raises(InputError, match="box of a face"):
        checked_boxes(PHOTO, [FOUND, box])


def test_boxes_that_reach_into_the_photo_are_kept():
    boxes = [
        FOUND,
        FaceBox(-40.0, -40.0, 10.0, 10.0),
        FaceBox(350.0, 390.0, 400.0, 450.0),
        FaceBox(10.0, 10.0, 11.0, 11.0),
    ]
    assert checked_boxes(PHOTO, boxes) == boxes
    at_the_foot = FaceBox(10.0, 370.0, 60.0, 398.0)
    assert checked_boxes(PHOTO, [at_the_foot]) == [at_the_foot]
    nearly_four_times_as_large = FaceBox(-600.0, 10.0, 990.0, 60.0)
    assert checked_boxes(PHOTO, [nearly_four_times_as_large]) == [nearly_four_times_as_large]


@pytest.mark.parametrize("box", [FaceBox(-60.0, 10.0, -10.0, 60.0), FaceBox(-700.0, 10.0, 1000.0, 60.0)])
def test_who_draws_a_wrong_box_is_told_over_which_photo(box):
    with pytest.raises(InputError, match="^me.jpg: the box of a face"):
        checked_boxes(replace(PHOTO, path=Path("me.jpg")), [box])
