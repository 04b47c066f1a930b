"""A relit picture on the graphics side: as pixels, or as the maps that a shader makes it from."""

from __future__ import annotations

import math

import moderngl
import numpy as np

from app.window.gl_textures import PictureSlot, TextureSlot
from relight_core.imaging.half_floats import LARGEST_HALF
from relight_core.imaging.scopes import thinning_step
from relight_core.pipeline.results.display import EYE_STEP_PX, MOST_EYES, MOST_VIEWS, DisplayRecipe

MAPS = ("behind", "gain", "offset", "rest", "backdrop", "soft", "nearby", "catchlights")
"""The recipe's textures beside the person, as shaders/recipe.glsl calls them."""

_FIRST_UNIT = 3
"""The units before hold the picture or the person, the photo, and colours."""


class LayerSlot(TextureSlot):
    """A layer of a recipe with averages of the same squares of pixels as in eyes' maps, whatever its size.

    Its sides are multiples of such a square's, for which the layer's border goes on.
    """

    def __init__(self, context: moderngl.Context) -> None:
        super().__init__(context, mipmaps=True)

    def _stored(self, array: np.ndarray) -> np.ndarray:
        down, across = (-side % EYE_STEP_PX for side in array.shape[:2])
        return np.pad(array, ((0, down), (0, across), (0, 0)), "edge") if down or across else array


class RelitSlot:
    """The textures of one relit picture.

    Attributes:
        recipe: what is drawn from; None while there are pixels, or nothing.
    """

    def __init__(self, context: moderngl.Context) -> None:
        self.recipe: DisplayRecipe | None = None
        self._pixels = PictureSlot(context)
        self._person = LayerSlot(context)
        small = {name: TextureSlot(context, mipmaps=name == "catchlights") for name in MAPS[1:]}
        self._maps: dict[str, TextureSlot] = {"behind": LayerSlot(context), **small}
        self._thinned: dict[int, np.ndarray] = {}
        self._crisp = False

    def show(self, screen: np.ndarray | DisplayRecipe | None, passing: bool = False) -> bool:
        """Upload what is not there yet; True if anything changed.

        Between a recipe and pixels, as when a hand takes hold and rests, a recipe's layers stay, which no light
        changes.

        Args:
            passing: a hand is moving something; pixels of the same size may follow, so their texture stays.
        """
        if isinstance(screen, DisplayRecipe):
            return self._show_recipe(screen, passing)
        changed = self.recipe is not None
        if screen is None:
            changed |= self._pixels.array is not None
            self.close()
            return changed
        if changed:
            self._free_maps()
        return self._pixels.show(screen) or changed

    @property
    def texture(self) -> moderngl.Texture | None:
        """The one that has the picture's pixels."""
        return self._person.texture if self.recipe else self._pixels.texture

    @property
    def size(self) -> tuple[int, int] | None:
        """Width and height of the picture; None while there is none."""
        return self.recipe.size[::-1] if self.recipe else self._pixels.size

    @property
    def has_alpha(self) -> bool:
        """Whether the canvas shows through."""
        return self.recipe.transparent if self.recipe else self._pixels.texture.components == 4

    @property
    def array(self) -> np.ndarray | None:
        """(h, w, 3 or 4) float16 linear pixels: all of them, or as many of a recipe's as the scopes read."""
        if self.recipe is None:
            return self._pixels.array
        return self._every(thinning_step(self.recipe.size))

    @property
    def glimpse(self) -> np.ndarray | None:
        """The same of a recipe with half the rows and columns: enough while a hand moves something."""
        return self.array if self.recipe is None else self._every(2 * thinning_step(self.recipe.size))

    def _every(self, step: int) -> np.ndarray:
        if step not in self._thinned:
            image, alpha = self.recipe.picture.thinned(step)
            pixels = image if alpha is None else np.dstack([image, alpha])
            self._thinned[step] = np.minimum(pixels, np.float32(LARGEST_HALF)).astype(np.float16)
        return self._thinned[step]

    def smooth(self, magnified_smoothly: bool) -> None:
        """As of TextureSlot; maps coarser or finer than the picture follow its pixels."""
        self._crisp = not magnified_smoothly
        for slot in (self._person, self._maps["behind"]) if self.recipe else (self._pixels,):
            if slot.texture is not None:
                slot.smooth(magnified_smoothly)

    def switches(self) -> tuple[str, ...]:
        """Which parts of the shader draw it."""
        if self.recipe is None:
            return ()
        over = () if self.recipe.backdrop is None else ("OVER",)
        eyes = () if self.recipe.catchlights is None else ("EYES",)
        return ("RECIPE", *over, *eyes)

    def bind(self, program: moderngl.Program, width_px: float) -> None:
        """Hand textures and numbers to a program compiled with `switches`, for a picture drawn so wide."""
        self.texture.use(0)
        recipe = self.recipe
        if recipe is None:
            return
        for unit, name in enumerate(MAPS, _FIRST_UNIT):
            if name in program and self._maps[name].texture is not None:
                self._maps[name].texture.use(unit)
                program[name].value = unit
        program["to_view"].write(_matrices(recipe.views, MOST_VIEWS))
        program["level"].value = level = max(math.log2(self.size[0] / max(width_px, 1e-3)), 0.0)
        program["size"].value = self.size
        program["crisp"].value = self._crisp
        program["views"].value = len(recipe.views)
        program["transparent"].value = recipe.transparent
        program["black"].value = tuple(map(float, recipe.black.level))
        program["left_by_black"].value = tuple(map(float, recipe.black.left))
        if "dimmed" in program:
            program["dimmed"].value = recipe.dimmed
            gain = (1.0, 1.0, 1.0) if recipe.behind_gain is None else recipe.behind_gain
            program["behind_gain"].value = tuple(map(float, gain))
        if "eyes" in program:
            program["eyes"].value = len(recipe.eyes)
            program["to_eye"].write(_matrices(recipe.eyes, MOST_EYES))
            # Maps of many large eyes have fewer pixels than the canvas.
            halvings = math.log2(recipe.size[1] / recipe.eyes[0][0, 0] / recipe.catchlights.shape[1])
            program["eye_level"].value = max(min(level, math.log2(EYE_STEP_PX)) - halvings, 0.0)
        if "own_alpha" in program:
            program["own_alpha"].value = recipe.nearby is None

    def close(self) -> None:
        """Free everything; the slot can be used again."""
        self._free_maps()
        for slot in (self._person, self._maps["behind"], self._pixels):
            slot.close()

    def _show_recipe(self, recipe: DisplayRecipe, passing: bool) -> bool:
        if passing:
            self._pixels.let_go()
        else:
            self._pixels.close()
        if recipe is self.recipe:
            return False
        self._thinned, self.recipe = {}, recipe
        self._person.show(recipe.layers.person)
        self._maps["behind"].show(recipe.layers.behind)
        for name in MAPS[1:]:
            self._maps[name].show(getattr(recipe, name))
        return True

    def _free_maps(self) -> None:
        """All but the layers."""
        self.recipe, self._thinned = None, {}
        for name in MAPS[1:]:
            self._maps[name].close()


def _matrices(views: tuple[np.ndarray, ...], most: int) -> bytes:
    """(2, 3) each, as an array of that many matrices in a shader."""
    matrices = np.zeros((most, 3, 2), np.float32)
    for matrix, view in zip(matrices, views, strict=False):
        matrix[:] = view.T
    return matrices.tobytes()
