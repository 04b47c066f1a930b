"""Strands of hair, and the wall that shows between them."""

import cv2
import numpy as np
import pytest

from relight_core.face.crop import Crop
from relight_core.imaging.colour import srgb_decode
from relight_core.imaging.photo import Photo
from relight_core.pipeline.per_photo.brush import BrushStroke
from relight_core.pipeline.per_photo.first_matte import SeenPeople
from relight_core.pipeline.per_photo.matte import draft_matte, finish_matte
from relight_core.pipeline.per_photo.person import canvas_of, whole_person
from relight_core.pipeline.per_photo.strands import Hair, strands_of

SIZE, HEAD_PX = 400, 400.0
VIEW = Crop(200.0, 200.0, 400.0)
HAIR, SKIN, WHITE, ORANGE = (0.15, 0.1, 0.08), (0.7, 0.5, 0.4), (0.95, 0.95, 0.93), (0.6, 0.35, 0.05)
GAP, STRAND = np.s_[196:204, 296:302], np.s_[175:225, 313:315]


def disc(radius):
    y, x = np.mgrid[:SIZE, :SIZE] + 0.5
    return (np.hypot(x - 200, y - 200) < radius).astype(np.float32)


def scene(hair=HAIR, wall=WHITE):
    """A head of hair around a face before a wall, and the matte of it: a wedge of wall and a strand are not in that."""
    guide = np.float32(wall) * np.ones((SIZE, SIZE, 1), np.float32)
    guide[disc(110) > 0], guide[disc(60) > 0] = hair, SKIN
    guide[180:220, 290:308] = wall
    guide[STRAND] = hair
    return guide, disc(110)


def head(view=VIEW, head_px=HEAD_PX):
    face = disc(60)
    hair = cv2.resize(disc(125) - face, (100, 100), interpolation=cv2.INTER_AREA)
    return Hair(hair, cv2.resize(face, (100, 100), interpolation=cv2.INTER_AREA), view, head_px)


def matte_of(guide, share, heads=None, **within):
    found = strands_of(guide, share, [head()] if heads is None else heads, (SIZE, SIZE), **within)
    return share if found is None else found.put_into(share)


def test_the_wall_between_strands_is_no_hair_and_a_strand_beside_it_is():
    guide, share = scene()
    matte = matte_of(guide, share)
    assert share[GAP].min() == 1
    assert share[STRAND].max() == 0
    assert matte[GAP].max() < 0.1
    assert matte[STRAND][10:-10].min() > 0.9
    np.testing.assert_array_equal(matte[disc(80) > 0], 1)
    np.testing.assert_array_equal(matte[:40], 0)


@pytest.mark.parametrize("glint", [(0.9, 0.95, 1.0), (0.5, 0.6, 0.7)])
def test_a_glint_of_another_colour_than_the_walls_is_hair(glint):
    guide, share = scene(wall=ORANGE)
    guide[GAP] = glint
    guide[180:220, 290:308][guide[180:220, 290:308].sum(-1) == np.sum(np.float32(ORANGE))] = HAIR
    np.testing.assert_array_equal(matte_of(guide, share)[GAP], 1)


def test_single_pale_hairs_within_dark_ones_are_hair():
    guide, share = scene()
    guide[180:220, 290:308] = HAIR
    guide[150:250, 282:300:6] = 0.7
    assert matte_of(guide, share)[160:240, 282:290].min() > 0.95


@pytest.mark.parametrize("glint", [(0.95, 0.87, 0.62), (0.95, 0.84, 0.5)])
def test_a_pale_glint_that_reaches_a_white_wall_is_hair(glint):
    guide, share = scene()
    guide[180:220, 290:308] = glint
    assert matte_of(guide, share)[GAP].min() > 0.95


def test_a_glint_brighter_than_the_wall_is_hair():
    guide, share = scene(wall=(0.5, 0.5, 0.5))
    guide[180:220, 290:308] = 0.9
    np.testing.assert_array_equal(matte_of(guide, share)[GAP], 1)


@pytest.mark.parametrize(("wall", "left", "is_hair"), [(WHITE, 288, 1), (WHITE, 298, 0), ((0.6, 0.6, 0.6), 298, 1)])
def test_what_has_the_walls_colour_with_hair_around_it_is_hair_but_for_a_bright_gap_by_the_outline(wall, left, is_hair):
    guide, share = scene(wall=wall)
    guide[180:220, 290:308] = HAIR
    guide[180:220, left : left + 8] = wall
    np.testing.assert_allclose(matte_of(guide, share)[182:218, left + 1 : left + 4], is_hair, atol=0.15)


def test_what_fair_hair_has_in_shadow_is_no_dark_wall():
    guide, share = scene(hair=(0.8, 0.7, 0.5), wall=(0.1, 0.1, 0.1))
    guide[180:220, 290:308] = 0.12
    np.testing.assert_array_equal(matte_of(guide, share)[share > 0], 1)


def test_where_colours_tell_nothing_the_matte_stays():
    for wall in (HAIR, (0.2, 0.15, 0.1)):
        guide, share = scene(wall=wall)
        np.testing.assert_array_equal(matte_of(guide, share), share)
    noise = np.random.default_rng(0).random((SIZE, SIZE, 3)).astype(np.float32)
    np.testing.assert_array_equal(matte_of(noise, share), share)


def test_skin_of_the_walls_colour_stays_skin():
    guide, share = scene()
    face = Hair(np.zeros((100, 100), np.float32), head().hair, VIEW, HEAD_PX)
    np.testing.assert_array_equal(matte_of(guide, share, [face]), share)


def test_no_strand_is_looked_for_in_a_frame():
    guide, share = scene()
    inside = np.s_[0:212, 0:SIZE]
    matte = matte_of(guide, share, inside=inside)
    assert matte[GAP].max() < 0.1
    np.testing.assert_array_equal(matte[212:], share[212:])


@pytest.mark.parametrize("elsewhere", [Crop(-900.0, 200.0, 400.0), Crop(200.0, 200.0, 40.0, 30.0)])
def test_a_head_that_is_not_seen_or_small_changes_nothing(elsewhere):
    guide, share = scene()
    assert strands_of(guide, share, [head(elsewhere, 40.0)], (SIZE, SIZE)) is None
    assert strands_of(guide, share, [head(Crop(-900.0, 200.0, 400.0))], (SIZE, SIZE)) is None
    assert strands_of(guide, share, [], (SIZE, SIZE)) is None


def test_two_heads_are_both_looked_at():
    guide, share = (np.concatenate([one, one], 1) for one in scene())
    beside = [head(), head(Crop(600.0, 200.0, 400.0))]
    matte = strands_of(guide, share, beside, (SIZE, 2 * SIZE)).put_into(share)
    assert max(matte[GAP].max(), matte[:, SIZE:][GAP].max()) < 0.1


def test_what_is_kept_stays():
    guide, share = scene()
    kept = np.zeros_like(share)
    kept[:, :300] = 1
    matte = strands_of(guide, share, [head()], (SIZE, SIZE)).put_into(share, kept)
    np.testing.assert_array_equal(matte[:, :300], share[:, :300])
    assert matte[196:204, 300:302].max() < 0.1


def test_a_gap_that_is_painted_over_belongs_to_the_person():
    guide, share = scene()
    linear = srgb_decode(guide)
    looks = [(cv2.resize(share, (100, 100), interpolation=cv2.INTER_AREA), VIEW)]
    draft = draft_matte(Photo(linear), lambda: SeenPeople([looks], hair=[head()]))
    painted = BrushStroke(((298.0, 160.0), (298.0, 240.0)), 20.0, True)
    before, after = (
        whole_person(canvas_of(Photo(linear)), finish_matte(draft, strokes)).share for strokes in ([], [painted])
    )
    assert before[GAP].max() < 0.15
    assert after[GAP].min() > 0.9


def test_a_photo_of_any_size_has_the_same_strands_in_a_copy():
    guide, share = scene()
    large = Hair(head().hair, head().others, Crop(800.0, 800.0, 1600.0), 4 * HEAD_PX)
    found = strands_of(guide, share, [large], (4 * SIZE, 4 * SIZE)).put_into(share)
    np.testing.assert_allclose(found, matte_of(guide, share), atol=1e-3)


@pytest.mark.parametrize("order", [1, -1])
def test_a_head_without_hair_takes_nothing_from_another_in_its_view(order):
    guide, share = scene()
    nothing = np.zeros((100, 100), np.float32)
    heads = [head(), Hair(nothing, nothing, VIEW, HEAD_PX)][::order]
    np.testing.assert_array_equal(matte_of(guide, share, heads), matte_of(guide, share))


def test_beyond_the_view_of_a_leaning_head_nothing_is_hair():
    turn = cv2.getRotationMatrix2D((199.5, 199.5), -45, 1)
    guide, share = (cv2.warpAffine(one, turn, (SIZE, SIZE), borderMode=cv2.BORDER_REPLICATE) for one in scene())
    everywhere, nothing = np.ones((100, 100), np.float32), np.zeros((100, 100), np.float32)
    reaching, short = (Hair(everywhere, nothing, Crop(200.0, 200.0, side, 45.0), HEAD_PX) for side in (280.0, 170.0))
    gap = np.s_[268:272, 268:272]
    assert matte_of(guide, share, [reaching])[gap].max() < 0.2
    assert matte_of(guide, share, [short])[gap].min() > 0.95


@pytest.mark.parametrize(
    ("part", "least", "most"), [(0.15, 1.0, 1.0), (0.21, 0.2, 0.6), (0.24, 0.05, 0.25), (0.3, 0.0, 0.05)]
)
def test_a_wall_shows_in_part_where_it_is_not_quite_told_from_hair(part, least, most):
    guide, share = scene(wall=np.float32(HAIR) + part * (np.float32(WHITE) - np.float32(HAIR)))
    assert least <= matte_of(guide, share)[GAP].mean() <= most


def test_hair_so_thin_that_its_colour_is_not_known_leaves_the_matte():
    guide, share = scene(hair=SKIN)
    ring = cv2.resize(disc(112) - disc(107), (100, 100), interpolation=cv2.INTER_AREA)
    thin = Hair(ring, np.zeros_like(ring), VIEW, HEAD_PX)
    np.testing.assert_array_equal(matte_of(guide, share, [thin]), share)


def test_what_is_dark_far_from_the_outline_is_no_strand():
    guide, share = scene()
    guide[175:225, 332:334] = HAIR
    wide = Hair(cv2.resize(disc(160), (100, 100)), np.zeros((100, 100), np.float32), VIEW, HEAD_PX)
    matte = matte_of(guide, share, [wide])
    assert matte[STRAND][10:-10].min() > 0.9
    assert matte[175:225, 330:336].max() == 0


@pytest.mark.parametrize("of_hair", [True, False])
def test_only_hair_is_looked_through_not_an_ear_or_a_collar_beside_it(of_hair):
    guide, share = scene()
    hair, ear = disc(125), np.zeros_like(share)
    ear[165:235, 275:] = 1
    hair = hair if of_hair else hair - hair * ear
    masks = [cv2.resize(one, (100, 100), interpolation=cv2.INTER_AREA) for one in (hair, ear * of_hair)]
    np.testing.assert_array_equal(matte_of(guide, share, [Hair(*masks, VIEW, HEAD_PX)])[GAP], 1)
