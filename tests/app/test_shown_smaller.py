"""A picture that the viewport shows smaller than it is, against averages of the picture."""

from dataclasses import replace

import numpy as np
import pytest
from drawn_recipes import BACKDROPS, HEIGHT, ONE, ONE_CODE, WIDTH, drawn, some_picture, with_eyes

from app.ui.pictures import Paint
from app.ui.viewport.view import Placement
from relight_core.face.crop import Crop
from relight_core.imaging.colour import srgb_decode, srgb_encode
from relight_core.imaging.view_transform import apply_view
from relight_core.pipeline.per_photo.person import Canvas
from relight_core.pipeline.results.display import person_layers, recipe_of
from relight_core.pipeline.results.picture import PlacedCatchlight, PlacedChange


def test_a_picture_shown_smaller_is_an_average(context):
    picture = some_picture(BACKDROPS["keep"])
    recipe = recipe_of(picture, person_layers(picture.canvas, picture.matte, picture.exposure))
    small = Placement(0, 0, 0.25, WIDTH / 4, HEIGHT / 4)
    shown = drawn(context, recipe, small, Paint(supersampled=False))[:20, :17]
    averages = picture.render()[0][:80, :68].reshape(20, 4, 17, 4, 3).mean((1, 3))
    assert np.abs(shown - apply_view(averages, 0.0)).mean() < 1 / 255


@pytest.mark.parametrize("backdrop", ["keep", "transparent", "colour"])
def test_supersampled_a_picture_shown_smaller_is_the_average_of_itself_where_its_light_has_edges(context, backdrop):
    rng = np.random.default_rng(5)
    picture, gain = some_picture(BACKDROPS[backdrop]), np.full((32, 32, 3), 0.1, np.float32)
    gain[:, 9:] = 0.9
    gain[13:, :20] = 0.4
    shadow = PlacedChange(gain, np.zeros((32, 32, 3), np.float32), Crop(32.0, 32.0, 64.0))
    photo = (0.05 + 0.9 * rng.random((64, 64, 3))).astype(np.float32)
    matte = replace(picture.matte, level=rng.random(picture.matte.level.shape).astype(np.float32))
    picture = replace(picture, canvas=Canvas(photo, None, (64, 64)), matte=matte, changes=(shadow,))
    recipe = recipe_of(picture, person_layers(picture.canvas, picture.matte, picture.exposure))
    image, alpha = picture.render()
    cover = np.ones((64, 64, 1), np.float32) if alpha is None else alpha[..., None]
    light, cover = ((one.reshape(32, 2, 32, 2, -1)).mean((1, 3)) for one in (image * cover, cover))
    y, x = np.mgrid[0:32, 0:32] + 0.5
    ground = np.where((np.floor(x / 12) + np.floor(y / 12)) % 2 < 0.5, 0.32, 0.42)[..., None]
    seen = srgb_decode(apply_view(light / np.maximum(cover, 1e-6), 0.0))
    expected = srgb_encode(seen * cover + srgb_decode(ground) * (1 - cover))
    small = Placement(0, 0, 0.5, 32, 32)
    off = {on: np.abs(drawn(context, recipe, small, Paint(supersampled=on)) - expected) * 255 for on in (True, False)}
    assert off[True].max() < 1.5
    assert off[False].max() > 8


@pytest.mark.parametrize("side", [64, 63, 65])
def test_a_catchlight_that_is_taken_out_leaves_no_dots_where_the_picture_is_shown_smaller(context, side):
    picture, added = some_picture(BACKDROPS["keep"]), np.zeros((23, 23, 3), np.float32)
    added[6:9, 7:10] = added[14, 9:12] = -0.85
    linear = np.full((side, side, 3), 0.05, np.float32)
    linear[21:44, 17:40] -= added
    still = PlacedChange(np.ones((32, 32, 3), np.float32), np.zeros((32, 32, 3), np.float32), Crop(32.0, 32.0, 80.0))
    picture = replace(
        picture,
        canvas=Canvas(linear, None, (side, side)),
        matte=replace(picture.matte, level=np.ones_like(picture.matte.level)),
        changes=(still,),
        catchlights=(PlacedCatchlight(added, Crop(28.5, 32.5, 23.0)),),
    )
    recipe = recipe_of(picture, person_layers(picture.canvas, picture.matte, picture.exposure))
    for zoom in (0.5, 0.6, 0.3):
        small = zoom * side
        shown = drawn(context, recipe, Placement(0, 0, zoom, small, small))[: int(small), : int(small)]
        assert np.abs(shown - srgb_encode(np.float32(0.05))).max() * 255 < ONE_CODE


def test_eyes_in_a_picture_shown_smaller_are_averages(context):
    dark = replace(
        some_picture(BACKDROPS["keep"]), changes=(PlacedChange(*np.zeros((2, 32, 32, 3), np.float32), ONE[0]),)
    )
    picture = with_eyes(replace(dark, matte=replace(dark.matte, level=np.ones_like(dark.matte.level))), high=0.9)
    recipe = recipe_of(picture, person_layers(picture.canvas, picture.matte, picture.exposure))
    pixels = picture.render()[0].astype(np.float16)
    small = Placement(0, 0, 0.25, WIDTH / 4, HEIGHT / 4)
    means = [srgb_decode(drawn(context, screen, small)).mean() for screen in (recipe, pixels)]
    assert means[0] == pytest.approx(means[1], rel=0.15)


def test_maps_that_had_to_be_shrunk_are_averaged_the_less(context, monkeypatch):
    monkeypatch.setattr("relight_core.pipeline.results.display.LARGEST_SIDE", 96)
    away = np.hypot(*np.meshgrid(*[np.arange(64) - 31.5] * 2))[..., None]
    added = np.repeat(0.9 * np.exp(-((away / 10) ** 2)), 3, axis=2).astype(np.float32)
    eyes = tuple(PlacedCatchlight(added / 4, Crop(32.0, 32.0, 64.0)) for _ in range(4))
    dark = PlacedChange(*np.zeros((2, 32, 32, 3), np.float32), ONE[0])
    picture = replace(some_picture(BACKDROPS["colour"]), changes=(dark,), catchlights=eyes)
    picture = replace(picture, matte=replace(picture.matte, level=np.ones_like(picture.matte.level)))
    recipe = recipe_of(picture, person_layers(picture.canvas, picture.matte, picture.exposure))
    assert recipe.catchlights.shape == (96, 24, 3)
    shown = drawn(context, recipe, Placement(0, 0, 0.25, WIDTH / 4, HEIGHT / 4), Paint(supersampled=False))[:20, :17]
    averages = picture.render()[0][:80, :68].reshape(20, 4, 17, 4, 3).mean((1, 3))
    assert np.abs(shown - apply_view(averages, 0.0)).max() * 255 < 16


@pytest.mark.parametrize("zoom", [0.25, 0.6, 2.5])
def test_there_is_no_dark_line_around_what_is_cut_out(context, zoom):
    pixels = np.zeros((HEIGHT, WIDTH, 4), np.float16)
    pixels[20:61, 17:50] = *[srgb_decode(np.float32(0.42))] * 3, 1.0
    place = Placement(0, 0, zoom, WIDTH * zoom, HEIGHT * zoom)
    shown = drawn(context, pixels, place)[: int(HEIGHT * zoom), : int(WIDTH * zoom)]
    # As bright as the lighter of the checks behind it, so that no share of it is darker than the darker ones.
    assert shown.min() > 0.32 - ONE_CODE / 255
