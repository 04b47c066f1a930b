"""What is painted by hand: where it lies, what it changes, and what it leaves alone."""

from dataclasses import fields, replace

import cv2
import numpy as np
import pytest
from tiny_relighter import EDIT, NETWORK_STAGES, computed, some_light, some_photo

from relight_core.errors import InputError
from relight_core.face.crop import Crop
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.lighting.reflection import ReflectionTable
from relight_core.pipeline.face_taken_apart import Workshop
from relight_core.pipeline.per_photo.brush import BrushStroke, checked_strokes, painted
from relight_core.pipeline.per_photo.first_matte import SeenPeople
from relight_core.pipeline.per_photo.matte import DraftMatte, draft_matte, finish_matte
from relight_core.pipeline.per_photo.person import canvas_of, whole_person
from relight_core.pipeline.results.finish import less_where_unseen, place_views, weights_on_views

HEIGHT, WIDTH = 240, 200
CROP = Crop(100.0, 85.0, 130.0)
HAT = (slice(20, 60), slice(150, 190))
OVER_THE_HAT = BrushStroke(((160.0, 40.0), (180.0, 40.0)), 18.0, True)


def covered(strokes, size=(HEIGHT, WIDTH)):
    return painted(np.zeros(size, np.float32), strokes, (HEIGHT, WIDTH))


def test_a_dot_is_a_disc_of_the_brushs_width():
    cover = covered([BrushStroke(((60.0, 80.0),), 20.0, True)])
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH] + 0.5
    distance = np.hypot(x - 60.0, y - 80.0)
    assert cover[distance < 18.5].min() == 1
    assert cover[distance > 21.5].max() == 0


def test_a_stroke_covers_the_same_of_a_photo_at_any_size_of_map():
    stroke = BrushStroke(((20.0, 200.0), (150.0, 30.0), (180.0, 220.0)), 14.0, True)
    whole, half = covered([stroke]), covered([stroke], (HEIGHT // 2, WIDTH // 2))
    shrunk = cv2.resize(whole, (WIDTH // 2, HEIGHT // 2), interpolation=cv2.INTER_AREA)
    assert np.abs(shrunk - half).mean() < 0.015


@pytest.mark.parametrize("width", [2.1, 3.0, 4.5, 7.1, 10.5, 31.0])
@pytest.mark.parametrize("end", [(340.0, 60.0), (300.0, 250.0)])
def test_a_stroke_is_as_wide_as_the_brush(width, end):
    start = (40.0, 60.0)
    cover = painted(np.zeros((320, 400), np.float32), [BrushStroke((start, end), width / 2, True)], (320, 400))
    length = np.hypot(end[0] - start[0], end[1] - start[1])
    assert (cover.sum() - np.pi * width**2 / 4) / length == pytest.approx(width, abs=1.3)


def test_a_dot_of_the_thinnest_brush_is_there():
    cover = painted(np.zeros((100, 100), np.float32), [BrushStroke(((200.0, 220.0),), 2.0, True)], (400, 400))
    assert cover[54:56, 49:51].sum() > 0.8
    assert cover.sum() < 4


def test_of_strokes_that_cross_the_last_counts():
    across, down = ((10.0, 50.0), (90.0, 50.0)), ((50.0, 10.0), (50.0, 90.0))
    for last in (True, False):
        cover = painted(
            np.full((HEIGHT, WIDTH), 0.25, np.float32),
            [BrushStroke(across, 8.0, not last), BrushStroke(down, 8.0, last)],
            (HEIGHT, WIDTH),
        )
        assert cover[50, 50] == last
        assert cover[50, 20] == (not last)
        assert cover[200, 20] == 0.25


@pytest.mark.parametrize(
    "strokes",
    [
        [BrushStroke((), 3.0, True)],
        [BrushStroke(((1.0, float("nan")),), 3.0, True)],
        [BrushStroke(((1.0, 1e7),), 3.0, True)],
        [BrushStroke(((1.0, 1.0),), 0.0, True)],
        [BrushStroke(((1.0, 1.0),), float("inf"), True)],
        [BrushStroke(((1.0, 1.0),) * 257, 3.0, True)],
        [BrushStroke(((1.0, 1.0),), 3.0, True)] * 401,
    ],
)
def test_strokes_that_are_none_are_refused(strokes):
    with pytest.raises(InputError, match="brush"):
        checked_strokes(strokes)


def test_as_many_and_as_long_strokes_as_there_may_be_are_kept_as_they_are():
    strokes = [BrushStroke(((1.0, 1.0),) * 256, 3.0, True)] * 400
    assert checked_strokes(strokes) == tuple(strokes)


def test_a_map_that_is_squeezed_across_has_the_stroke_where_it_is_in_the_photo():
    cover = covered([BrushStroke(((160.0, 40.0),), 20.0, True)], (HEIGHT, WIDTH // 2))
    rows, columns = np.nonzero(cover > 0.5)
    assert rows.mean() + 0.5 == pytest.approx(40.0, abs=1)
    assert columns.mean() + 0.5 == pytest.approx(80.0, abs=1)


def test_the_widest_stroke_from_far_away_to_far_away_can_be_painted():
    ends = ((-1e5, -1e5), (1e5, 1e5))
    assert covered(checked_strokes([BrushStroke(ends, 1e4, True)])).min() == 1


def scene():
    """A head before a wall, a red hat on a peg beside it, and the head's mask."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH] + 0.5
    head = ((np.hypot((x - 100) / 38, (y - 80) / 50) < 1) | ((y > 120) & (np.abs(x - 100) < 40))).astype(np.float32)
    linear = np.where(head[..., None] > 0, (0.5, 0.25, 0.15), (0.05, 0.1, 0.5)).astype(np.float32)
    linear[HAT] = (0.8, 0.05, 0.05)
    return linear, CROP.extract(head, 64)


def matte_after(*strokes, alpha=None):
    linear, mask = scene()
    matte = finish_matte(draft_matte(Photo(linear, alpha), lambda: SeenPeople([[(mask, CROP)]])), strokes)
    return whole_person(canvas_of(Photo(linear, alpha)), matte).share


def test_what_is_painted_joins_the_person_and_its_edge_is_the_photos():
    before, after = matte_after(), matte_after(OVER_THE_HAT)
    assert before[HAT].max() < 0.1
    assert after[25:55, 155:185].min() > 0.95
    assert after[16, 165:175].max() < 0.2, "beyond the hat's edge, where the brush has been not far from"
    np.testing.assert_allclose(after[100:, :130], before[100:, :130], atol=1e-3)


def test_what_is_taken_away_is_no_person():
    before = matte_after()
    after = matte_after(BrushStroke(((70.0, 200.0), (130.0, 200.0)), 15.0, False))
    assert before[190:210, 80:120].min() > 0.95
    assert after[190:210, 80:120].max() < 0.05


@pytest.mark.parametrize("adds", [True, False])
def test_a_thin_stroke_over_something_calm_covers_what_it_was_painted_over(adds):
    size = (128, 1024)
    wall, nobody = np.full((*size, 3), 0.3, np.float32), np.full(size, float(not adds), np.float32)
    stroke = BrushStroke(((300.0, 64.5), (700.0, 64.5)), 4.0, adds)
    matte = finish_matte(DraftMatte(nobody, wall, wall, size), [stroke])
    after = whole_person(canvas_of(Photo(wall)), matte).share
    assert np.abs(after[62:67, 320:680] - adds).max() < 0.05
    assert np.abs(after[:50] - (not adds)).max() < 0.05
    assert np.abs(after[80:] - (not adds)).max() < 0.05


def test_the_photos_own_cut_out_stays():
    alpha = np.full((HEIGHT, WIDTH), 0.5, np.float32)
    np.testing.assert_array_equal(matte_after(OVER_THE_HAT, alpha=alpha), alpha)


def test_no_stroke_changes_anything_of_a_photo_that_is_cut_out(relighter):
    alpha = np.ones((96, 112), np.float32)
    alpha[:30] = 0.0
    cut_out, faces = replace(some_photo(), alpha=alpha), [FaceBox(24, 20, 72, 76)]
    relighter.set_portrait(cut_out, None, faces)
    before = relighter.relight(some_light(), EDIT).image.copy()
    relighter.set_portrait(cut_out, None, faces, [BrushStroke(((90.0, 80.0),), 30.0, True)])
    np.testing.assert_array_equal(relighter.relight(some_light(), EDIT).image, before)


@pytest.mark.parametrize("is_seen", [True, False])
def test_no_view_counts_where_it_took_what_was_added_for_something_behind(is_seen):
    linear, mask = scene()
    view = Crop(100.0, 120.0, 240.0)
    seen = np.zeros((HEIGHT, WIDTH), np.float32)
    seen[70:, 60:140] = 1
    if is_seen:
        seen[HAT] = 1
    matte = finish_matte(draft_matte(Photo(linear), lambda: SeenPeople([[(mask, CROP)]])), [OVER_THE_HAT])
    people = [(view.extract(seen, 128), view)]
    placement = place_views(canvas_of(Photo(linear)), [view], matte, ReflectionTable(), people, [OVER_THE_HAT])
    (weights,) = less_where_unseen(placement, weights_on_views(placement, 120), 120)
    counts = weights.of_views[0][..., 0]
    at_the_hat, at_the_head = counts[20, 85], counts[50, 60]
    assert at_the_head > 0.95
    assert at_the_hat > 0.6 if is_seen else at_the_hat < 0.05


def test_a_stroke_costs_no_network_and_taking_it_back_gives_the_same_picture(relighter, monkeypatch):
    photo, light = some_photo(), some_light()
    relighter.set_portrait(photo, None, [FaceBox(24, 20, 72, 76)])
    before = relighter.relight(light, EDIT).image.copy()
    delighted = []
    monkeypatch.setattr(Workshop, "delight", lambda *_: delighted.append(1))
    relighter.set_portrait(photo, None, [FaceBox(24, 20, 72, 76)], [BrushStroke(((50.0, 50.0),), 200.0, False)])
    nobody = relighter.relight(light, EDIT)
    assert delighted == []
    assert not computed(nobody) & set(NETWORK_STAGES)
    assert "draft_matte" not in computed(nobody)
    np.testing.assert_allclose(nobody.image, photo.linear, atol=2e-3)
    assert np.abs(before - photo.linear).max() > 0.05
    relighter.set_portrait(photo, None, [FaceBox(24, 20, 72, 76)])
    np.testing.assert_array_equal(relighter.relight(light, EDIT).image, before)


def test_found_faces_are_not_looked_for_again_for_a_stroke(relighter, monkeypatch):
    photo = some_photo()
    relighter.set_portrait(photo)
    people, delighted = relighter.people, []
    monkeypatch.setattr(Workshop, "delight", lambda *_: delighted.append(1))
    relighter.set_portrait(photo, None, None, [OVER_THE_HAT])
    assert (relighter.people, delighted) == (people, [])


def test_a_stroke_lights_no_face_of_a_group_again(relighter):
    photo, boxes = some_photo(size=(96, 112)), [FaceBox(6, 16, 50, 72), FaceBox(60, 20, 104, 76)]
    relighter.set_portrait(photo, None, boxes)
    relighter.relight(some_light(), EDIT)
    relighter.set_portrait(photo, None, boxes, [OVER_THE_HAT])
    relit = relighter.relight(some_light(), EDIT)
    assert "matte" in computed(relit)
    assert not computed(relit) & {"sliders", "other_faces", "other_faces_delight", "catchlights", "weights"}


def test_the_outline_follows_the_strokes(relighter):
    photo = some_photo(size=(96, 112))
    everything = BrushStroke(((56.0, 48.0),), 200.0, True)
    nothing, hole = (BrushStroke(((56.0, 48.0),), radius, False) for radius in (200.0, 20.0))

    def lines(*strokes):
        relighter.set_portrait(photo, None, [FaceBox(24, 20, 72, 76)], strokes)
        return relighter.relight(some_light(), EDIT).outline()

    assert lines(nothing) == []
    (around,) = lines(everything)
    np.testing.assert_allclose([around.min(0), around.max(0)], [(0, 0), (112, 96)], atol=1.5)
    radii = [np.hypot(*(line - (56.0, 48.0)).T) for line in lines(everything, hole)]
    assert min(radius.max() for radius in radii) == pytest.approx(20.0, abs=3.0)


def drawn_from(relighter, longest_side_px=None):
    """All maps that a shader draws a picture from."""
    recipe = relighter.relight(some_light(), EDIT, longest_side_px, for_shader=True).recipe
    maps = {one.name: getattr(part, one.name) for part in (recipe, recipe.layers) for one in fields(part)}
    return {name: image for name, image in maps.items() if isinstance(image, np.ndarray)}


def same(one, other):
    return one.keys() == other.keys() and all(np.array_equal(image, other[name]) for name, image in one.items())


def test_what_a_shader_draws_follows_strokes_and_size_as_if_nothing_had_been_shown_before(relighter):
    photo, faces = some_photo(), [FaceBox(24, 20, 72, 76)]
    strokes = [BrushStroke(((50.0, 50.0),), 12.0, False), BrushStroke(((106.0, 90.0),), 12.0, True)]
    relighter.set_portrait(photo, None, faces)
    before = drawn_from(relighter)
    relighter.set_portrait(photo, None, faces, strokes)
    painted_on, smaller = drawn_from(relighter), drawn_from(relighter, 56)
    relighter.set_portrait(replace(photo), None, faces, strokes)
    afresh_smaller = drawn_from(relighter, 56)
    relighter.set_portrait(replace(photo), None, faces, strokes)
    assert not same(before, painted_on)
    assert same(drawn_from(relighter), painted_on)
    assert same(afresh_smaller, smaller)


@pytest.mark.parametrize("background", ["keep", "match", "light", "transparent", "#203040"])
@pytest.mark.parametrize("adds", [True, False])
def test_a_photo_that_is_all_person_or_nobody_is_relit_in_finite_numbers(relighter, adds, background):
    everything = BrushStroke(((56.0, 48.0),), 200.0, adds)
    relighter.set_portrait(some_photo(), None, [FaceBox(24, 20, 72, 76)], [everything])
    relit = relighter.relight(some_light(), replace(EDIT, background=background))
    assert np.isfinite(relit.image).all()
    assert relit.image.min() >= 0
    if relit.alpha is not None:
        assert (relit.alpha == adds).all()
