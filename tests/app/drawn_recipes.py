"""Pictures with recipes that are made up, and what the viewport draws of them."""

from dataclasses import replace

import numpy as np

from app.ui.channels import PHOTO, RESULT
from app.ui.pictures import Paint
from app.ui.viewport.panes import Pane
from app.ui.viewport.view import Frame, Placement
from app.window.gl_recipe import RelitSlot
from app.window.gl_textures import Canvas as Target
from app.window.gl_textures import PictureSlot
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


def drawn(context, screen, place=None, paint=None, exposure_ev=0.0, photo=None):
    """What the viewport shows of a picture, [0, 1]; a difference is taken to `photo`, black where that is None."""
    target = Target(context, smooth=False)
    slots = {PHOTO: PictureSlot(context), RESULT: RelitSlot(context)}
    slots[PHOTO].show(np.zeros((HEIGHT, WIDTH, 3), np.float16) if photo is None else photo)
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
