"""Masks over mouth or eyes: found, in the skin's colour while a face is de-lit, and cloth of their own afterwards."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from plain_face import (
    CLOTH,
    FOREHEAD,
    HAIR,
    LEFT_EYE,
    MASK,
    MASKS,
    MOUTH,
    RIGHT_EYE,
    SIZE,
    SKIN,
    TONE,
    face,
    take_apart_seeing,
    view_of,
)

from relight_core.pipeline.per_photo.face_covering import find_face_covering


def masked_eyes(colour, rows=(26, 44), columns=(26, 70), lips=0.95):
    """The same with a mask about the eyes, which leaves as much of them bare as masks do."""
    seen = face(lips=lips)
    down, across = np.mgrid[:SIZE, :SIZE]
    hole = (((np.abs(across - 47.5) - 12) / 6) ** 2 + ((down - 34.5) / 4) ** 2) < 1
    inside = (rows[0] <= down) & (down < rows[1]) & (columns[0] <= across) & (across < columns[1])
    seen.photo[0][:, torch.from_numpy(inside & ~hole)] = torch.tensor(colour, dtype=torch.float32)[:, None]
    return seen


@pytest.mark.parametrize("parsed_as", [SKIN, 0], ids=["as skin", "as background"])
@pytest.mark.parametrize("colour", MASKS)
def test_a_mask_of_any_colour_is_found_whatever_it_is_parsed_as(colour, parsed_as):
    share = find_face_covering(face(MASKS[colour], parsed_as=parsed_as)).share[0, 0]
    assert share[MASK][2:-2, 2:-2].min() > 0.95
    assert share[:42].max() == share[83:].max() == share[:, :23].max() == share[:, 73:].max() == 0


def test_a_bare_mouth_is_not_covered():
    assert find_face_covering(face()) is None
    assert find_face_covering(face(lips=0.95)) is None


def test_where_lips_are_seen_a_colour_is_paint_or_light():
    assert find_face_covering(face(MASKS["blue"], lips=0.95)) is None
    assert find_face_covering(face(MASKS["blue"], lips=0.5)) is not None


def test_a_cup_at_the_lips_leaves_the_upper_lip_s_skin_bare():
    drinking = face(MASKS["red"])
    drinking.photo[..., :59, :] = face().photo[..., :59, :]
    share = find_face_covering(drinking).share[0, 0]
    assert share[62:78, 28:68].min() > 0.95
    assert share[:57].max() == 0


def test_neither_a_shadow_nor_half_a_mouth_is_a_covering():
    assert find_face_covering(face(shade=0.2)) is None
    half = face(MASKS["green"])
    half.photo[..., :48] = torch.tensor(TONE)[:, None, None]
    assert find_face_covering(half) is None


def test_without_both_eyes_or_a_forehead_nothing_is_known():
    for label in (LEFT_EYE, RIGHT_EYE):
        one_eyed = face(MASKS["white"])
        one_eyed.parsing[:, label] = 0
        assert find_face_covering(one_eyed) is None
    veiled = face(MASKS["white"])
    veiled.parsing[:, SKIN, :42] = 0
    assert find_face_covering(veiled) is None


def test_a_face_as_dark_as_can_be_has_none():
    black = face(MASKS["red"])
    assert find_face_covering(replace(black, photo=torch.zeros_like(black.photo))) is None


@pytest.mark.parametrize("colour", ["blue", "red", "green", "white"])
def test_a_mask_about_the_eyes_is_found_but_for_the_eyes(colour):
    share = find_face_covering(masked_eyes(MASKS[colour])).share[0, 0]
    assert share[28:42, 46:50].min() == share[28:42, 28].min() == share[28:42, 67].min() == 1
    assert share[34:36, 34:38].max() == share[34:36, 58:62].max() == 0
    assert share[:25].max() == share[46:].max() == share[:, :25].max() == share[:, 72:].max() == 0


def test_taken_off_it_has_the_colour_of_skin_and_put_on_its_own():
    seen = masked_eyes(MASKS["blue"])
    covering = find_face_covering(seen)
    bridge, cheek = np.s_[29:41, 46:50], np.s_[60:70, 40:56]
    plain = covering.taken_off(view_of(seen))
    np.testing.assert_allclose(plain[bridge].mean((0, 1)), TONE, rtol=0.05)
    np.testing.assert_array_equal(plain[cheek], view_of(seen)[cheek])
    worn = covering.put_on(seen, view_of(seen))
    torch.testing.assert_close(worn.albedo[0][:, *bridge].mean((1, 2)), torch.tensor(MASKS["blue"]), rtol=0.05, atol=0)
    assert worn.parsing[0, CLOTH][bridge].min() == 1
    assert worn.parsing[0, RIGHT_EYE][34:36, 34:38].min() == 1


@pytest.mark.parametrize(
    "elsewhere",
    [
        {"rows": (0, 44)},
        {"rows": (26, 90)},
        {"columns": (26, 44)},
        {"columns": (52, 70)},
        {"lips": 0.0},
    ],
    ids=["a brim's shadow", "all of the face", "one side", "the other side", "no mouth to tell it by"],
)
def test_where_it_is_not_about_the_eyes_alone_a_colour_is_paint_or_light(elsewhere):
    assert find_face_covering(masked_eyes(MASKS["blue"], **elsewhere)) is None


def test_tinted_glasses_leave_the_bridge_of_the_nose_bare():
    seen = masked_eyes(MASKS["blue"])
    seen.photo[..., 42:54] = face().photo[..., 42:54]
    assert find_face_covering(seen) is None


def test_dark_skin_about_the_eyes_is_no_covering():
    assert find_face_covering(masked_eyes(0.3 * np.float32(TONE))) is None


def test_hair_beside_it_and_the_wall_behind_do_not_belong_to_it():
    beside = face(MASKS["blue"])
    beside.parsing[:, :, 40:84, 66:78] = 0
    beside.parsing[:, HAIR, 40:84, 66:78] = 1
    beside.photo[..., 40:84, 66:78] = torch.tensor((0.02, 0.02, 0.02))[:, None, None]
    share = find_face_covering(beside).share[0, 0]
    assert share[50:74, 30:60].min() > 0.95
    assert share[:, 69:].max() == 0


def test_a_leaning_head_has_its_mouth_where_its_eyes_say():
    upright = face(MASKS["red"])
    leaning = replace(upright, **{n: getattr(upright, n).rot90(1, (2, 3)) for n in ("photo", "parsing", "person")})
    share = find_face_covering(leaning).share
    torch.testing.assert_close(share, find_face_covering(upright).share.rot90(1, (2, 3)))


@pytest.mark.parametrize("colour", ["blue", "white", "red"])
def test_taken_off_a_mask_has_the_colour_of_skin(colour):
    seen = face(MASKS[colour])
    plain = find_face_covering(seen).taken_off(view_of(seen))
    np.testing.assert_allclose(plain[MOUTH].mean((0, 1)), TONE, rtol=0.05)
    np.testing.assert_array_equal(plain[FOREHEAD], view_of(seen)[FOREHEAD])


def test_put_on_it_is_cloth_of_its_own_colour():
    seen = face(MASKS["blue"])
    covering = find_face_covering(seen)
    worn = covering.put_on(seen, view_of(seen))
    torch.testing.assert_close(worn.albedo[0][:, *MOUTH].mean((1, 2)), torch.tensor(MASKS["blue"]), rtol=0.05, atol=0.0)
    torch.testing.assert_close(worn.photo, seen.photo)
    assert worn.parsing[0, CLOTH][MASK][2:-2, 2:-2].min() > 0.95
    torch.testing.assert_close(worn.parsing.sum(1), torch.ones(1, SIZE, SIZE))
    torch.testing.assert_close(worn.parsing[..., :42, :], seen.parsing[..., :42, :])
    assert worn.person[0, 0][MASK].min() > 0.95


@pytest.mark.parametrize("again", [False, True])
def test_a_masked_face_is_de_lit_in_the_colour_of_skin(monkeypatch, again):
    masked = face(MASKS["green"])
    view = view_of(masked)
    found, views = take_apart_seeing(monkeypatch, masked, looks_twice=again)
    np.testing.assert_allclose(views[0], view, atol=1e-6)
    for later in views[1:]:
        ratio = later[MOUTH].mean((0, 1)) / later[FOREHEAD].mean((0, 1))
        np.testing.assert_allclose(ratio, 1, atol=0.1)
    assert len(views) == 2 + again
    torch.testing.assert_close(found.photo, masked.photo, atol=1e-4, rtol=1e-3)
    assert found.parsing[0, CLOTH][MOUTH].min() > 0.95
    assert found.albedo[0, 0][MOUTH].max() < 0.3 * found.albedo[0, 1][MOUTH].min()
