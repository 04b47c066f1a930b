"""A white collar that parsing takes for the neck: cloth where it is brighter than the face and of no colour."""

import pytest
import torch

from relight_core.pipeline.per_photo.white_collar import with_white_collar

SIZE, SKIN, LIPS, NECK, CLOTH = 24, 1, 8, 9, 13
SKIN_ALBEDO = torch.tensor([0.5, 0.3, 0.2])[:, None, None]
PINK = torch.tensor([0.7, 0.5, 0.42])[:, None, None]
COLLAR = slice(20, SIZE)


def portrait(collar, light=(1.0, 1.0, 1.0), rows=COLLAR):
    """Photo, albedo and parsing: a face with lips, a neck below it, and in some rows of the neck what looks pink."""
    parsing = torch.zeros(1, 14, SIZE, SIZE)
    parsing[:, SKIN, :12] = 1
    parsing[:, LIPS, 12] = 1
    parsing[:, NECK, 13:] = 1
    truth = SKIN_ALBEDO.expand(3, SIZE, SIZE).clone()
    truth[:, rows] = torch.as_tensor(collar)
    found = SKIN_ALBEDO.expand(3, SIZE, SIZE).clone()
    found[:, rows] = PINK
    photo = (truth * torch.tensor(light)[:, None, None]).clamp(0, 1)
    return photo[None], found[None], parsing


def red_over_blue(albedo):
    return float((albedo[0, 0] / albedo[0, 2])[COLLAR].median())


def test_a_neck_that_is_white_and_brighter_than_the_face_is_a_collar():
    photo, albedo, parsing = portrait(0.8)
    white, parsed = with_white_collar(photo, albedo, parsing)
    assert float(parsed[0, CLOTH, COLLAR].min()) > 0.95
    torch.testing.assert_close(parsed.sum(1), parsing.sum(1))
    assert abs(red_over_blue(white) - 1) < 0.1
    torch.testing.assert_close(white[..., :20, :], albedo[..., :20, :])
    torch.testing.assert_close(parsed[..., :20, :], parsing[..., :20, :])


@pytest.mark.parametrize(("collar", "light"), [(0.8, (1.0, 0.9, 0.75)), (2.0, (1.0, 1.0, 1.0))])
def test_so_is_one_in_a_coloured_light_and_one_that_is_blown_out(collar, light):
    white, parsed = with_white_collar(*portrait(collar, light))
    assert float(parsed[0, CLOTH, COLLAR].min()) > 0.95
    assert abs(red_over_blue(white) - 1) < 0.1


def is_left(photo, albedo, parsing):
    return all(a is b for a, b in zip(with_white_collar(photo, albedo, parsing), (albedo, parsing), strict=True))


def test_a_neck_in_brighter_light_than_the_face_stays_a_neck():
    assert is_left(*portrait(SKIN_ALBEDO * 1.9))


def test_a_neck_that_is_blown_out_in_places_stays_a_neck():
    blown = (SKIN_ALBEDO * torch.linspace(1, 5, 4)[:, None]).clamp_max(1)
    assert is_left(*portrait(blown.expand(3, 4, SIZE)))


def test_grey_that_is_darker_than_the_face_is_left():
    assert is_left(*portrait(0.2))


def test_beside_a_collar_what_is_no_neck_and_what_is_darker_than_the_face_stay():
    photo, albedo, parsing = portrait(0.8)
    parsing[:, NECK, COLLAR, :6], parsing[:, 0, COLLAR, :6] = 0, 1
    photo[:, :, 15:17] = 0.2
    white, parsed = with_white_collar(photo, albedo, parsing)
    assert float(parsed[0, CLOTH, COLLAR, 6:].min()) > 0.95
    assert float(parsed[0, NECK, 15:17].min()) == 1
    torch.testing.assert_close(white[..., COLLAR, :6], albedo[..., COLLAR, :6])


def test_what_is_bright_beside_the_face_is_left():
    assert is_left(*portrait(0.8, rows=slice(0, 3)))


@pytest.mark.parametrize("hidden", [LIPS, SKIN])
def test_a_view_without_a_mouth_or_a_face_s_skin_is_left(hidden):
    photo, albedo, parsing = portrait(0.8)
    parsing[:, hidden] = 0
    assert is_left(photo, albedo, parsing)


def white_from_the_jaw_down_to(row):
    """The share of cloth where, beside a wide face's jaw and on the neck from there on, something is white."""
    size, white = 64, (slice(32, row), slice(48, 50))
    parsing = torch.zeros(1, 14, size, size)
    parsing[:, NECK] = 1
    parsing[:, NECK, :40, :48], parsing[:, SKIN, :40, :48] = 0, 1
    parsing[:, SKIN, 30, 20:28], parsing[:, LIPS, 30, 20:28] = 0, 1
    photo = SKIN_ALBEDO.repeat(1, size, size)[None]
    albedo = photo.clone()
    photo[(..., *white)] = 0.8
    albedo[(..., *white)] = PINK
    return with_white_collar(photo, albedo, parsing)[1][(0, CLOTH, *white)]


def test_a_bright_rim_along_the_jaw_is_no_collar():
    assert float(white_from_the_jaw_down_to(40).max()) == 0


def test_what_starts_at_the_jaw_and_leaves_it_is_a_collar():
    assert float(white_from_the_jaw_down_to(64).min()) > 0.95


def test_a_hint_of_another_tint_makes_no_collar_of_a_neck_at_once():
    """A median of what is bright, beside one limit, would leap from none of it to all."""
    collar = (SKIN_ALBEDO * 1.9).clamp_max(1).expand(3, 4, SIZE).clone()
    collar[:, 1:] = 0.85
    tints = torch.linspace(0, 0.6, 61)
    colours = [collar * torch.exp(tint * torch.tensor([0.5, 0.0, -0.5]))[:, None, None] for tint in tints]
    shares = [float(with_white_collar(*portrait(colour))[1][0, CLOTH].sum()) for colour in colours]
    steps = [abs(after - before) for before, after in zip(shares, shares[1:], strict=False)]
    assert max(shares) - min(shares) > 40
    assert max(steps) < 0.4 * (max(shares) - min(shares))
