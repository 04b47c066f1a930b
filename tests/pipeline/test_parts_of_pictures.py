"""Single pixels, thinned and tiny copies of a relit picture, and eyes in them."""

from dataclasses import replace

import numpy as np
import pytest

from relight_core.face.crop import Crop
from relight_core.face.paste import Band
from relight_core.imaging.black_level import Black
from relight_core.pipeline.per_photo.matte import Matte
from relight_core.pipeline.per_photo.person import Canvas, Person, whole_person
from relight_core.pipeline.results.backdrop import Backdrop
from relight_core.pipeline.results.picture import Picture, PlacedCatchlight, PlacedChange

SIZE = 45, 33


def some_picture(backdrop):
    """Random pixels and maps; a face takes a part of the picture."""
    rng = np.random.default_rng(0)
    maps = [rng.random((8, 8, 3)).astype(np.float32) for _ in range(3)]
    level = rng.uniform(-0.5, 1.5, (9, 7)).astype(np.float32)
    matte = Matte(0 * level, level, *maps[:2], rng.random((5, 4)).astype(np.float32))
    linear = rng.random((*SIZE, 3)).astype(np.float32)
    change = PlacedChange(2 * maps[2], 0.2 * maps[0], Crop(16.0, 20.0, 24.0))
    return Picture(Canvas(linear, None, SIZE), matte, (change,), 2 * maps[1], backdrop)


COLOUR = np.float32([0.1, 0.4, 0.2])
BACKDROPS = {
    "keep": Backdrop(kept=True),
    "match": Backdrop(gain=np.float32([0.2, 1.1, 0.7])),
    "transparent": Backdrop(transparent=True),
    "colour": Backdrop(picture=COLOUR, soft=COLOUR),
}


@pytest.mark.parametrize("backdrop", BACKDROPS)
def test_a_pixel_and_every_third_are_those_of_the_whole_picture_with_their_alpha(backdrop):
    picture = some_picture(BACKDROPS[backdrop])
    image, alpha = picture.render()
    thinned, thinned_alpha = picture.thinned(3)
    np.testing.assert_allclose(thinned, image[::3, ::3], atol=1e-6)
    for row, column in ((0, 0), (44, 32), (20, 16), (9, 30)):
        colour, share = picture.pixel(row, column)
        np.testing.assert_allclose(colour, image[row, column], atol=1e-6)
        assert share == pytest.approx(1.0 if alpha is None else alpha[row, column], abs=1e-6)
    if alpha is None:
        assert thinned_alpha is None
    else:
        assert 0.1 < alpha.mean() < 0.9
        np.testing.assert_allclose(thinned_alpha, alpha[::3, ::3], atol=1e-6)


@pytest.mark.parametrize("place", [(-1, 0), (0, -1), (45, 0), (0, 33)])
def test_a_pixel_beside_the_picture_is_none(place):
    with pytest.raises(IndexError, match=f"row {place[0]}, column {place[1]}"):
        some_picture(BACKDROPS["keep"]).pixel(*place)


@pytest.mark.parametrize("backdrop", BACKDROPS)
def test_drawing_a_picture_leaves_the_photo_as_it_is(backdrop):
    picture = some_picture(BACKDROPS[backdrop])
    picture = replace(picture, catchlights=(PlacedCatchlight(np.full((6, 6, 3), 9, np.float32), Crop(16, 20, 6)),))
    before = [one.copy() for one in (picture.canvas.linear, picture.rest, picture.changes[0].gain)]
    first, second = picture.render()[0], picture.render()[0]
    np.testing.assert_array_equal(first, second)
    after = picture.canvas.linear, picture.rest, picture.changes[0].gain
    assert all(np.array_equal(*pair) for pair in zip(before, after, strict=True))


@pytest.mark.parametrize("backdrop", BACKDROPS)
def test_no_pixel_is_darker_than_black_where_the_person_is_taken_for_brighter_than_the_photo(backdrop):
    picture = some_picture(BACKDROPS[backdrop])
    person = Person(np.full(SIZE, 0.5, np.float32), np.full((*SIZE, 3), 0.9, np.float32))
    change = replace(picture.changes[0], gain=0 * picture.changes[0].gain, offset=0 * picture.changes[0].offset)
    image, _ = replace(picture, person=person, changes=(change,), rest=0 * picture.rest).render()
    assert (picture.canvas.linear < 0.45).any()
    assert image.min() >= 0


def test_a_view_counts_within_itself_and_the_rest_of_the_person_beyond_it():
    picture = some_picture(BACKDROPS["keep"])
    linear, one = picture.canvas.linear, np.ones((8, 8, 3), np.float32)
    change = replace(picture.changes[0], gain=2 * one, offset=0 * one)
    person = Person(np.ones(SIZE, np.float32), linear)
    image, _ = replace(picture, person=person, changes=(change,), rest=0.5 * one).render()
    gain = np.full((*SIZE, 1), 0.5, np.float32)
    gain[8:32, 4:28] = 2.0
    np.testing.assert_allclose(image, gain * linear, rtol=1e-4, atol=1e-6)


def test_an_eye_that_is_less_than_a_pixel_of_a_copy_is_no_fault_and_no_larger_than_that():
    eye = PlacedCatchlight(np.full((40, 40, 3), 5.0, np.float32), Crop(1650.0, 2050.0, 40.0))
    picture = some_picture(BACKDROPS["keep"])
    tiny = replace(picture, canvas=replace(picture.canvas, photo_size=(4500, 3300)))
    lit = replace(tiny, catchlights=(eye,)).render()[0]
    changed = (np.abs(lit - tiny.render()[0]) > 1e-6).any(-1)
    assert np.isfinite(lit).all()
    assert changed.sum() == 1


def with_all_there_is(backdrop):
    """A picture with light over all of it, which some pixels are darker than, and with colours outside Rec.709."""
    picture, rng = some_picture(BACKDROPS[backdrop]), np.random.default_rng(2)
    black = Black(np.float32([0.02, 0.03, 0.05]), 0.5)
    linear = np.where(rng.random((*SIZE, 1)) < 0.3, -0.02, picture.canvas.linear).astype(np.float32)
    beyond = rng.uniform(-0.01, 0.01, (*SIZE, 3)).astype(np.float16)
    return replace(picture, canvas=replace(picture.canvas, linear=linear, beyond=beyond, black=black))


@pytest.mark.parametrize("wide", [False, True])
@pytest.mark.parametrize("backdrop", ["keep", "match", "colour"])
def test_what_is_behind_is_the_picture_of_a_person_without_light_also_under_what_lies_over_it(backdrop, wide):
    lit = replace(with_all_there_is(backdrop), wide=wide)
    unlit = tuple(replace(change, gain=0 * change.gain, offset=0 * change.offset) for change in lit.changes)
    dark = replace(lit, changes=unlit, rest=0 * lit.rest)
    share = whole_person(lit.canvas, lit.matte).share[..., None]
    over_the_person = share * lit.canvas.black.level
    behind = lit.behind(Band(3, 40, SIZE, SIZE))
    np.testing.assert_allclose(behind, (dark.render()[0] - over_the_person)[3:40], atol=1e-5)


@pytest.mark.parametrize("backdrop", BACKDROPS)
def test_colours_outside_rec_709_are_in_the_bands_that_are_asked_for_them_alone(backdrop):
    picture = with_all_there_is(backdrop)
    plain, wide = picture.render()[0], replace(picture, wide=True).render()[0]
    without = replace(picture, canvas=replace(picture.canvas, beyond=None)).render()[0]
    np.testing.assert_array_equal(plain, without)
    assert plain.min() >= 0
    assert np.abs(wide - plain).max() > 1e-3
    for asked, expected in ((False, plain), (True, wide)):
        rows = np.concatenate([part for _, part, _ in picture.in_bands(11, wide=asked)])
        np.testing.assert_allclose(rows, expected, atol=1e-6)


@pytest.mark.parametrize("backdrop", BACKDROPS)
def test_parts_of_a_picture_whose_person_is_kept_are_those_of_any(backdrop):
    picture = with_all_there_is(backdrop)
    kept = replace(picture, person=whole_person(picture.canvas, picture.matte))
    for one, other in zip(kept.part((4, 7, 21, 40)), picture.part((4, 7, 21, 40)), strict=True):
        assert (one is None) == (other is None)
        if one is not None:
            np.testing.assert_allclose(one, other, atol=1e-6)
    np.testing.assert_allclose(kept.pixel(20, 16)[0], picture.render()[0][20, 16], atol=1e-6)


@pytest.mark.parametrize(
    "backdrop", [Backdrop(kept=True), Backdrop(gain=np.ones(3, np.float32))], ids=["keep", "match"]
)
def test_a_person_a_million_times_darker_than_the_photo_keeps_every_shade(backdrop):
    """As in a light that is dim in the photo's units, which may be any in a floating-point file."""
    some = some_picture(backdrop)
    everyone = replace(some.matte, level=np.ones_like(some.matte.level))
    darker = [replace(change, gain=change.gain / 2**20, offset=0 * change.offset) for change in some.changes]
    lit = replace(some, matte=everyone, changes=tuple(darker), rest=some.rest / 2**20)
    image, _ = lit.render()
    expected, _ = replace(lit, backdrop=Backdrop(transparent=True)).render()
    assert 0 < expected.max() < 1e-5
    np.testing.assert_allclose(image, expected, rtol=1e-5)
