"""What is carried on beyond the networks' view."""

from types import SimpleNamespace

import numpy as np
import pytest
import torch

from relight_core.face.crop import Crop
from relight_core.imaging.tone import tone_of
from relight_core.lighting.reflection import ReflectionTable
from relight_core.pipeline.per_light.rest_of_person import (
    Continuation,
    body_gain,
    body_shading,
    body_size,
    make_body,
)
from relight_core.pipeline.per_photo.matte import Matte
from relight_core.pipeline.per_photo.person import Canvas
from relight_core.pipeline.results.channels import ViewChange
from relight_core.pipeline.results.finish import (
    PhotoProperties,
    gain_of_rest,
    mean_gain,
    place_views,
    placed,
    weights_on_views,
)

EVEN = torch.ones(1, 16, 32, 3)


def known_left(size=32):
    weight = np.zeros((size, size + 8), np.float32)
    weight[:, : size // 2] = 0.5
    return weight


def test_a_constant_is_carried_on_unchanged():
    values = np.full((32, 40, 3), (0.3, -1.0, 2.0), np.float32)
    np.testing.assert_allclose(Continuation(known_left())(values), values, atol=1e-5)


def test_what_is_not_known_is_never_read():
    weight = known_left()
    values = np.random.default_rng(0).normal(size=(32, 40, 3)).astype(np.float32)
    other = np.where(weight[..., None] > 0, values, 1e3).astype(np.float32)
    carry = Continuation(weight)
    np.testing.assert_array_equal(carry(values), carry(other))


def test_stays_within_the_range_of_what_is_known_and_follows_the_nearest():
    values = np.zeros((32, 40, 1), np.float32)
    values[:16] = 1.0
    carried = Continuation(known_left())(values)[..., 0]
    assert carried.min() > -1e-5
    assert carried.max() < 1 + 1e-5
    assert carried[2, 18] > 0.8
    assert carried[29, 18] < 0.2


def test_nothing_known_carries_nothing():
    assert Continuation(np.zeros((8, 9), np.float32))(np.ones((8, 9, 3), np.float32)).max() == 0


@pytest.mark.parametrize("size", [(128, 96), (40, 128), (1, 1), (20, 12)])
def test_a_body_that_is_all_seen_gets_the_networks_gain(size):
    photo = np.full((*size, 3), 0.4, np.float32)
    body = make_body(photo, np.ones(size, np.float32), np.ones(size, np.float32), ReflectionTable())
    gain = body_gain(body, EVEN, 1.5 * body.photo)
    assert gain.shape == (*size, 3)
    np.testing.assert_allclose(gain, 1.5, rtol=0.15)


@pytest.mark.parametrize("row", [0, 2, 7])
def test_light_that_reaches_it_by_no_straight_way_counts_by_its_power_not_by_its_height(row):
    """A lamp behind somebody, of mean radiance 1 over the sphere, leaves the same little everywhere."""
    size = (32, 32)
    body = make_body(np.full((*size, 3), 0.4, np.float32), np.ones(size, np.float32), np.zeros(size), ReflectionTable())
    edges = np.cos(np.pi * np.array([row, row + 1]) / 16)
    lamp = torch.zeros(1, 16, 32, 3)
    lamp[0, row, 16] = 64 / float(edges[0] - edges[1])
    gain = body_gain(body, lamp, body.photo)[16, 16]
    np.testing.assert_allclose(gain, 0.15, atol=0.01)


def test_sizes_keep_the_photos_shape():
    assert body_size((6000, 4000)) == (128, 85)
    assert body_size((30, 50)) == (30, 50)


def test_what_is_blown_out_does_not_colour_the_rest():
    size = (64, 48)
    photo = np.full((*size, 3), (0.6, 0.4, 0.2), np.float32)
    photo[:, :12] = 1.0
    known = np.zeros(size, np.float32)
    known[:, :24] = 1.0
    body = make_body(photo, np.ones(size, np.float32), known, ReflectionTable())
    relit = body.photo.copy()
    relit[:, :12, 2] *= 4
    np.testing.assert_allclose(body_gain(body, EVEN, relit)[:, 24:], 1.0, rtol=0.15)


def half_seen_body():
    """A body with the photo's left third in a view."""
    size = (64, 48)
    across = np.abs(np.arange(48) - 24.0)
    share = np.tile((across < 18).astype(np.float32), (64, 1))
    known = np.tile((np.arange(48) < 16).astype(np.float32), (64, 1))
    photo = np.random.default_rng(0).uniform(0.1, 0.8, (*size, 3)).astype(np.float32)
    return make_body(photo, share, known, ReflectionTable())


def test_beside_light_and_shadow_the_rest_gets_what_both_give_together():
    """Their gains are 4 and 1/16: 2 together, and a half by the mean of logs, which stays far from all that is seen."""
    size, stripes = (64, 48), np.where(np.arange(64) % 2 == 0, 4.0, 0.0625)[:, None, None]

    def gain_beside(known):
        body = make_body(np.full((*size, 3), 0.3, np.float32), np.ones(size, np.float32), known, ReflectionTable())
        return body_gain(body, EVEN, (body.photo * stripes).astype(np.float32))

    half, corner = np.zeros((2, *size), np.float32)
    half[:, :24] = 1
    corner[:4, :4] = 1
    assert gain_beside(half)[:, 30:].mean() == pytest.approx(2.0, rel=0.15)
    assert gain_beside(corner)[50:].mean() == pytest.approx(0.5, rel=0.15)


def lamp_from(column):
    light = torch.full((1, 16, 32, 3), 0.2)
    light[:, 6, column] = 100.0
    return light


def test_under_the_light_of_the_photo_the_rest_stays_as_it_is():
    body = half_seen_body()
    gain = body_gain(body, lamp_from(8), body.photo, body_shading(body, lamp_from(8)))
    np.testing.assert_allclose(gain, 1.0, rtol=0.02)


def test_a_lamp_from_the_other_side_lights_what_the_photos_lamp_left_dark():
    body, row = half_seen_body(), 32
    left, right = (body_shading(body, lamp_from(column)) for column in (8, 24))
    assert (left[row, 10] - right[row, 10]).mean() * (left[row, 37] - right[row, 37]).mean() < 0
    changed = body_gain(body, lamp_from(24), body.photo, left)[row].mean(-1)
    unaware = body_gain(body, lamp_from(24), body.photo)[row].mean(-1)
    assert np.log(changed[37] / changed[10]) == pytest.approx(2 * np.log(unaware[37] / unaware[10]), rel=0.2)


def test_a_relit_photo_below_black_counts_as_black():
    share = np.ones((32, 32), np.float32)
    photo = np.full((32, 32, 3), 0.3, np.float32)
    body = make_body(photo, share, share, ReflectionTable())
    relit = np.full((*body.photo.shape[:2], 3), 0.2, np.float32)
    relit[4:8] = -0.5
    black = relit.clip(0.0)
    gain = body_gain(body, EVEN, relit)
    assert np.isfinite(gain).all()
    np.testing.assert_array_equal(gain, body_gain(body, EVEN, black))


def test_a_body_in_the_dark_keeps_the_colour_of_its_light_at_the_largest_gain():
    size = (40, 40)
    photo = np.full((*size, 3), 0.002, np.float32)
    body = make_body(photo, np.ones(size, np.float32), np.ones(size, np.float32), ReflectionTable())
    gain = body_gain(body, EVEN, np.float32([60, 30, 15]) * (body.photo + 1e-3))
    assert gain.max() == pytest.approx(16, rel=0.01)
    np.testing.assert_allclose(gain[20, 20] / gain[20, 20, 0], [1, 0.5, 0.25], rtol=0.05)


def share_of(rows, columns, size=64):
    """A person who fills some rows and columns of a photo, and nobody else."""
    share = np.zeros((size, size), np.float32)
    share[rows, columns] = 1
    return share


def light_from(row, column):
    """A lamp in one texel, of mean luminance 1."""
    light = torch.zeros(1, 16, 32, 3)
    edges = np.cos(np.pi * np.array([row, row + 1]) / 16)
    light[0, row, column] = 64 / float(edges[0] - edges[1])
    return light


def shading(share, light):
    photo = np.full((*share.shape, 3), 0.4, np.float32)
    return body_shading(make_body(photo, share, np.zeros_like(share), ReflectionTable()), light)[..., 0]


def test_whom_a_frame_cuts_off_is_lit_as_whom_the_border_cuts_off():
    y, x = np.mgrid[:128, :128]
    share = ((np.abs(x - 64) < 40) & (y > 50)).astype(np.float32)
    framed = np.where(y < 96, share, 0)
    photo = np.full((128, 128, 3), 0.4, np.float32)
    inside = slice(0, 96), slice(0, 128)
    overhead = light_from(3, 0)
    bodies = [
        make_body(photo, seen, np.zeros_like(share), ReflectionTable(), within)
        for seen, within in ((share, None), (framed, inside), (framed, None))
    ]
    cut_by_border, cut_by_frame, ended = (body_shading(body, overhead)[80:92, 50:78, 0] for body in bodies)
    np.testing.assert_allclose(cut_by_frame, cut_by_border, rtol=0.05)
    assert ended.mean() < 0.8 * cut_by_border.mean()


def test_a_lamp_lights_the_side_of_a_body_that_it_is_on():
    share = share_of(slice(16, 48), slice(16, 48))
    above = shading(share, light_from(2, 0))
    assert above[20, 32] > 1.5 * above[44, 32]
    right = shading(share, light_from(7, 24))
    assert right[32, 44] > 1.5 * right[32, 20]


def test_a_body_that_the_photo_cuts_off_does_not_turn_away_at_its_border():
    whole, cut = (share_of(slice(16, end), slice(16, 48)) for end in (48, 64))
    below = light_from(12, 0)
    assert shading(whole, below)[47, 32] > 1.5 * shading(whole, below)[32, 32]
    assert shading(cut, below)[63, 32] < 1.1 * shading(cut, below)[40, 32]


def test_gloss_on_red_cloth_turns_no_white_cloth_beside_it_green():
    """The red cloth has next to no green of its own, so what gloss adds there is many times what it was."""
    size = (64, 48)
    photo = np.full((*size, 3), (0.6, 0.4, 0.3), np.float32)
    photo[32:, :24] = (0.45, 0.0004, 0.04)
    photo[:, 24:] = (0.5, 0.5, 0.5)
    known = np.zeros(size, np.float32)
    known[:, :24] = 1.0
    body = make_body(photo, np.ones(size, np.float32), known, ReflectionTable())
    gain = body_gain(body, EVEN, 1.5 * body.photo + 0.01)[36:, 28:]
    assert gain[..., 1].max() < 1.15 * gain[..., 0].max()
    np.testing.assert_allclose(gain, 1.5, rtol=0.2)


def test_what_a_photo_shows_too_darkly_colours_the_rest_no_more_than_what_is_blown_out():
    """Next to black, codes and noise make any colour of a gain."""
    size = (64, 48)
    photo = np.full((*size, 3), 0.4, np.float32)
    photo[:, 12:24] = 0.002
    known = np.zeros(size, np.float32)
    known[:, :24] = 1.0
    body = make_body(photo, np.ones(size, np.float32), known, ReflectionTable())
    relit = 1.5 * body.photo
    relit[:, 12:24] *= np.float32((3.0, 1.0, 0.5))
    gain = body_gain(body, EVEN, relit)[20:44, 32:46]
    np.testing.assert_allclose(gain / gain[..., 1:2], 1.0, rtol=0.1)


def test_what_a_view_did_where_it_hardly_counts_is_not_carried_on():
    """A neighbour's view counts a little on somebody's shirt, which it took for a bright wall behind its own person."""
    size = (64, 48)
    known = np.zeros(size, np.float32)
    known[:, :16] = 1.0
    known[:, 16:22] = 0.15
    photo = np.full((*size, 3), 0.4, np.float32)
    body = make_body(photo, np.ones(size, np.float32), known, ReflectionTable())
    relit = 1.5 * body.photo
    relit[:, 16:22] = 6 * body.photo[:, 16:22]
    np.testing.assert_allclose(body_gain(body, EVEN, relit)[:, 16:], 1.5, rtol=0.15)


@pytest.mark.parametrize(("albedo", "least", "most"), [(0.6, 1.3, 1.9), (0.1, 3.0, 4.5)])
def test_the_rest_gives_back_no_more_light_than_falls_on_it(albedo, least, most):
    """The view has its lower half brightened fourfold: too much for red cloth below that was bright already."""
    size = (64, 48)
    known = np.zeros(size, np.float32)
    known[:32] = 1.0
    photo = np.full((*size, 3), (albedo, 0.1, 0.1), np.float32)
    photo[:32] = 0.2
    body = make_body(photo, np.ones(size, np.float32), known, ReflectionTable())
    relit = body.photo.copy()
    relit[20:32] *= 4
    gain = body_gain(body, EVEN, relit, body_shading(body, EVEN))[36:44]
    assert gain.min() > least
    assert gain.max() < most
    np.testing.assert_allclose(gain / gain[..., :1], 1.0, rtol=0.01)


def test_a_gain_that_is_the_same_everywhere_is_carried_on_to_whatever_is_bright():
    """So it is under the photo's own light, whatever its level."""
    size = (64, 48)
    known = np.zeros(size, np.float32)
    known[:32] = 1.0
    photo = np.full((*size, 3), 0.2, np.float32)
    photo[32:] = 0.9
    body = make_body(photo, np.ones(size, np.float32), known, ReflectionTable())
    in_photo = body_shading(body, EVEN)
    np.testing.assert_allclose(body_gain(body, EVEN, 4 * body.photo, in_photo), 4.0, rtol=0.02)


@pytest.mark.parametrize("exposure", [1.0, 32.0])
def test_by_how_much_a_person_changes_is_a_mean_of_factors_over_the_person_alone(exposure):
    share, gain = np.zeros((8, 8), np.float32), np.full((8, 8, 3), 100.0, np.float32)
    share[:, :4], gain[:, :2], gain[:, 2:4] = 1, 4.0, 1.0
    placement = SimpleNamespace(body=SimpleNamespace(share=share), photo=PhotoProperties(exposure))
    np.testing.assert_allclose(mean_gain(placement, exposure * gain), 2 * exposure, rtol=1e-3)


def rest_of_person(exposure=1.0, level=1.0, tone=None, colour=(0.5, 0.25, 0.15), offset=0.05):
    """The gain of the rest of somebody who fills a photo in some units, below a view that a light dims."""
    linear, whole = np.full((90, 60, 3), colour, np.float32) / np.float32(exposure), np.ones((1, 1), np.float32)
    linear[60:] *= 0.3
    matte = Matte(0 * whole, whole, linear[:1, :1], linear[:1, :1], whole)
    canvas, view, photo = Canvas(linear, None, (90, 60)), Crop(30.0, 25.0, 50.0), PhotoProperties(exposure, tone)
    placement = place_views(canvas, [view], matte, ReflectionTable(), photo=photo)
    maps = (np.full((16, 16, 3), value * level, np.float32) for value in (0.5 * exposure, offset))
    return gain_of_rest(placement, [ViewChange(*maps, level)], EVEN)


def test_the_one_view_of_a_photo_goes_over_into_the_rest_at_its_edge_and_is_as_it_was_made_in_its_middle():
    linear, whole = np.full((90, 60, 3), 0.3, np.float32), np.ones((1, 1), np.float32)
    matte = Matte(0 * whole, whole, linear[:1, :1], linear[:1, :1], whole)
    placement = place_views(Canvas(linear, None, (90, 60)), [Crop(30.0, 40.0, 30.0)], matte, ReflectionTable())
    change = ViewChange(*(np.full((64, 64, 3), value, np.float32) for value in (2.0, 0.1)), 1.0)
    rest = np.full((9, 6, 3), 0.5, np.float32)
    (seen,) = placed(placement, weights_on_views(placement, 64), [change], rest)
    for maps, middle, around in ((seen.gain, 2.0, 0.5), (seen.offset, 0.1, 0.0)):
        np.testing.assert_allclose(maps[16:48, 16:48], middle, rtol=1e-5)
        for edge in (maps[0], maps[-1], maps[:, 0], maps[:, -1]):
            np.testing.assert_allclose(edge, around, atol=0.05 * (middle - around))


PRINT = np.linspace(0, 1, 5000, dtype=np.float32)[:, None] * np.float32([1.3, 0.95, 0.6])


@pytest.mark.parametrize("tone", [None, tone_of(PRINT)], ids=["colours", "toned"])
def test_the_rest_of_a_person_is_relit_alike_in_any_units(tone):
    usual = rest_of_person(tone=tone)
    np.testing.assert_allclose(rest_of_person(exposure=32.0, tone=tone), 32 * usual, rtol=1e-3)
    assert 0.5 < usual.mean() < 0.8


def test_the_rest_of_a_person_is_as_bright_as_the_light():
    np.testing.assert_allclose(rest_of_person(level=8.0), 8 * rest_of_person(), rtol=1e-3)


def test_what_a_light_adds_to_a_face_lights_the_rest_of_the_person_too():
    assert rest_of_person(offset=0.2).mean() > 1.2 * rest_of_person(offset=0.0).mean()


SHARE = np.linspace(0, 1, 5000, dtype=np.float32)[:, None]
SPLIT = SHARE * (np.float32([0.6, 0.95, 1.6]) * (1 - SHARE) + np.float32([1.25, 1.0, 0.6]) * SHARE)
"""Blue where it is dark, and yellow where it is bright."""


@pytest.mark.parametrize("level", [0.5, 1.0, 2.5])
def test_the_rest_of_a_person_in_a_toned_photo_has_the_tone_of_what_it_is_lit_to(level):
    tone, colour = tone_of(SPLIT), SPLIT[2000]
    gain = rest_of_person(level=level, tone=tone, colour=colour)
    lit = (gain * colour)[: len(gain) // 2].mean((0, 1))
    expected = tone.at(lit @ np.float32([0.2126, 0.7152, 0.0722]))
    assert lit[0] / lit[2] == pytest.approx(expected[0] / expected[2], rel=0.05)
