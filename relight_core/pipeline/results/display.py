"""What a viewport needs to draw a picture by itself: textures made once per photo, small maps per light.

A `Picture` is a function of the photo's pixel and of small maps. Here the same maps are laid out for
shaders/recipe.glsl, which evaluates them where the viewport looks; `Picture.render` is its twin on the CPU.

    share * relit + behind,   where   share * relit = gain * (share * colour) + share * (offset + catchlights),

where `share` is the matte (alpha), and over it what lies over all of the photo.

The person's colour is stored premultiplied by the matte, so that everything up to the sum is linear and may be
averaged where the picture is shown smaller than it is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from relight_core.face.crop import Crop
from relight_core.face.paste import Band, bands, unit_matrix
from relight_core.imaging.black_level import Black
from relight_core.imaging.half_floats import LARGEST_HALF
from relight_core.imaging.in_order import in_order
from relight_core.imaging.resampling import resize_area
from relight_core.pipeline.per_photo.matte import Matte
from relight_core.pipeline.per_photo.person import Canvas, person_in
from relight_core.pipeline.results.backdrop import Backdrop
from relight_core.pipeline.results.picture import Picture

MOST_VIEWS = 16
"""Faces that one recipe holds; pictures with more are rendered."""

MOST_EYES = 2 * MOST_VIEWS

EYE_STEP_PX = 16
"""Pixels of the canvas at whose multiples eyes' maps begin and end; beyond averages of so many, one eye's would run
into the next one's."""

LARGEST_SIDE = 8192
"""Pixels; every OpenGL 3.3 driver in use takes textures of this size. Longer pictures are rendered."""


@dataclass(frozen=True, eq=False)
class PersonLayers:
    """A canvas taken apart; no light changes it.

    Attributes:
        person: (h, w, 4) float16 linear, the person's own colour premultiplied by the matte, and the matte.
        behind: (h, w, 3) float16 linear, what the photo holds beside that; below 0 where it is darker than what lies
            over all of it.
        exposure: colours are the photo's times this, so that a photo in units of its own fits into half floats.
    """

    person: np.ndarray
    behind: np.ndarray
    exposure: float


def person_layers(canvas: Canvas, matte: Matte, exposure: float = 1.0) -> PersonLayers:
    """Take a canvas apart.

    Args:
        exposure: of the portrait.
    """
    layers = PersonLayers(np.empty((*canvas.size, 4), np.float16), np.empty((*canvas.size, 3), np.float16), exposure)

    def make(band: Band) -> None:
        found = person_in(canvas, matte, band)
        colour, times = found.colour * found.share[..., None], np.float32(exposure)
        layers.person[band.rows, :, :3] = np.minimum(times * colour, np.float32(LARGEST_HALF))
        layers.person[band.rows, :, 3] = found.share
        behind = times * (canvas.linear[band.rows] - colour)
        layers.behind[band.rows] = np.clip(behind, -np.float32(LARGEST_HALF), np.float32(LARGEST_HALF))

    for _ in in_order(make, bands(canvas.size, canvas.photo_size)):
        pass
    return layers


@dataclass(frozen=True, eq=False)
class DisplayRecipe:
    """A picture as a shader draws it. Maps are bilinear, with their borders continued.

    Attributes:
        layers: the canvas, taken apart; the same object as long as photo and size are.
        views: (2, 3) each: from places in the picture, [0, 1] across and down, to those in a face's view.
        gain, offset: (n S, S, 3) float32, the views' maps one below the other; gains are of the layers' colours.
        rest: (k, l, 3) float32, gain over the whole picture beyond the views.
        behind_gain: (3,) of what the layers have behind the person; None keeps it.
        backdrop: (k, l, 3) float16 linear, what is behind the person instead; or None.
        soft: (k, l, 3) float16, the same blurred; or None.
        nearby: (k, l, 1) float32, the matte averaged about each place; None where the matte itself serves.
        transparent: nothing is behind the person.
        black: what lies over all of the picture.
        eyes: (2, 3) each, as `views`, of the eyes that mirror the light.
        catchlights: (m E, E, 3) float32, what is added in the eyes' views, one below the other, pixels of the canvas
            where averages of both are of the same ones; None where there is none. It is 0 at their borders.
        picture: the same for the CPU.
    """

    layers: PersonLayers
    views: tuple[np.ndarray, ...]
    gain: np.ndarray
    offset: np.ndarray
    rest: np.ndarray
    behind_gain: np.ndarray | None
    backdrop: np.ndarray | None
    soft: np.ndarray | None
    nearby: np.ndarray | None
    transparent: bool
    black: Black
    eyes: tuple[np.ndarray, ...]
    catchlights: np.ndarray | None
    picture: Picture

    @property
    def size(self) -> tuple[int, int]:
        """(height, width) of the canvas."""
        return self.picture.size

    @property
    def dimmed(self) -> bool:
        """Whether the photo's own background is in another light, and then no darker than black."""
        return self.picture.backdrop.gain is not None


def fits_a_recipe(picture: Picture) -> bool:
    """Whether a shader has room for a picture's faces, and a texture for their maps."""
    rows = sum(len(placed.gain) for placed in picture.changes)
    return 0 < len(picture.changes) <= MOST_VIEWS and rows <= LARGEST_SIDE


def recipe_of(picture: Picture, layers: PersonLayers) -> DisplayRecipe:
    """The recipe of a picture that `fits_a_recipe`.

    Args:
        layers: of the picture's canvas and matte.
    """
    backdrop, own_alpha = picture.backdrop, picture.matte.own_alpha
    replaced = backdrop.picture is not None
    eyes, catchlights = _eyes_on_canvas(picture)
    return DisplayRecipe(
        layers=layers,
        views=tuple(_view_matrix(picture, placed.view) for placed in picture.changes),
        gain=_of_layers(_stacked([placed.gain for placed in picture.changes]), layers),
        offset=_stacked([placed.offset for placed in picture.changes]),
        rest=_of_layers(picture.rest, layers),
        behind_gain=_behind_gain(backdrop, layers),
        backdrop=_as_map(backdrop.picture) if replaced else None,
        soft=_as_map(backdrop.soft) if replaced else None,
        nearby=picture.matte.nearby[..., None] if replaced and not own_alpha else None,
        transparent=backdrop.transparent,
        black=Black(np.zeros(3, np.float32)) if picture.canvas.black is None else picture.canvas.black,
        eyes=eyes,
        catchlights=catchlights,
        picture=picture,
    )


def _view_matrix(picture: Picture, view: Crop) -> np.ndarray:
    height, width = picture.size
    return unit_matrix(view, picture.size, picture.canvas.photo_size) * np.array([width, height, 1.0])


def _of_layers(gain: np.ndarray, layers: PersonLayers) -> np.ndarray:
    """A gain of the photo's colours as one of the layers'."""
    return gain if layers.exposure == 1.0 else gain / np.float32(layers.exposure)


def _behind_gain(backdrop: Backdrop, layers: PersonLayers) -> np.ndarray | None:
    if backdrop.gain is None and layers.exposure == 1.0:
        return None
    return _of_layers(np.ones(3, np.float32) if backdrop.gain is None else backdrop.gain, layers)


def _stacked(maps: list[np.ndarray]) -> np.ndarray:
    return maps[0] if len(maps) == 1 else np.concatenate(maps)


def _eyes_on_canvas(picture: Picture) -> tuple[tuple[np.ndarray, ...], np.ndarray | None]:
    """A recipe's `eyes` and `catchlights`.

    A catchlight is taken out by what it is brighter by. Averaged over other pixels than the photo's, that would leave
    black and white dots.
    """
    eyes, (height, width) = picture.catchlights[:MOST_EYES], picture.size
    if not eyes:
        return (), None
    corners, ends = [], []
    for eye in eyes:
        matrix = eye.to_view(picture.canvas.photo_size)
        low = np.array([width, height]) * -matrix[:, 2] / matrix.diagonal()
        corners.append(np.floor(low / EYE_STEP_PX).astype(int) * EYE_STEP_PX)
        ends.append(low + np.array([width, height]) / matrix.diagonal())
    side = math.ceil(np.subtract(ends, corners).max() / EYE_STEP_PX) * EYE_STEP_PX
    maps = np.zeros((len(eyes), side, side, 3), np.float32)
    for eye, (x, y), whole in zip(eyes, corners, maps, strict=True):
        part, added = eye.within(Band(y, y + side, picture.size, picture.canvas.photo_size, (x, x + side)))
        whole[part] = added
    places = tuple(np.array([[width, 0, -x], [0, height, -y]]) / side for x, y in corners)
    return places, _stacked([_fitting(whole, len(eyes)) for whole in maps])


def _fitting(square: np.ndarray, count: int) -> np.ndarray:
    """A square map, no larger than so many of them fit below each other into one texture."""
    size = min(len(square), LARGEST_SIDE // count)
    return square if len(square) == size else resize_area(square, (size, size))


def _as_map(layer: np.ndarray) -> np.ndarray:
    """A picture or a colour as a float16 map."""
    filled = layer if layer.ndim == 3 else layer[None, None]
    return np.minimum(filled, np.float32(LARGEST_HALF)).astype(np.float16)
