"""What the person network says of a photo, and what becomes of the parsing."""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest
import torch
from tiny_networks import tiny_bundle_with_person

from relight_core.face.crop import Crop
from relight_core.face.person_view import person_view
from relight_core.imaging.photo import Photo
from relight_core.pipeline.per_photo import outline
from relight_core.pipeline.per_photo.outline import Outline, outline_person, parsing_within

BACKGROUND, SKIN, LEFT_EYE, HAIR, HAT, CLOTH = 0, 1, 4, 10, 11, 13
VIEW = Crop(100.0, 100.0, 120.0)


def half(size=64):
    """Person on the left."""
    likely = np.zeros((size, size), np.float32)
    likely[:, : size // 2] = 1
    return likely


def parsing_of(**shares):
    parsing = torch.full((1, 14, 32, 32), 1e-4)
    for label, share in (
        (BACKGROUND, shares.get("background", 0)),
        (HAIR, shares.get("hair", 0)),
        (HAT, shares.get("hat", 0)),
        (SKIN, shares.get("skin", 0)),
    ):
        parsing[:, label] += share
    return parsing / parsing.sum(1, keepdim=True)


def with_an_eye(parsing):
    """The same with a row of skin across its middle, in which there is an eye."""
    parsing[:, :, 15:17] = parsing_of(skin=1.0)[:, :, 15:17]
    parsing[:, LEFT_EYE, 15:17, 12:20] = 1e4
    return parsing / parsing.sum(1, keepdim=True)


def test_an_outline_is_the_same_in_its_own_view_at_another_size():
    likely, known = Outline(half(64), VIEW).seen_in(VIEW, 32)
    assert (known > 0.99).all()
    assert (likely[:, :15] > 0.99).all()
    assert (likely[:, 17:] < 0.01).all()


def test_a_view_that_lies_aside_sees_a_part_and_knows_no_more():
    aside = Crop(160.0, 100.0, 120.0)
    likely, known = Outline(half(), VIEW).seen_in(aside, 64)
    assert (known[:, :31] > 0.99).all()
    assert (known[:, 34:] == 0).all()
    assert (likely[:, 1:31] < 0.01).all()


def test_a_correction_counts_as_far_as_it_reaches():
    corrected = Outline(half(), VIEW).corrected(np.ones((32, 32), np.float32), Crop(130.0, 100.0, 60.0))
    assert (corrected.likely[20:44, 36:60] > 0.99).all()
    np.testing.assert_array_equal(corrected.likely[:4], half()[:4])


def test_two_looks_agree_half_way_as_far_as_the_other_reaches():
    nobody, everybody = (np.full((64, 64), likely, np.float32) for likely in (0.1, 0.9))
    both = Outline(nobody, VIEW).agreed(Outline(everybody, Crop(160.0, 100.0, 120.0))).likely
    np.testing.assert_allclose(both[:, :30], 0.1, atol=1e-3)
    np.testing.assert_allclose(both[:, 34:], 0.5, atol=1e-3)


def test_parsing_and_outline_meet_half_way_and_shares_stay():
    parsing = parsing_of(background=0.5, hair=0.3, skin=0.2)
    for likely, more in ((1.0, True), (0.0, False)):
        within = parsing_within(parsing, Outline(np.full((64, 64), likely, np.float32), VIEW), VIEW)
        torch.testing.assert_close(within.sum(1), torch.ones(1, 32, 32))
        assert bool((within[:, BACKGROUND] < 0.2).all()) is more
        ratio = within[:, HAIR] / within[:, SKIN]
        torch.testing.assert_close(ratio, torch.full_like(ratio, 1.5), rtol=0.01, atol=0)


def test_above_the_eyes_both_must_see_a_person_and_elsewhere_their_mean_counts():
    by_parsing = with_an_eye(parsing_of(background=0.7, hair=0.3))
    for likely in (0.9, 0.1):
        within = parsing_within(by_parsing, Outline(np.full((64, 64), likely, np.float32), VIEW), VIEW)
        person = 1 - within[0, BACKGROUND]
        assert (person[:12] < 0.45).all()
        assert bool((person[20:] > 0.5).all()) is (likely > 0.5)


@pytest.mark.parametrize(("worn", "a_person"), [("hat", True), ("hair", False)])
def test_a_plain_hat_above_the_eyes_stays_where_the_person_network_doubts_it(worn, a_person):
    """What is 0.99 hat to the one is one even where the other says 0.3, for caps; hair may be a tree."""
    by_parsing = with_an_eye(parsing_of(**{worn: 1.0}))
    within = parsing_within(by_parsing, Outline(np.full((64, 64), 0.3, np.float32), VIEW), VIEW)
    person = 1 - within[0, BACKGROUND]
    assert bool((person[:12] > 0.85).all()) is a_person
    assert bool((person[:12] < 0.5).all()) is not a_person


def banded(between=0.1):
    """What the person network says of a head, the hair well above it, and a band between the two."""
    likely = np.zeros((32, 32), np.float32)
    likely[2:, 4:28] = 1
    likely[5:9, 7:25] = between
    return likely


@pytest.mark.parametrize(("hat", "at_least", "at_most"), [(0.5, 0.8, 1.0), (0.0, 0.0, 0.3)])
def test_a_band_between_head_and_hair_is_worn_where_the_parsing_knows_of_no_gap_but_a_gap_in_hair_is_one(
    hat, at_least, at_most
):
    parsing = with_an_eye(parsing_of(hair=0.97 - hat, hat=hat, background=0.03))
    person = 1 - parsing_within(parsing, Outline(banded(), VIEW), VIEW)[0, BACKGROUND]
    assert at_least <= float(person[6, 16]) <= at_most


def test_a_band_that_is_open_to_one_side_is_as_the_person_network_has_it():
    likely, parsing = banded(), with_an_eye(parsing_of(hair=0.47, hat=0.5, background=0.03))
    likely[5:9, 25:] = 0
    assert 1 - float(parsing_within(parsing, Outline(likely, VIEW), VIEW)[0, BACKGROUND, 6, 16]) < 0.3


def test_what_is_a_face_stays_one():
    within = parsing_within(parsing_of(skin=1.0), Outline(np.zeros((64, 64), np.float32), VIEW), VIEW)
    assert (within[:, SKIN] > 0.95).all()


def test_a_person_of_whom_the_parsing_knows_nothing_wears_something():
    within = parsing_within(parsing_of(background=1e4), Outline(np.ones((64, 64), np.float32), VIEW), VIEW)
    assert torch.isfinite(within).all()
    assert (within[:, 1:].argmax(1) + 1 == CLOTH).all()


@pytest.mark.parametrize("roll_deg", [0.0, 30.0])
def test_the_network_is_asked_about_the_view_of_a_face(roll_deg):
    photo = Photo(np.random.default_rng(0).random((200, 260, 3), np.float32))
    crop = Crop(130.0, 90.0, 80.0, roll_deg)
    bundle = tiny_bundle_with_person().for_inference()
    found = outline_person(bundle, photo, crop, person_view(crop, (200, 260)), "cpu")
    assert found.likely.shape == (256, 256)
    assert 0 <= found.likely.min() <= found.likely.max() <= 1
    assert found.view.roll_deg == roll_deg
    assert found.view.side == pytest.approx(min(3.4 * 80 * 196 / 256, 260))


def test_what_is_seen_in_a_mirror_counts_as_much():
    """The photo's mirror image then gives the mirrored outline, which a network by itself does not."""
    bundle = tiny_bundle_with_person().for_inference()
    linear = np.random.default_rng(0).random((200, 200, 3), np.float32)
    crop, view = Crop(100.0, 100.0, 80.0), Crop(100.0, 100.0, 200.0)

    def differences(**how):
        there, back = (
            outline_person(bundle, Photo(np.ascontiguousarray(image)), crop, view, "cpu", **how).likely
            for image in (linear, linear[:, ::-1])
        )
        return np.abs(there - back[:, ::-1]).max()

    assert differences(mirrors=(False, True)) < 1e-4
    assert differences() > 1e-3


class Listening:
    """In place of a person network: keeps what it is asked, (looks, 5, 256, 256), and gives each look one log odds."""

    def __init__(self, monkeypatch, *said):
        self.asked, self.said = None, said
        monkeypatch.setattr(outline, "in_precision", lambda *_: SimpleNamespace(person=self))

    def __call__(self, seen, inside, face):
        self.asked = torch.cat([seen, inside, face], 1).numpy()
        return torch.tensor(self.said)[:, None, None, None].expand(-1, 1, 256, 256)


def test_the_network_sees_an_exposed_photo_as_it_is_displayed_and_nothing_beyond_it(monkeypatch):
    """A view from 40 pixels left of the photo: 0.2 at twice that, 0.4 linear, is 0.665 in sRGB; 0.7 is blown out."""
    listening, photo = Listening(monkeypatch, 0.0), Photo(np.full((200, 200, 3), 0.2, np.float32))
    photo.linear[90:110, 100:120] = 0.7
    outline_person(None, photo, Crop(60.0, 100.0, 80.0), Crop(60.0, 100.0, 200.0), "cpu", exposure=2.0)
    (asked,) = listening.asked
    np.testing.assert_allclose(asked[:3, :100, 54:], 0.6652, atol=1e-3)
    np.testing.assert_allclose(asked[:3, 118:138, 182:202], 1, atol=1e-6)
    assert asked[3, :, 54:].min() == 1
    assert asked[:4, :, :50].max() == 0
    assert asked[4, 128, 128] == 1
    assert asked[4, :, :60].max() == asked[4, :50].max() == 0


def test_the_network_sees_a_framed_photo_end_with_its_picture(monkeypatch):
    y, x = np.mgrid[0:200, 0:160] / 30
    picture = np.dstack([0.4 + 0.2 * np.sin(x + y), 0.4 + 0.2 * np.cos(x - y), 0.3 + 0.1 * np.sin(2 * x)])
    whole = cv2.copyMakeBorder(picture.astype(np.float32), 20, 20, 60, 60, cv2.BORDER_CONSTANT, value=(1.0,) * 3)
    listening, view = Listening(monkeypatch, 0.0), Crop(140.0, 120.0, 256.0)
    outline_person(None, Photo(whole), Crop(140.0, 120.0, 80.0), view, "cpu")
    rows, columns = np.nonzero(listening.asked[0, 3])
    # The view begins 12 pixels right of the photo's left side, and 8 above its top.
    assert [columns.min(), columns.max() + 1] == pytest.approx([60 - 12, 220 - 12], abs=3)
    assert [rows.min(), rows.max() + 1] == pytest.approx([20 + 8, 220 + 8], abs=3)


def test_of_two_looks_the_log_odds_are_averaged(monkeypatch):
    Listening(monkeypatch, 4.0, -1.0)
    photo = Photo(np.full((200, 200, 3), 0.2, np.float32))
    found = outline_person(None, photo, Crop(100.0, 100.0, 80.0), Crop(100.0, 100.0, 200.0), "cpu", (False, True))
    np.testing.assert_allclose(found.likely, 1 / (1 + np.exp(-1.5)), rtol=1e-5)


@pytest.mark.parametrize("roll_deg", [0.0, 30.0])
def test_toward_the_end_of_what_is_known_nobody_becomes_less_likely(roll_deg):
    likely, known = Outline(np.ones((64, 64), np.float32), VIEW).seen_in(Crop(160.0, 130.0, 117.0, roll_deg), 64)
    assert 0 < known[known > 0].min() < 0.9
    np.testing.assert_allclose(likely[known > 0.01], 1, rtol=1e-4)


def test_beyond_the_view_of_the_person_network_the_parsing_counts_alone():
    parsing = parsing_of(hair=1.0)
    nobody = Outline(np.zeros((64, 64), np.float32), Crop(40.0, 100.0, 120.0))
    within = parsing_within(parsing, nobody, VIEW)
    assert (within[..., :14][:, BACKGROUND] > 0.8).all()
    torch.testing.assert_close(within[..., 18:], parsing[..., 18:], rtol=0, atol=0.01)


def test_what_is_plainly_a_hat_and_surely_nobody_is_rather_a_hat_and_not_surely():
    by_parsing = with_an_eye(parsing_of(hat=1.0))
    within = parsing_within(by_parsing, Outline(np.zeros((64, 64), np.float32), VIEW), VIEW)
    person = 1 - within[0, BACKGROUND, :12]
    assert 0.55 < float(person.min()) <= float(person.max()) < 0.9


@pytest.mark.parametrize("likely", [np.full((32, 32), 0.55, np.float32), 0.25 * banded(0.0)])
def test_a_hat_fills_no_gap_where_there_is_none_or_what_is_around_is_hardly_a_person(likely):
    parsing = with_an_eye(parsing_of(hair=0.47, hat=0.5, background=0.03))
    person = 1 - parsing_within(parsing, Outline(likely, VIEW), VIEW)[0, BACKGROUND]
    assert float(person[6, 16]) < 0.65
