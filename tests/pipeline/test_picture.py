"""The finished picture: the same however it is cut, without rims, and honest where nothing is known."""

from dataclasses import replace

import cv2
import drawn_portrait
import numpy as np
import pytest
import torch
from drawn_portrait import CROP, make_matte

from relight_core.errors import InputError
from relight_core.face import paste
from relight_core.face.crop import Crop
from relight_core.face.paste import Band
from relight_core.imaging.photo import Photo
from relight_core.lighting.reflection import ReflectionTable
from relight_core.pipeline.per_photo.matte import Matte
from relight_core.pipeline.per_photo.person import Canvas, canvas_of, whole_person
from relight_core.pipeline.results.backdrop import Backdrop, make_backdrop
from relight_core.pipeline.results.channels import ViewChange
from relight_core.pipeline.results.finish import gain_of_rest, mean_gain, place_changes, place_views, weights_on_views
from relight_core.pipeline.results.picture import Picture, PlacedCatchlight

EVEN = torch.ones(1, 16, 32, 3)


def portrait():
    """A photo of somebody before a bright wall, and the true matte."""
    linear, truth = drawn_portrait.portrait(behind=(0.2, 0.5, 0.9))
    return Photo(linear), truth


def change_of(gain, offset=0.0, size=64):
    maps = [np.full((size, size, 3), value, np.float32) for value in (gain, offset)]
    return ViewChange(*maps, level=1.0)


def picture_of(gain=0.5, backdrop=None, views=(CROP,), photo=None, change=None):
    if photo is None:
        photo, truth = portrait()
    else:
        _, truth = portrait()
    matte = make_matte(photo.linear, [[(view.extract(truth, 64), view)] for view in views], photo.alpha)
    placement = place_views(canvas_of(photo), views, matte, ReflectionTable())
    changes = [change or change_of(gain) for _ in views]
    weights = weights_on_views(placement, changes[0].gain.shape[0])
    rest, placed = place_changes(placement, weights, changes, EVEN)
    return Picture(canvas_of(photo), matte, placed, rest, backdrop or Backdrop(kept=True))


@pytest.mark.parametrize("backdrop", ["keep", "match", "transparent", "#203040"])
@pytest.mark.parametrize("rows", [13, 100])
def test_bands_are_the_picture(backdrop, rows):
    photo, _ = portrait()
    picture = picture_of(backdrop=make_backdrop(backdrop, None, lambda: np.float32([0.5, 0.5, 0.5])), photo=photo)
    image, alpha = picture.render()
    for band, part, share in picture.in_bands(rows):
        np.testing.assert_allclose(part, image[band], atol=1e-5)
        assert (share is None) == (alpha is None)
        if alpha is not None:
            np.testing.assert_allclose(share, alpha[band], atol=1e-6)


def test_views_are_mixed_in_one_room(monkeypatch):
    views = (CROP, replace(CROP, centre_x=CROP.centre_x + 30), replace(CROP, centre_x=CROP.centre_x + 60))
    warp, rooms = cv2.warpAffine, []

    def noted(source, matrix, size, dst=None, **how):
        rooms.append(dst)
        return warp(source, matrix, size, dst, **how)

    monkeypatch.setattr(paste.cv2, "warpAffine", noted)
    picture_of(views=views)
    assert len(rooms) >= 6
    assert all(room is not None and np.shares_memory(room, rooms[0]) for room in rooms)


@pytest.mark.parametrize("backdrop", ["keep", "transparent"])
@pytest.mark.parametrize("longest_side_px", [None, 150])
def test_a_part_is_cut_out_of_the_picture(backdrop, longest_side_px):
    photo, _ = portrait()
    picture = picture_of(backdrop=make_backdrop(backdrop, None, lambda: np.ones(3, np.float32)), photo=photo)
    picture = replace(picture, canvas=canvas_of(photo, longest_side_px))
    whole, whole_alpha = picture.render()
    image, alpha = picture.part((30, 20, 110, 149))
    np.testing.assert_allclose(image, whole[20:149, 30:110], atol=1e-5)
    assert (alpha is None) == (whole_alpha is None)
    if alpha is not None:
        np.testing.assert_allclose(alpha, whole_alpha[20:149, 30:110], atol=1e-6)


def test_a_kept_person_gives_the_same_picture():
    picture = picture_of()
    person = whole_person(picture.canvas, picture.matte)
    kept = Picture(picture.canvas, picture.matte, picture.changes, picture.rest, picture.backdrop, person)
    np.testing.assert_allclose(kept.render()[0], picture.render()[0], atol=1e-6)


def test_a_change_of_nothing_gives_the_photo_back():
    photo, _ = portrait()
    image, _ = picture_of(gain=1.0, photo=photo).render()
    np.testing.assert_allclose(image, photo.linear, atol=0.02)


def test_the_whole_person_changes_and_the_wall_stays():
    photo, truth = portrait()
    image, _ = picture_of(gain=0.5, photo=photo).render()
    ratio = image / np.maximum(photo.linear, 1e-3)
    inner = (np.abs(np.mgrid[0:240, 0:200][1] - 100) < 20) & (np.mgrid[0:240, 0:200][0] > 60)
    np.testing.assert_allclose(ratio[inner & (truth > 0)].mean(), 0.5, atol=0.03)
    assert ratio[225:, 80:120].mean() < 0.65
    np.testing.assert_allclose(image[:20, :40], photo.linear[:20, :40], atol=1e-3)


ALL_AROUND = {"left", "right", "top", "bottom"}


@pytest.mark.parametrize(
    ("view", "fading"), [(Crop(100, 120, 260), set()), (Crop(60, 120, 260), {"right"}), (CROP, ALL_AROUND)]
)
def test_nothing_fades_at_the_photo_s_own_border(view, fading):
    photo, truth = portrait()
    matte = make_matte(photo.linear, [[(view.extract(truth, 64), view)]])
    placement = place_views(canvas_of(photo), (view,), matte, ReflectionTable())
    (weights,) = weights_on_views(placement, 64)
    counts = weights.of_views[0][..., 0]
    ends = {"left": counts[32, 0], "right": counts[32, -1], "top": counts[0, 32], "bottom": counts[-1, 32]}
    assert {end for end, weight in ends.items() if weight < 0.1} == fading
    assert {end for end, weight in ends.items() if weight > 0.999} == ALL_AROUND - fading
    assert (weights.of_rest is None) == (not fading)


def test_a_preview_is_the_picture_shrunk():
    photo, _ = portrait()
    picture = picture_of(photo=photo)
    full, _ = picture.render()
    small = Picture(canvas_of(photo, 120), picture.matte, picture.changes, picture.rest, picture.backdrop)
    image, _ = small.render()
    assert image.shape == (120, 100, 3)
    shrunk = full.reshape(120, 2, 100, 2, 3).mean((1, 3))
    assert np.abs(image - shrunk).mean() < 0.01


def test_no_bright_rim_of_the_old_wall_before_a_dark_background():
    photo, truth = portrait()
    image, _ = picture_of(gain=1.0, backdrop=make_backdrop("#000000", None), photo=photo).render()
    outside = truth == 0
    assert image[outside].mean() < 0.02
    assert (image[outside][:, 2] > 0.45).mean() < 0.01


def test_light_of_the_background_wraps_round_the_edge_only():
    photo, truth = portrait()
    dark, bright = (
        picture_of(gain=1.0, backdrop=make_backdrop(c, None), photo=photo).render()[0] for c in ("#000000", "#ffffff")
    )
    np.testing.assert_allclose(bright[80, 90:110], dark[80, 90:110], atol=0.01)
    assert (bright >= dark - 1e-5).all()


@pytest.mark.parametrize(("cloth", "least", "most"), [(0.004, 0.003, 0.01), (0.4, 0.05, 0.13), (4.0, 0.05, 0.13)])
def test_black_cloth_before_white_paper_has_no_fog_on_it(cloth, least, most):
    photo, truth = portrait()
    photo = Photo(np.where(truth[..., None] > 0, np.float32(cloth), photo.linear))
    dark, bright = (
        picture_of(gain=1.0, backdrop=make_backdrop(c, None), photo=photo).render()[0] for c in ("#000000", "#ffffff")
    )
    edge = whole_person(canvas_of(photo), picture_of(photo=photo).matte).share[200] == 1
    added = (bright - dark)[200, edge]
    assert least < added.max() < most


@pytest.mark.parametrize("units", [0.01, 30.0])
def test_no_more_light_wraps_round_a_photo_in_units_of_its_own(units):
    photo, _ = portrait()
    usual = picture_of(gain=1.0, backdrop=make_backdrop("#ffffff", None), photo=photo)
    canvas, matte, times = usual.canvas, usual.matte, np.float32(units)
    canvas = replace(canvas, linear=canvas.linear * times)
    matte = replace(matte, person=matte.person * times, behind=matte.behind * times, exposure=1 / units)
    band = Band(30, 200, photo.linear.shape[:2], photo.linear.shape[:2])
    there = replace(usual, canvas=canvas, matte=matte, exposure=1 / units).behind(band)
    np.testing.assert_allclose(there, usual.behind(band), atol=1e-4)


@pytest.mark.parametrize("backdrop", ["keep", "match", "#203040"])
@pytest.mark.parametrize("own_alpha", [False, True])
def test_what_is_behind_is_the_picture_of_a_person_without_light(backdrop, own_alpha):
    photo, truth = portrait()
    if own_alpha:
        photo = Photo(photo.linear, np.where(truth > 0, 0.75, 0.25).astype(np.float32))
    scene = make_backdrop(backdrop, None, lambda: np.float32([0.5, 0.6, 0.7]))
    lit = picture_of(gain=2.0, backdrop=scene, photo=photo)
    unlit = tuple(replace(change, gain=0 * change.gain, offset=0 * change.offset) for change in lit.changes)
    dark = replace(lit, changes=unlit, rest=0 * lit.rest)
    band = Band(30, 200, photo.linear.shape[:2], photo.linear.shape[:2])
    np.testing.assert_allclose(lit.behind(band), dark.render()[0][30:200], atol=1e-5)


def test_nothing_is_behind_whom_the_background_was_taken_from():
    picture = picture_of(backdrop=Backdrop(transparent=True))
    assert not picture.behind(Band(0, 240, (240, 200), (240, 200))).any()


def test_a_matched_background_is_dimmed_as_the_person_is():
    photo, _ = portrait()
    picture = picture_of(gain=0.3, photo=photo)
    gain = np.float32([0.3, 0.3, 0.3])
    picture = Picture(
        picture.canvas, picture.matte, picture.changes, picture.rest, make_backdrop("match", None, lambda: gain)
    )
    image, _ = picture.render()
    np.testing.assert_allclose(image[:20, :40], 0.3 * photo.linear[:20, :40], rtol=1e-3)


def test_the_photos_own_alpha_is_the_matte():
    photo, truth = portrait()
    alpha = np.where(truth > 0, 1.0, 0.25).astype(np.float32)
    own = Photo(photo.linear, alpha)
    image, share = picture_of(gain=2.0, backdrop=Backdrop(transparent=True), photo=own).render()
    np.testing.assert_array_equal(share, alpha)
    np.testing.assert_allclose(image[80, 100], 2 * photo.linear[80, 100], rtol=1e-4)


def test_two_views_share_the_photo_by_nearness():
    photo, truth = portrait()
    views = (Crop(60.0, 100.0, 110.0), Crop(140.0, 100.0, 110.0))
    matte = make_matte(photo.linear, [[(view.extract(truth, 64), view)] for view in views])
    placement = place_views(canvas_of(photo), views, matte, ReflectionTable())
    left, right = (weight[..., 0] for weight in placement.small)
    assert (left + right).max() <= 1 + 1e-5
    rows, columns = left.shape
    assert left[int(rows * 100 / 240), int(columns * 60 / 200)] > 0.95
    assert right[int(rows * 100 / 240), int(columns * 140 / 200)] > 0.95


class TestNeighbours:
    """A small view at the left, and a large one at the right that reaches over the left person."""

    views = (Crop(60.0, 100.0, 80.0), Crop(140.0, 100.0, 190.0))

    def weights(self, people):
        photo, truth = portrait()
        matte = make_matte(photo.linear, [[(view.extract(truth, 64), view)] for view in self.views])
        placement = place_views(canvas_of(photo), self.views, matte, ReflectionTable(), people)
        rows, columns = placement.small[0].shape[:2]
        return [lambda x, y, w=w: float(w[int(rows * y / 240), int(columns * x / 200), 0]) for w in placement.small]

    @staticmethod
    def person(low, high):
        """Somebody between two columns of the photo, in a view of all of it."""
        x = np.arange(100) + 0.5
        around = Crop(100.0, 120.0, 400.0)
        at = around.to_photo(np.stack([x, x], axis=-1), 100)[:, 0]
        return np.tile(((at > low) & (at < high)).astype(np.float32), (100, 1)), around

    def test_a_view_says_nothing_of_somebody_else(self):
        left, right = self.weights([self.person(0, 100), self.person(100, 200)])
        assert left(60, 100) > 0.99
        assert right(60, 100) < 0.01
        assert right(75, 170) < 0.01  # below the left view: left to the rest of the person
        assert right(140, 100) > 0.99

    def test_what_is_nobodys_or_both_peoples_is_the_nearer_views(self):
        for people in ((), [self.person(500, 600)] * 2, [self.person(0, 200)] * 2):
            left, right = self.weights(people)
            assert left(60, 100) > 0.9
            assert right(75, 170) > 0.9
            assert right(140, 100) > 0.9


@pytest.mark.parametrize("side", [90.0, 200.0, 1500.0])
@pytest.mark.parametrize("roll_deg", [0.0, 25.0])
def test_a_view_gives_way_to_the_rest_at_its_edge_however_small_it_is(side, roll_deg):
    flat, whole = np.full((341, 512, 3), 0.3, np.float32), np.ones((1, 1), np.float32)
    matte = Matte(0 * whole, whole, flat[:1, :1], flat[:1, :1], whole)
    view = Crop(3008.0, 2003.0, side, roll_deg)
    placement = place_views(Canvas(flat, None, (4000, 6000)), [view], matte, ReflectionTable())
    rest = weights_on_views(placement, 128)[0].of_rest[..., 0]
    assert min(edge.min() for edge in (rest[0], rest[-1], rest[:, 0], rest[:, -1])) > 0.99
    assert rest[64, 64] == 0


def test_darkness_everywhere_makes_the_person_black():
    photo, _ = portrait()
    matte = make_matte(photo.linear, [[(np.ones((8, 8), np.float32), CROP)]])
    placement = place_views(canvas_of(photo), [CROP], matte, ReflectionTable())
    dark = ViewChange(*[np.zeros((64, 64, 3), np.float32)] * 2, level=0.0)
    rest = gain_of_rest(placement, [dark], EVEN)
    assert rest.max() == 0
    assert np.isfinite(mean_gain(placement, rest)).all()


def test_a_turned_view_changes_what_lies_in_it():
    photo, _ = portrait()
    view = Crop(100.0, 85.0, 110.0, 30.0)
    image, _ = picture_of(gain=0.5, views=(view,), photo=photo).render()
    np.testing.assert_allclose(image[70:90, 90:110], 0.5 * photo.linear[70:90, 90:110], rtol=0.05)


def test_unknown_backgrounds_are_refused():
    with pytest.raises(InputError, match="match"):
        make_backdrop("beach", None)


def wide_portrait():
    """The portrait, of which a strip across wall and person lies outside Rec.709."""
    photo, _ = portrait()
    beyond = np.zeros(photo.linear.shape, np.float16)
    beyond[70:90] = (0.25, -0.0625, -0.03125)
    return Photo(photo.linear, beyond=beyond)


@pytest.mark.parametrize("exposure", [0.03, 1.0, 200.0])
def test_a_light_in_the_photo_s_units_leaves_a_matched_background_beside_the_person(exposure):
    for gain in (1.0, exposure):
        made = make_backdrop("match", None, lambda gain=gain: np.full(3, gain, np.float32), exposure)
        np.testing.assert_allclose(made.gain, gain, rtol=1e-6)


@pytest.mark.parametrize(
    ("backdrop", "of_wall"),
    [("keep", 1.0), ("match", 0.5), ("#203040", 0.0)],
)
def test_what_lies_outside_rec709_is_relit_with_its_pixel(backdrop, of_wall):
    photo = wide_portrait()
    made = make_backdrop(backdrop, None, lambda: np.float32([0.5, 0.5, 0.5]))
    picture = picture_of(gain=3.0, backdrop=made, photo=photo, change=change_of(3.0, 0.1))
    within, all_of_it = picture.render()[0], replace(picture, wide=True).render()[0]
    np.testing.assert_allclose((all_of_it - within)[80, 5], of_wall * photo.beyond[80, 5], atol=2e-3)
    np.testing.assert_allclose((all_of_it - within)[80, 100], 3 * photo.beyond[80, 100], rtol=1e-2)
    np.testing.assert_array_equal(all_of_it[:60], within[:60])
    assert within.min() >= 0


def test_a_cut_out_person_keeps_what_lies_outside_rec709():
    photo = wide_portrait()
    picture = picture_of(gain=2.0, backdrop=Backdrop(transparent=True), photo=photo)
    colour, share = replace(picture, wide=True).render()
    assert share[80, 100] == 1
    np.testing.assert_allclose(colour[80, 100], 2 * (photo.linear + photo.beyond)[80, 100], rtol=1e-3)


def test_a_screens_picture_never_leaves_rec709():
    photo = wide_portrait()
    picture = picture_of(photo=photo)
    plain = picture_of(photo=Photo(photo.linear))
    np.testing.assert_array_equal(picture.render()[0], plain.render()[0])


def test_a_background_that_follows_the_person_is_never_dimmed_to_black_nor_blown_out():
    followed = make_backdrop("match", None, lambda: np.array([0.001, 0.7, 50.0]))
    np.testing.assert_allclose(followed.gain, [0.1, 0.7, 2.0], rtol=1e-6)


@pytest.mark.parametrize("exposure", [1e-4, 1e4])
def test_a_matched_background_follows_the_person_in_whatever_units(exposure):
    gain = np.float32([0.5, 0.7, 0.9]) * np.float32(exposure)
    np.testing.assert_allclose(make_backdrop("match", None, lambda: gain, exposure).gain, gain)


def test_catchlights_are_the_same_however_the_picture_is_cut():
    rng = np.random.default_rng(0)
    added = np.pad(rng.random((20, 20, 3)).astype(np.float32), ((4, 4), (4, 4), (0, 0)))
    eyes = (PlacedCatchlight(added, Crop(88.0, 70.0, 28.0)), PlacedCatchlight(-3 * added, Crop(115.0, 70.0, 14.0)))
    picture = replace(picture_of(), catchlights=eyes)
    image, _ = picture.render()
    assert image.min() >= 0
    banded = np.concatenate([part for _, part, _ in picture.in_bands(rows=11)])
    np.testing.assert_allclose(banded, image, atol=1e-6)
    np.testing.assert_allclose(picture.part((80, 60, 121, 90))[0], image[60:90, 80:121], atol=1e-6)
    np.testing.assert_allclose(picture.thinned(3)[0], image[::3, ::3], atol=1e-6)
    np.testing.assert_allclose(picture.pixel(70, 88)[0], image[70, 88], atol=1e-6)
    plain, _ = picture_of().render()
    np.testing.assert_allclose((image - plain)[56:84, 74:102], added * whole_share(picture)[56:84, 74:102], atol=1e-5)


def whole_share(picture):
    return whole_person(picture.canvas, picture.matte).share[..., None]


def test_a_catchlight_in_a_smaller_copy_keeps_its_light():
    added = np.zeros((28, 28, 3), np.float32)
    added[10:13, 15:18] = 5.0
    picture = replace(picture_of(), catchlights=(PlacedCatchlight(added, Crop(100.0, 70.0, 28.0)),))
    matte = picture.matte
    sure = replace(matte, slope=np.zeros_like(matte.slope), level=np.ones_like(matte.level))
    picture = replace(picture, matte=sure)
    small = replace(picture, canvas=canvas_of(portrait()[0], 60))
    light = [(one.render()[0] - replace(one, catchlights=()).render()[0]).mean() for one in (picture, small)]
    assert light[1] == pytest.approx(light[0], rel=0.1)


def test_eyes_beyond_the_photos_border_are_no_fault():
    added = np.ones((28, 28, 3), np.float32)
    places = [Crop(x, y, 28.0) for x, y in ((-5, 90), (199, 90), (100, -10), (100, 245), (-100, 90))]
    picture = replace(picture_of(), catchlights=tuple(PlacedCatchlight(added, place) for place in places))
    assert np.isfinite(picture.render()[0]).all()
