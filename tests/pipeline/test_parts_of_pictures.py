"""Single pixels, thinned and tiny copies of a relit picture, and eyes in them."""

from dataclasses import replace

import numpy as np
import pytest

from relight_core.face.crop import Crop
from relight_core.pipeline.per_photo.matte import Matte
from relight_core.pipeline.per_photo.person import Canvas
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


def test_an_eye_that_is_less_than_a_pixel_of_a_copy_is_no_fault_and_no_larger_than_that():
    eye = PlacedCatchlight(np.full((40, 40, 3), 5.0, np.float32), Crop(1600.0, 2000.0, 40.0))
    picture = some_picture(BACKDROPS["keep"])
    tiny = replace(picture, canvas=replace(picture.canvas, photo_size=(4500, 3300)))
    lit = replace(tiny, catchlights=(eye,)).render()[0]
    changed = (np.abs(lit - tiny.render()[0]) > 1e-6).any(-1)
    assert np.isfinite(lit).all()
    assert changed.sum() <= 1
