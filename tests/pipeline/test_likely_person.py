"""What of a photo is likely somebody, by masks of networks and by colours."""

import numpy as np
import pytest

from relight_core.face.crop import Crop
from relight_core.pipeline.per_photo.likely_person import (
    attached,
    likely_person,
    near_views,
    place_faces,
    place_masks,
    without_holes,
    without_lookalikes,
)

CROP = Crop(50.0, 40.0, 60.0)


def photo(person=(0.8, 0.5, 0.4), wall=(0.1, 0.3, 0.7)):
    guide = np.broadcast_to(np.float32(wall), (100, 100, 3)).copy()
    guide[30:, 30:70] = person
    return guide


def placed(mask):
    """One person's mask in the crop, over the photo of 100 by 100 pixels."""
    return place_masks([[(mask, CROP)]], (100, 100), (100, 100))


def mask(value=0.95):
    """What a network says of the crop: its left third and top are wall."""
    found = np.zeros((30, 30), np.float32)
    found[10:, 5:25] = value
    return found


def test_a_body_goes_on_below_the_crop_and_nobody_stands_beside_it():
    likely = likely_person(photo(), placed(mask()))
    assert likely.dtype == np.float32
    assert 0 < likely.min() <= likely.max() < 1
    assert likely[90, 50] > 0.9
    assert likely[50, 50] > 0.9
    assert likely[60, 5] < 0.3
    assert likely[15, 50] < 0.3


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_a_body_goes_on_where_a_lying_head_has_its_chin(quarters):
    upright = placed(mask())[0]
    middle = np.array([CROP.centre_x, CROP.centre_y]) - 50
    for _ in range(quarters):
        middle = np.array([middle[1], -middle[0]])
    lying = Crop(*(middle + 50), CROP.side, 90.0 * quarters)
    turned = place_masks([[(mask(), lying)]], (100, 100), (100, 100))[0]
    assert np.abs(np.rot90(turned, -quarters) - upright).mean() < 0.01


WIDER = Crop(50.0, 50.0, 100.0)


def test_a_wider_look_has_a_say_in_where_a_body_goes_on():
    """Below the crop it bends to the right: nobody would guess that, and the wider look has seen it."""
    seen = np.zeros((100, 100), np.float32)
    seen[30:70, 30:70] = 0.95
    seen[70:, 60:95] = 0.95
    alone = place_masks([[(mask(), CROP)]], (100, 100), (100, 100))[0]
    wider = place_masks([[(mask(), CROP), (seen, WIDER)]], (100, 100), (100, 100))[0]
    assert wider[85, 80] > alone[85, 80] + 0.1
    assert alone[85, 50] > 0.9
    assert wider[85, 50] < 0.5
    np.testing.assert_allclose(wider[40, 45], alone[40, 45], atol=1e-6)


def test_what_a_wider_look_is_not_sure_of_stays_as_guessed():
    """Of a thing that is held before the body it says neither yes nor no."""
    alone, doubtful = (
        place_masks([[(mask(), CROP), *looks]], (100, 100), (100, 100))[0]
        for looks in ([], [(np.full((8, 8), 0.25, np.float32), WIDER)])
    )
    np.testing.assert_allclose(doubtful, alone, atol=1e-6)


def test_beside_a_head_a_wider_look_can_only_leave_open_that_somebody_is_there():
    beside = np.s_[15:50, 90:]
    alone, with_somebody, with_nobody = (
        place_masks([[(mask(), CROP), *looks]], (100, 100), (100, 100))[0][beside]
        for looks in ([], [(np.ones((8, 8)), WIDER)], [(np.zeros((8, 8)), WIDER)])
    )
    assert (with_nobody < 0.5 * alone).all()
    assert (with_somebody > alone).all()
    assert (with_somebody < 0.4).all()


def test_a_wall_that_a_wider_look_takes_for_a_lap_is_known_by_its_colour():
    """It has that of the wall behind the shoulders, and a skirt has one that nothing in the nearest look has."""
    seen, around = mask(), np.full((100, 100), 0.97, np.float32)
    around[:70] = 0.02
    people, guide = [[(seen, CROP), (around, WIDER)]], photo()
    guide[80:, 75:] = (0.1, 0.6, 0.2)
    masks, near = place_masks(people, (100, 100), (100, 100)), near_views(people, (100, 100), (100, 100))
    likely = likely_person(guide, masks, near=near)
    assert likely[85, 15] < 0.3
    assert likely_person(guide, masks)[85, 15] > 0.5
    assert likely[85, 50] > 0.9
    assert likely[85, 85] > 0.8


def test_what_two_looks_take_for_their_own_is_whose_is_nearer():
    """To both the other is a part of the person that is meant, and what lies below neither of them too."""
    left, right = ([(np.full((8, 8), 0.95, np.float32), Crop(x, 40.0, 60.0))] for x in (30.0, 70.0))
    alone = place_masks([left], (100, 100), (100, 100))[0]
    nobody = [(np.zeros((8, 8), np.float32), Crop(50.0, 95.0, 8.0))]
    assert alone[40, 55] > 0.9
    for others in ([right], [nobody, right], [right, nobody]):
        beside = place_masks([left], (100, 100), (100, 100), others)[0]
        assert beside[40, 55] < 0.3
        assert beside[40, 45] > 0.7
        np.testing.assert_allclose(beside[40, 20], alone[40, 20], atol=0.05)


def test_what_nobody_else_claims_stays_with_who_is_meant():
    person, nobody = [(mask(), CROP)], [(np.zeros((8, 8), np.float32), Crop(90.0, 40.0, 60.0))]
    alone, beside = (place_masks([person], (100, 100), (100, 100), others)[0] for others in ([], [nobody]))
    np.testing.assert_allclose(beside[30:60, 40:55], alone[30:60, 40:55], atol=0.02)


def test_what_others_see_from_near_is_not_perhaps_somebody_whose_looks_end_before_it():
    left = [(mask(), Crop(30.0, 40.0, 60.0))]
    right = [(np.zeros((8, 8), np.float32), Crop(75.0, 30.0, 50.0))]
    alone = place_masks([left], (100, 100), (100, 100))[0]
    for people, others in (([left, right], []), ([left], [right])):
        beside = place_masks(people, (100, 100), (100, 100), others)[0]
        assert alone[30, 80] == pytest.approx(0.2)
        assert beside[30, 80] < 0.03
        np.testing.assert_allclose(beside[10:55, 5:45], alone[10:55, 5:45], atol=0.05)
    together = place_masks([left, right], (100, 100), (100, 100))[0]
    assert together[60, 95] == alone[60, 95] == pytest.approx(0.2)


def test_what_is_surely_somebodys_body_stays_theirs_before_whoever_looks_past_it():
    left, child = [(mask(), Crop(30.0, 40.0, 60.0))], [(np.zeros((8, 8), np.float32), Crop(30.0, 85.0, 20.0))]
    alone, together = (place_masks(people, (100, 100), (100, 100))[0] for people in ([left], [left, child]))
    assert together[85, 30] == alone[85, 30] > 0.9


def test_hair_goes_on_above_a_leaning_head_and_not_beside_it():
    """The view of one that leans has its right corner at the side, where a shoulder is, and somebody's wall above."""
    seen = np.zeros((30, 30), np.float32)
    seen[:, 20:] = 0.95
    leaning = place_masks([[(seen, Crop(40.0, 70.0, 40.0, 30.0))]], (100, 100), (100, 100))[0]
    assert leaning[25:45, 65:].max() == pytest.approx(0.2)
    standing = place_masks([[(seen, Crop(40.0, 70.0, 40.0))]], (100, 100), (100, 100))[0]
    assert standing[45, 55] > 0.5


def test_what_lies_in_anybodys_nearest_look_is_near():
    people = [[(mask(), CROP), (mask(), WIDER)], [(mask(), Crop(90.0, 90.0, 20.0))]]
    near = near_views(people, (100, 100), (100, 100))
    assert near[[40, 69, 90], [50, 79, 90]].all()
    assert not near[[75, 40], [50, 10]].any()
    assert not near_views([], (10, 10), (100, 100)).any()


def test_colours_decide_what_the_mask_leaves_open():
    unsure = mask()
    unsure[10:, 15:25] = 0.5
    assert likely_person(photo(), placed(unsure))[45, 62] > 0.8
    wall = photo()
    wall[30:, 52:70] = wall[0, 0]
    assert likely_person(wall, placed(unsure))[45, 62] < 0.2


def test_what_a_mask_surely_has_as_wall_stays_wall_however_much_it_looks_like_the_person():
    alike = photo()
    alike[40:50, 20:28] = alike[60, 50]
    assert 0.02 < likely_person(alike, placed(mask()))[45, 24] < 0.2


def test_in_a_face_colours_have_no_say_against_the_person():
    """A nose of the wall's colour stays; the same colour in a shoulder beside the face is doubted as ever."""
    picture, faces = photo(), np.zeros((30, 30), np.float32)
    faces[10:20, 5:25] = 0.95
    picture[40:50, 60:70] = picture[75:85, 60:70] = picture[0, 0]
    face = place_faces([(faces, CROP)], (100, 100), (100, 100))
    assert face[45, 50] > 0.9
    assert face[75, 50] < 0.1
    assert face[95, 50] == 0
    doubted, known = likely_person(picture, placed(mask())), likely_person(picture, placed(mask()), face)
    assert doubted[45, 65] < 0.8
    assert known[45, 65] > 0.9
    assert max(known[80, 65], doubted[80, 65]) < 0.8
    np.testing.assert_array_equal(likely_person(picture, placed(mask()), 0.5 * face), doubted)


def test_a_mask_of_no_numbers_says_nothing():
    likely = likely_person(photo(), placed(np.full((8, 8), np.nan, np.float32)))
    assert np.isfinite(likely).all()


def test_what_hangs_on_to_nobody_is_taken_out():
    matte = np.zeros((100, 100), np.float32)
    matte[35:, 30:60] = 1.0
    matte[36:40, 60:85] = 0.3
    matte[30:45, 85:97] = 0.9
    matte[5:15, 5:15] = 0.8
    left = attached(matte, placed(mask()))
    assert left[60, 45] == 1.0
    np.testing.assert_allclose(left[35, 90], 0.3, atol=1e-6)
    assert left[10, 10] == 0.0
    assert (left <= matte).all()


def test_where_a_body_is_only_guessed_it_has_to_hang_together_too():
    matte = np.zeros((100, 100), np.float32)
    matte[30:, 30:70] = 1
    matte[85:95, 12:20] = 1
    matte[80:84, 70:90] = 1
    there = placed(mask())
    assert 0.5 < there[0][90, 16] < 0.7
    left = attached(matte, there)
    assert left[90, 16] == 0
    assert left[82, 85] == left[95, 50] == 1


def test_where_no_mask_shows_anybody_the_matte_stays():
    matte = np.full((100, 100), 0.4, np.float32)
    np.testing.assert_array_equal(attached(matte, placed(np.zeros((8, 8)))), matte)


def test_a_gap_within_a_person_is_closed_unless_the_mask_has_it_too():
    matte = np.zeros((100, 100), np.float32)
    matte[30:, 30:70] = 1
    matte[40:44, 40:44] = 0.3
    matte[50:54, 50:54] = 0.3
    looked_through = mask()
    looked_through[19:24, 14:19] = 0.1
    closed = without_holes(matte, placed(looked_through), np.full((100, 100), 0.9, np.float32))
    assert closed[42, 42] > 0.95
    assert closed[52, 52] < 0.35
    np.testing.assert_array_equal(closed[:30], matte[:30])


@pytest.mark.parametrize(("sure", "is_looked_through"), [(0.93, True), (0.985, False)])
def test_a_wall_between_curls_stays_wall_but_a_white_collar_the_persons(sure, is_looked_through):
    """Networks take hair for solid, and are less sure of what lies between curls."""
    guide = photo(person=(0.2, 0.1, 0.1), wall=(0.97, 0.97, 0.95))
    guide[40:50, 40:50] = 0.97, 0.97, 0.95
    found = mask(0.99)
    found[15:20, 10:15] = sure
    there = placed(found)
    likely = likely_person(guide, there)
    matte = np.where(likely < 0.5, likely, 1).astype(np.float32)
    middle = without_holes(matte, there, likely)[43:47, 43:47]
    assert middle.max() < 0.1 if is_looked_through else middle.min() > 0.9


def test_of_gaps_that_the_masks_have_those_of_the_persons_own_colours_are_closed():
    matte = np.zeros((100, 100), np.float32)
    matte[20:, 20:80] = 1
    black, wall, neither = np.s_[30:40, 30:40], np.s_[30:40, 60:70], np.s_[60:70, 45:55]
    picture = np.empty((100, 100, 3), np.float32)
    picture[:] = 0.2, 0.5, 0.8
    picture[20:, 20:80] = 0.03
    picture[wall] = 0.2, 0.5, 0.8
    picture[neither] = 0.9, 0.1, 0.1
    soft, speck = np.s_[80:90, 60:70], np.s_[80:82, 30:32]
    for gap in (black, wall, neither, speck):
        matte[gap] = 0.2
    matte[soft] = 0.8
    closed = without_lookalikes(matte, picture, matte)
    assert closed[soft].min() == 1
    np.testing.assert_array_equal(closed[speck], matte[speck])
    assert closed[black].min() == 1
    np.testing.assert_array_equal(closed[wall], matte[wall])
    np.testing.assert_array_equal(closed[neither], matte[neither])
    assert closed[:20].max() == 0


@pytest.mark.parametrize("quarters", [0, 1, 2, 3])
def test_a_gap_of_the_persons_colours_is_closed_right_beside_the_photo_s_border_too(quarters):
    matte, picture = np.zeros((100, 100), np.float32), np.full((100, 100, 3), 0.8, np.float32)
    matte[:80, 20:80], picture[:80, 20:80] = 1, 0.03
    matte[4:14, 40:50] = 0.2
    matte, picture = np.rot90(matte, quarters).copy(), np.rot90(picture, quarters).copy()
    found = without_lookalikes(matte, picture, matte)
    assert np.rot90(found, -quarters)[4:14, 40:50].min() == 1


def test_a_gap_of_a_black_coat_before_a_black_wall_stays():
    matte = np.zeros((100, 100), np.float32)
    matte[20:, 20:80] = 1
    matte[40:60, 40:60] = 0.1
    np.testing.assert_array_equal(without_lookalikes(matte, np.full((100, 100, 3), 0.03, np.float32), matte), matte)


def test_a_gap_of_colours_that_the_person_has_a_little_more_of_than_the_wall_stays():
    """A third of a shirt is red, and a sixth of the wall."""
    matte, picture = np.zeros((100, 100), np.float32), np.full((100, 100, 3), 0.8, np.float32)
    matte[20:, 20:80] = 1
    picture[20:, 20:80] = 0.03
    picture[:, ::6] = picture[20:, 20:80:3] = 0.9, 0.1, 0.1
    matte[40:60, 40:60] = 0.1
    picture[40:60, 40:60] = 0.9, 0.1, 0.1
    np.testing.assert_array_equal(without_lookalikes(matte, picture, matte), matte)


def test_a_gap_behind_a_thin_soft_rim_is_closed_whole():
    matte = np.zeros((100, 100), np.float32)
    matte[20:, 20:80] = 1
    matte[40:60, 60:80] = 0.1
    matte[40:60, 72:80] = 0.45
    picture = np.full((100, 100, 3), 0.8, np.float32)
    picture[20:, 20:80] = 0.03
    assert without_lookalikes(matte, picture, matte)[42:58, 62:76].min() == 1


@pytest.mark.parametrize(("colour", "is_hair"), [(0.03, True), (0.8, False)])
def test_a_gap_behind_a_strand_that_is_no_longer_there_once_all_is_decided_is_closed(colour, is_hair):
    """Of black hair beside a neck the masks miss most; only the wall's colour in it says that one looks through."""
    undecided = np.zeros((100, 100), np.float32)
    undecided[20:, 20:80] = 1
    undecided[40:60, 60:80] = 0.25
    undecided[44:56, 62:74] = 0.1
    decided = np.where(undecided < 0.5, 0, undecided).astype(np.float32)
    picture = np.full((100, 100, 3), 0.8, np.float32)
    picture[20:, 20:80] = 0.03
    picture[42:58, 61:77] = colour
    np.testing.assert_array_equal(without_lookalikes(decided, picture, decided), decided)
    left = without_lookalikes(decided, picture, undecided)
    assert left[45:55, 63:73].min() == left[45:55, 63:73].max() == is_hair
    assert left[:20].max() == 0


def test_soft_edges_about_a_person_stay_soft_whatever_was_decided():
    undecided = np.zeros((100, 100), np.float32)
    undecided[20:, 20:80] = 1
    undecided[20:, 70:80] = 0.25
    decided = np.where(undecided < 0.5, 0, undecided).astype(np.float32)
    picture = np.full((100, 100, 3), 0.8, np.float32)
    picture[20:, 20:80] = 0.03
    np.testing.assert_array_equal(without_lookalikes(decided, picture, undecided), decided)


def test_a_bay_open_to_the_wall_is_no_gap():
    matte = np.zeros((100, 100), np.float32)
    matte[30:, 30:70] = 1
    matte[40:60, 30:50] = 0
    np.testing.assert_array_equal(without_holes(matte, placed(mask()), np.ones((100, 100), np.float32)), matte)
