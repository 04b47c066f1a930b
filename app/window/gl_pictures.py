"""What the panels show, as textures: implements app.ui.pictures.Pictures with OpenGL."""

from __future__ import annotations

import moderngl
import numpy as np

from app.engine.light_shelf import LightShelf
from app.engine.snapshot import Snapshot
from app.engine.sources import LightSource
from app.ui.pictures import Shown
from app.ui.state import PHOTO, RESULT
from app.ui.view import Placement
from app.window.gl_textures import Canvas, TextureSlot
from app.window.shader_source import stage_source

THUMBNAIL_SIDE = 160
_CRISP_FROM_ZOOM = 4.0


class GlPictures:
    """Textures of the engine's newest snapshot, the viewport, and the thumbnails.

    Args:
        context: the window's; current whenever a method is called.
        shelf: where the bundled lights' thumbnails come from.
        canvas_srgb: the colour around the picture.
    """

    def __init__(
        self, context: moderngl.Context, shelf: LightShelf, canvas_srgb: tuple[float, float, float]
    ) -> None:
        self.exposure_ev = 0.0
        self._context = context
        self._shelf = shelf
        stages = (stage_source("viewport", stage) for stage in ("VERTEX_STAGE", "FRAGMENT_STAGE"))
        self._program = context.program(*stages)
        self._program["canvas_srgb"].value = canvas_srgb
        self._triangle = context.vertex_array(self._program, [])
        self._radiance = {name: TextureSlot(context, mipmaps=True) for name in (PHOTO, RESULT)}
        self._channels: dict[str, TextureSlot] = {}
        self._balls: dict[tuple[str, str], TextureSlot] = {}
        self._panorama = TextureSlot(context, repeat_x=True)
        self._viewport = Canvas(context)
        self._thumbnails = {name: Canvas(context) for name in (PHOTO, RESULT)}
        self._drawn: dict[str, tuple] = {}
        self._generation = 0

    def update(self, snapshot: Snapshot) -> None:
        """Upload what the snapshot holds that is not there yet."""
        opened, light, picture = snapshot.opened, snapshot.light, snapshot.picture
        if picture is not None and picture.opened is not opened:
            picture = None
        changed = self._radiance[PHOTO].show(opened.screen if opened else None)
        changed |= self._radiance[RESULT].show(picture.screen if picture else None)
        channels = picture.channels if picture else {}
        for name in self._channels.keys() | channels.keys():
            slot = self._channels.setdefault(name, TextureSlot(self._context))
            changed |= slot.show(channels.get(name))
        self._panorama.show(light.panorama if light else None)
        for known in (light, snapshot.own_light):
            if known is not None and known.source.kind != "rig":
                self._ball_slot(known.source).show(known.ball)
        self._generation += changed

    def size(self, name: str) -> tuple[int, int] | None:
        """Width and height of a picture or channel; None while there is none."""
        texture = self._slot(name).texture if self._slot(name) else None
        return texture.size if texture else None

    def thumbnail(self, name: str) -> Shown | None:
        """A picture or channel, small and ready to look at."""
        size = self.size(name)
        if size is None:
            return None
        if name not in self._radiance:
            return _shown(self._slot(name).texture)
        scale = min(1.0, THUMBNAIL_SIDE / max(size))
        small = (max(1, round(size[0] * scale)), max(1, round(size[1] * scale)))
        canvas = self._thumbnails[name]
        self._draw(f"thumbnail {name}", canvas, name, Placement(0, 0, scale, *small), small)
        return _shown(canvas.texture)

    def viewport(self, name: str | None, placement: Placement | None, size: tuple[int, int]) -> Shown:
        """The viewport, `size` pixels large, with the picture at its place; drawn now if anything changed."""
        self._draw("viewport", self._viewport, name, placement, size)
        return _shown(self._viewport.texture)

    def viewport_pixels(self) -> np.ndarray:
        """(h, w, 3) uint8 sRGB of the viewport as drawn last, row 0 at its top."""
        return self._viewport.pixels()

    def panorama(self) -> Shown | None:
        """The light in force; repeats sideways."""
        return _shown(self._panorama.texture)

    def ball(self, light: LightSource) -> Shown | None:
        """A ball lit by a light, as far as it has been drawn yet."""
        slot = self._ball_slot(light)
        if light.kind == "rig":
            slot.show(self._shelf.ball(light.name))
        return _shown(slot.texture)

    def close(self) -> None:
        """Free everything."""
        slots = [*self._radiance.values(), *self._channels.values(), *self._balls.values()]
        canvases = [self._viewport, *self._thumbnails.values()]
        for item in [*slots, *canvases, self._panorama]:
            item.close()
        self._triangle.release()
        self._program.release()

    def _ball_slot(self, light: LightSource) -> TextureSlot:
        return self._balls.setdefault((light.kind, light.name), TextureSlot(self._context))

    def _slot(self, name: str) -> TextureSlot | None:
        # The channel called photo is the face's crop; here the name means the whole photo.
        return self._radiance.get(name) or self._channels.get(name)

    def _draw(
        self, key: str, canvas: Canvas, name: str | None, placement: Placement | None, size: tuple[int, int]
    ) -> None:
        exposure_ev = self.exposure_ev if name == RESULT else 0.0
        wanted = (name, placement, size, exposure_ev, self._generation)
        if not canvas.fit(size) and self._drawn.get(key) == wanted:
            return
        self._drawn[key] = wanted
        canvas.framebuffer.use()
        if name is None or placement is None:
            red, green, blue = self._program["canvas_srgb"].value
            canvas.framebuffer.clear(red, green, blue, 1.0)
            return
        self._paint(self._slot(name), placement, exposure_ev, encoded=name not in self._radiance)

    def _paint(self, slot: TextureSlot, placement: Placement, exposure_ev: float, encoded: bool) -> None:
        slot.smooth(placement.zoom < _CRISP_FROM_ZOOM)
        program = self._program
        program["place"].value = (placement.x, placement.y, placement.width, placement.height)
        program["encoded"].value = encoded
        program["has_alpha"].value = slot.texture.components == 4
        program["exposure_ev"].value = exposure_ev
        slot.texture.use(0)
        self._context.disable(moderngl.BLEND | moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._triangle.render(moderngl.TRIANGLES, vertices=3)


def _shown(texture: moderngl.Texture | None) -> Shown | None:
    return Shown(texture.glo, *texture.size) if texture else None
