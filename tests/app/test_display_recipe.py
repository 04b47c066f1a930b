"""The shader that draws a relit picture from its recipe, against the picture computed on the CPU."""

from dataclasses import replace

import moderngl
import numpy as np
import pytest

from app.ui.channels import PHOTO, RESULT
from app.ui.pictures import Paint
from app.ui.viewport.panes import Pane
from app.ui.viewport.view import Frame, Placement
from app.window.gl_recipe import RelitSlot
from app.window.gl_textures import Canvas as Target
from app.window.gl_textures import PictureSlot
from app.window.gl_viewport import PicturePainter
from app.window.glfw_window import close_window, open_window
from relight_core.face.crop import Crop
from relight_core.imaging.colour import srgb_decode, srgb_encode
from relight_core.imaging.view_transform import apply_view
from relight_core.pipeline.per_photo.matte import Matte
from relight_core.pipeline.per_photo.person import Canvas
from relight_core.pipeline.results.backdrop import Backdrop
from relight_core.pipeline.results.display import person_layers, recipe_of
from relight_core.pipeline.results.picture import Picture, PlacedCatchlight, PlacedChange

HEIGHT, WIDTH = 83, 71
STORED = (80, 96)
"""Width and height of the textures of such a picture's layers."""
ONE_CODE = 1.0 + 0.5
ONE = (Crop(35.0, 40.0, 120.0),)
SMALL = (Crop(30.0, 45.0, 37.0),)
SEVERAL = (Crop(20.0, 30.0, 40.0), Crop(48.0, 36.0, 44.0), Crop(36.0, 60.0, 30.0))


@pytest.fixture(scope="module")
def context(display):
    """A hidden window's own: a context without a window, made in another way, breaks the windows after it."""
    window = open_window("relight", (64, 64), visible=False)
    context = moderngl.create_context(require=330)
    context.painter = PicturePainter(context, (0.1, 0.1, 0.1))
    yield context
    context.painter.close()
    context.release()
    close_window(window)


def smooth(rng, size, channels, high):
    coarse = rng.random((4, 4, channels)) * high
    rows, columns = (np.linspace(0, 3, n) for n in size)
    low = np.floor(rows).clip(0, 2).astype(int), np.floor(columns).clip(0, 2).astype(int)
    y, x = (rows - low[0])[:, None, None], (columns - low[1])[None, :, None]
    at = [coarse[low[0] + i][:, low[1] + j] for i in (0, 1) for j in (0, 1)]
    mixed = (at[0] * (1 - x) + at[1] * x) * (1 - y) + (at[2] * (1 - x) + at[3] * x) * y
    return mixed.astype(np.float32)


def some_picture(backdrop, views=ONE, seed=0, hostile=False, own_alpha=False):
    """Random pixels and maps; hostile ones jump by orders of magnitude from one to the next."""
    rng = np.random.default_rng(seed)
    linear = (0.05 + 0.9 * rng.random((HEIGHT, WIDTH, 3)) ** 2).astype(np.float32)
    level = smooth(rng, (40, 30), 1, 2.0)[..., 0] - 0.5
    if hostile:
        linear *= rng.choice([0, 1e-4, 1, 60], (HEIGHT, WIDTH, 1)).astype(np.float32)
        level = rng.uniform(-2, 3, (40, 30)).astype(np.float32)
    sides = (rng.random((5, 4, 3)).astype(np.float32) for _ in range(2))
    matte = Matte(np.zeros_like(level), level, *sides, rng.random((9, 7)).astype(np.float32), own_alpha)

    def maps(high):
        if not hostile:
            return smooth(rng, (32, 32), 3, high)
        return (rng.random((32, 32, 3)) * rng.choice([0, 1, 16], (32, 32, 1)) * high).astype(np.float32)

    changes = tuple(PlacedChange(maps(2.0), maps(0.3), view) for view in views)
    alpha = rng.random((HEIGHT, WIDTH)).astype(np.float32) if own_alpha else None
    canvas = Canvas(linear, alpha, (HEIGHT, WIDTH))
    return Picture(canvas, matte, changes, smooth(rng, (13, 11), 3, 2.0), backdrop)


def with_eyes(picture, high=2.0):
    """Two eyes that mirror a lamp, one of them also at the border of a view."""
    eyes = []
    for view in (Crop(22.0, 38.0, 28.0), Crop(52.0, 40.0, 28.0)):
        away = np.hypot(*np.meshgrid(*[np.linspace(-1, 1, 28)] * 2))
        added = high * np.exp(-((away / 0.35) ** 2)) - 0.3 * np.exp(-(((away - 0.3) / 0.2) ** 2))
        eyes.append(PlacedCatchlight((added[..., None] * (1.0, 0.8, 0.5)).astype(np.float32), view))
    return replace(picture, catchlights=tuple(eyes))


def drawn(context, screen, place=None, paint=None, exposure_ev=0.0):
    """What the viewport shows of a picture, [0, 1]."""
    target = Target(context, smooth=False)
    slots = {PHOTO: PictureSlot(context), RESULT: RelitSlot(context)}
    slots[PHOTO].show(np.zeros((HEIGHT, WIDTH, 3), np.float16))
    slots[RESULT].show(screen)
    place = place or Placement(0, 0, 1.0, WIDTH, HEIGHT)
    target.fit((round(place.width), round(place.height)))
    pane = Pane(RESULT, Frame(0, 0, WIDTH, HEIGHT), place, 0, round(place.width))
    context.painter.panes(target, [pane], slots, paint or Paint(), exposure_ev)
    pixels = target.pixels() / 255
    for slot in slots.values():
        slot.close()
    return pixels


def worst(context, picture, exposure_ev=0.0):
    """The largest difference in codes of 255; half a code of it is the canvas's 8 bits."""
    recipe = recipe_of(picture, person_layers(picture.canvas, picture.matte, picture.exposure))
    image, alpha = picture.render()
    expected = apply_view(image, exposure_ev)
    if alpha is not None:
        y, x = np.mgrid[0:HEIGHT, 0:WIDTH] + 0.5
        checks = np.where((np.floor(x / 12) + np.floor(y / 12)) % 2 < 0.5, 0.32, 0.42)[..., None]
        ground = srgb_decode(checks)
        expected = srgb_encode(ground + (srgb_decode(expected) - ground) * alpha[..., None])
    return np.abs(drawn(context, recipe, exposure_ev=exposure_ev) - expected).max() * 255


BACKDROPS = {
    "keep": Backdrop(kept=True),
    "match": Backdrop(gain=np.float32([0.2, 1.1, 0.7])),
    "transparent": Backdrop(transparent=True),
    "colour": Backdrop(picture=np.float32([0.1, 0.4, 0.2]), soft=np.float32([0.1, 0.4, 0.2])),
    "light": Backdrop(
        picture=np.random.default_rng(1).random((20, 17, 3)).astype(np.float32) * 3,
        soft=np.random.default_rng(2).random((6, 5, 3)).astype(np.float32),
    ),
}


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


@pytest.mark.parametrize("exposure_ev", [-8.0, 3.0])
def test_it_does_at_another_exposure(context, exposure_ev):
    assert worst(context, some_picture(BACKDROPS["keep"]), exposure_ev) < ONE_CODE


@pytest.mark.parametrize("backdrop", BACKDROPS)
@pytest.mark.parametrize("stops", [-10, 20])
def test_it_does_for_a_photo_in_units_of_its_own(context, backdrop, stops):
    picture, units = some_picture(BACKDROPS[backdrop]), np.float32(2.0**stops)
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


def test_eyes_whose_maps_overlap_both_mirror(context):
    places = Crop(30.0, 40.0, 6.0), Crop(38.0, 40.0, 6.0)
    eyes = tuple(
        PlacedCatchlight(np.pad(np.full((4, 4, 3), 0.3, np.float32), ((1, 1), (1, 1), (0, 0))), place)
        for place in places
    )
    assert worst(context, replace(some_picture(BACKDROPS["keep"]), catchlights=eyes)) < ONE_CODE


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


def test_a_picture_shown_smaller_is_an_average(context):
    picture = some_picture(BACKDROPS["keep"])
    recipe = recipe_of(picture, person_layers(picture.canvas, picture.matte, picture.exposure))
    small = Placement(0, 0, 0.25, WIDTH / 4, HEIGHT / 4)
    shown = drawn(context, recipe, small, Paint(fine=False))[:20, :17]
    averages = picture.render()[0][:80, :68].reshape(20, 4, 17, 4, 3).mean((1, 3))
    assert np.abs(shown - apply_view(averages, 0.0)).mean() < 1 / 255


@pytest.mark.parametrize("backdrop", ["keep", "transparent", "colour"])
def test_drawn_finely_a_picture_shown_smaller_is_the_average_of_itself_where_its_light_has_edges(context, backdrop):
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
    off = {fine: np.abs(drawn(context, recipe, small, Paint(fine=fine)) - expected) * 255 for fine in (True, False)}
    assert off[True].max() < 1.5
    assert off[False].max() > 8


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


@pytest.mark.parametrize(("faces", "is_recipe"), [(16, True), (17, False)])
def test_too_many_faces_make_no_recipe(faces, is_recipe):
    picture = some_picture(BACKDROPS["keep"], ONE * faces)
    recipe = recipe_of(picture, person_layers(picture.canvas, picture.matte, picture.exposure))
    assert (recipe is not None) is is_recipe


@pytest.mark.parametrize("backdrop", ["keep", "match", "colour", "light"])
def test_a_pixel_shown_large_is_one_square_of_its_own_colour(context, backdrop):
    picture = some_picture(BACKDROPS[backdrop], SMALL)
    recipe = recipe_of(picture, person_layers(picture.canvas, picture.matte, picture.exposure))
    once = drawn(context, recipe)
    large = drawn(context, recipe, Placement(0, 0, 6.0, 6 * WIDTH, 6 * HEIGHT))
    assert np.abs(large - once.repeat(6, 0).repeat(6, 1)).max() * 255 < ONE_CODE


@pytest.mark.parametrize("zoom", [0.25, 0.6, 2.5])
def test_there_is_no_dark_line_around_what_is_cut_out(context, zoom):
    pixels = np.zeros((HEIGHT, WIDTH, 4), np.float16)
    pixels[20:61, 17:50] = *[srgb_decode(np.float32(0.42))] * 3, 1.0
    place = Placement(0, 0, zoom, WIDTH * zoom, HEIGHT * zoom)
    shown = drawn(context, pixels, place)[: int(HEIGHT * zoom), : int(WIDTH * zoom)]
    # As bright as the lighter of the checks behind it, so that no share of it is darker than the darker ones.
    assert shown.min() > 0.32 - ONE_CODE / 255


def test_checks_are_as_large_as_asked_for(context):
    nothing = np.zeros((HEIGHT, WIDTH, 4), np.float16)
    shown = drawn(context, nothing, paint=Paint(check_px=5.0))[:10, :10, 0]
    assert np.abs(shown - np.kron([[0.32, 0.42], [0.42, 0.32]], np.ones((5, 5)))).max() * 255 < ONE_CODE
