"""The shader that draws a relit picture from its recipe, against the picture computed on the CPU."""

from dataclasses import replace

import moderngl
import numpy as np
import pytest
from drawn_recipes import (
    BACKDROPS,
    HEIGHT,
    ONE,
    ONE_CODE,
    SEVERAL,
    SMALL,
    STORED,
    WIDTH,
    drawn,
    some_picture,
    with_eyes,
    worst,
)

from app.ui.pictures import Paint
from app.ui.viewport.view import Placement
from app.window.gl_recipe import RelitSlot
from relight_core.face.crop import Crop
from relight_core.imaging.black_level import Black
from relight_core.pipeline.results.backdrop import Backdrop
from relight_core.pipeline.results.display import fits_a_recipe, person_layers, recipe_of
from relight_core.pipeline.results.picture import PlacedCatchlight, PlacedChange


@pytest.mark.parametrize("views", [ONE, SMALL, SEVERAL], ids=["one", "small", "several"])
@pytest.mark.parametrize("backdrop", BACKDROPS)
def test_the_shader_draws_what_the_cpu_computes(context, backdrop, views):
    assert worst(context, some_picture(BACKDROPS[backdrop], views)) < ONE_CODE


@pytest.mark.parametrize("backdrop", BACKDROPS)
@pytest.mark.parametrize("seed", range(3))
def test_it_does_for_maps_without_any_smoothness(context, backdrop, seed):
    # Texture units weigh neighbours in steps of a 256th, which in the dark is a code where they differ by so much.
    assert worst(context, some_picture(BACKDROPS[backdrop], SEVERAL[:1], seed, hostile=True)) < ONE_CODE + 1.0


@pytest.mark.parametrize("backdrop", ["keep", "light"])
def test_it_does_for_a_leaning_head(context, backdrop):
    # On the CPU a turned map is read in steps of a 32nd of its pixels.
    assert worst(context, some_picture(BACKDROPS[backdrop], (Crop(35.0, 40.0, 50.0, 30.0),))) < ONE_CODE + 1.0


@pytest.mark.parametrize("backdrop", BACKDROPS)
def test_it_does_for_a_photo_with_its_own_alpha(context, backdrop):
    assert worst(context, some_picture(BACKDROPS[backdrop], own_alpha=True)) < ONE_CODE


@pytest.mark.parametrize("own_alpha", [False, True])
@pytest.mark.parametrize("backdrop", BACKDROPS)
def test_it_does_for_a_photo_whose_blacks_are_lifted(context, backdrop, own_alpha):
    picture = some_picture(BACKDROPS[backdrop], own_alpha=own_alpha)
    picture.canvas.linear[30:50:2] = -0.015
    canvas = replace(picture.canvas, black=Black(np.float32([0.02, 0.03, 0.05]), 0.5))
    assert np.abs(replace(picture, canvas=canvas).render()[0] - picture.render()[0]).max() > 0.01
    assert worst(context, replace(picture, canvas=canvas)) < ONE_CODE


@pytest.mark.parametrize("exposure_ev", [-8.0, 3.0])
def test_it_does_at_another_exposure(context, exposure_ev):
    assert worst(context, some_picture(BACKDROPS["keep"]), exposure_ev) < ONE_CODE


@pytest.mark.parametrize("backdrop", BACKDROPS)
@pytest.mark.parametrize("stops", [-10, 20])
def test_it_does_for_a_photo_in_units_of_its_own(context, backdrop, stops):
    picture, units = some_picture(BACKDROPS[backdrop], SEVERAL), np.float32(2.0**stops)
    behind = {part: getattr(picture.backdrop, part) for part in ("picture", "soft")}
    behind = {part: None if layer is None else np.minimum(layer, 0.06) * units for part, layer in behind.items()}
    picture = replace(
        picture,
        canvas=replace(picture.canvas, linear=picture.canvas.linear * units),
        changes=tuple(replace(change, offset=change.offset * units) for change in picture.changes),
        backdrop=replace(picture.backdrop, **behind),
        exposure=1 / units,
    )
    assert worst(context, picture, -stops) < ONE_CODE


@pytest.mark.parametrize("views", [ONE, SEVERAL], ids=["one", "several"])
@pytest.mark.parametrize("backdrop", BACKDROPS)
def test_it_draws_what_eyes_mirror(context, backdrop, views):
    picture = some_picture(BACKDROPS[backdrop], views)
    assert worst(context, with_eyes(picture)) < ONE_CODE
    unlike = np.abs(with_eyes(picture).render()[0] - picture.render()[0]).max(-1) > 1e-3
    assert unlike[30:50].any()
    assert not unlike[:20].any()


def test_it_draws_sixteen_faces_and_all_their_eyes(context):
    places = [(9.0 + 17 * column, 10.0 + 20 * row) for row in range(4) for column in range(4)]
    picture = some_picture(BACKDROPS["keep"], tuple(Crop(*place, 16.0) for place in places))
    added = np.zeros((48, 48, 3), np.float32)
    added[4:-4, 4:-4] = 0.5
    eyes = [Crop(x + beside, y, 6.0) for x, y in places for beside in (-4.0, 4.0)]
    picture = replace(
        picture, catchlights=tuple(PlacedCatchlight(added * (eye % 3), at) for eye, at in enumerate(eyes))
    )
    assert worst(context, picture) < ONE_CODE


def test_maps_of_many_large_eyes_fit_into_one_texture():
    eyes = tuple(PlacedCatchlight(np.ones((384, 384, 3), np.float32), Crop(160.0, 160.0, 320.0)) for _ in range(32))
    picture = replace(some_picture(BACKDROPS["keep"]), catchlights=eyes)
    recipe = recipe_of(picture, person_layers(picture.canvas, picture.matte, picture.exposure))
    assert recipe.catchlights.shape == (32 * 256, 256, 3)
    np.testing.assert_allclose(recipe.catchlights, 1.0)


def test_eyes_whose_maps_overlap_both_mirror(context):
    places = Crop(30.0, 40.0, 6.0), Crop(38.0, 40.0, 6.0)
    eyes = tuple(
        PlacedCatchlight(np.pad(np.full((4, 4, 3), 0.3, np.float32), ((1, 1), (1, 1), (0, 0))), place)
        for place in places
    )
    assert worst(context, replace(some_picture(BACKDROPS["keep"]), catchlights=eyes)) < ONE_CODE


@pytest.mark.parametrize("value", [0.0, 1e30])
def test_it_does_in_darkness_and_under_a_blinding_light(context, value):
    picture = some_picture(BACKDROPS["keep"])
    extreme = np.full((32, 32, 3), value, np.float32)
    # Half floats know no share of a person below 1e-7, however bright.
    matte = replace(picture.matte, level=np.full_like(picture.matte.level, 0.9))
    picture = replace(picture, matte=matte, changes=(PlacedChange(extreme, extreme, ONE[0]),))
    assert worst(context, picture) < ONE_CODE


def test_clipping_stripes_and_differences_see_the_drawn_picture(context):
    picture = some_picture(BACKDROPS["keep"])
    recipe = recipe_of(picture, person_layers(picture.canvas, picture.matte, picture.exposure))
    pixels = picture.render()[0].astype(np.float16)
    for paint in (Paint(clipping=True), Paint(difference=True)):
        from_recipe, from_pixels = (drawn(context, screen, paint=paint) for screen in (recipe, pixels))
        differing = (np.abs(from_recipe - from_pixels) > 2 / 255).any(-1)
        assert differing.mean() < 0.01


def test_scopes_read_the_recipes_own_pixels(context):
    picture = some_picture(BACKDROPS["keep"])
    slot = RelitSlot(context)
    slot.show(recipe_of(picture, person_layers(picture.canvas, picture.matte, picture.exposure)))
    np.testing.assert_array_equal(slot.array, picture.render()[0].astype(np.float16))
    assert slot.array is slot.array
    assert slot.glimpse is slot.glimpse
    np.testing.assert_array_equal(slot.glimpse, slot.array[::2, ::2])
    slot.close()


def test_from_recipe_to_pixels_and_back(context):
    picture = some_picture(BACKDROPS["keep"])
    recipe = recipe_of(picture, person_layers(picture.canvas, picture.matte, picture.exposure))
    slot = RelitSlot(context)
    assert slot.show(recipe)
    assert not slot.show(recipe)
    assert slot.show(np.zeros((9, 7, 3), np.float16))
    assert slot.size == (7, 9)
    assert slot.show(recipe)
    assert slot.size == (WIDTH, HEIGHT)
    assert slot.show(None)
    assert slot.texture is None
    slot.close()


def uploads(monkeypatch):
    """Sizes of the textures that are made from now on, and of those that are filled."""
    made, filled = [], []
    make, fill = moderngl.Context.texture, moderngl.Texture.write

    def noted_make(context, size, *rest, **how):
        made.append(size)
        return make(context, size, *rest, **how)

    def noted_fill(texture, *rest, **how):
        filled.append(texture.size)
        fill(texture, *rest, **how)

    monkeypatch.setattr(moderngl.Context, "texture", noted_make)
    monkeypatch.setattr(moderngl.Texture, "write", noted_fill)
    return made, filled


def test_a_hand_that_takes_hold_and_rests_finds_layers_and_room_for_pixels(context, monkeypatch):
    pictures = [some_picture(BACKDROPS["keep"]) for _ in range(2)]
    layers = person_layers(pictures[0].canvas, pictures[0].matte, pictures[0].exposure)
    moved = [recipe_of(picture, layers) for picture in pictures]
    rested = [np.full((9, 7, 3), level, np.float16) for level in (0.25, 0.5)]
    slot = RelitSlot(context)
    for screen, passing in ((moved[0], True), (rested[0], False)):
        slot.show(screen, passing)
    made, filled = uploads(monkeypatch)
    assert slot.show(moved[1], passing=True)
    assert slot.texture.size == STORED
    assert STORED not in filled
    assert slot.show(rested[1])
    assert (7, 9) not in made
    np.testing.assert_array_equal(np.frombuffer(slot.texture.read(alignment=1), np.float16), 0.5)
    assert slot.array is rested[1]
    slot.close()


@pytest.mark.parametrize("is_closed", [False, True])
def test_pixels_that_no_hand_comes_back_to_are_freed(context, monkeypatch, is_closed):
    picture = some_picture(BACKDROPS["keep"])
    recipe = recipe_of(picture, person_layers(picture.canvas, picture.matte, picture.exposure))
    pixels = np.zeros((9, 7, 3), np.float16)
    slot = RelitSlot(context)
    slot.show(pixels)
    slot.show(recipe, passing=True)
    # At rest the very recipe of the hand may be what is shown; without a photo nothing is.
    assert slot.show(None if is_closed else recipe) is is_closed
    made, filled = uploads(monkeypatch)
    assert slot.show(pixels)
    assert made == filled == [(7, 9)]
    slot.close()


@pytest.mark.parametrize(("faces", "fits"), [(0, False), (16, True), (17, False)])
def test_too_many_faces_make_no_recipe(faces, fits):
    assert fits_a_recipe(some_picture(BACKDROPS["keep"], ONE * faces)) is fits


def test_maps_that_are_longer_one_below_the_other_than_drivers_take_make_no_recipe():
    picture = some_picture(BACKDROPS["keep"])
    for rows, fits in ((4096, True), (4097, False)):
        tall = np.broadcast_to(np.float32(0), (rows, 1, 3))
        assert fits_a_recipe(replace(picture, changes=(PlacedChange(tall, tall, ONE[0]),) * 2)) is fits


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_a_photo_brighter_than_half_floats_hold_is_as_bright_as_they_do(share):
    picture = some_picture(BACKDROPS["keep"])
    canvas = replace(picture.canvas, linear=np.full_like(picture.canvas.linear, 1e6))
    layers = person_layers(canvas, replace(picture.matte, level=np.full_like(picture.matte.level, share)))
    assert layers.person[..., :3].min() == layers.person[..., :3].max() == 65504 * share
    assert layers.behind.min() == layers.behind.max() == 65504 * (1 - share)


def test_a_sun_behind_the_person_is_as_bright_as_half_floats_hold():
    sun = np.full((4, 4, 3), 1e6, np.float32)
    picture = some_picture(Backdrop(picture=sun, soft=sun))
    recipe = recipe_of(picture, person_layers(picture.canvas, picture.matte))
    assert recipe.backdrop.max() == recipe.soft.max() == 65504


@pytest.mark.parametrize("backdrop", ["keep", "match", "colour", "light"])
def test_a_pixel_shown_large_is_one_square_of_its_own_colour(context, backdrop):
    picture = some_picture(BACKDROPS[backdrop], SMALL)
    recipe = recipe_of(picture, person_layers(picture.canvas, picture.matte, picture.exposure))
    once = drawn(context, recipe)
    large = drawn(context, recipe, Placement(0, 0, 6.0, 6 * WIDTH, 6 * HEIGHT))
    assert np.abs(large - once.repeat(6, 0).repeat(6, 1)).max() * 255 < ONE_CODE


def test_checks_are_as_large_as_asked_for(context):
    nothing = np.zeros((HEIGHT, WIDTH, 4), np.float16)
    shown = drawn(context, nothing, paint=Paint(check_px=5.0))[:10, :10, 0]
    assert np.abs(shown - np.kron([[0.32, 0.42], [0.42, 0.32]], np.ones((5, 5)))).max() * 255 < ONE_CODE
