"""Paints pictures onto canvases: the viewport's panes, and thumbnails."""

from __future__ import annotations

from collections.abc import Sequence

import moderngl

from app.ui.panes import LIGHTS, Pane
from app.ui.pictures import Paint
from app.ui.state import PHOTO, RESULT
from app.ui.view import Placement
from app.window.gl_textures import Canvas, TextureSlot
from app.window.shader_source import stage_source
from relight_core.imaging.false_colour import difference_colours, scale_colours

RANGE_EV = 3.0
"""How many stops brighter or darker the ends of the difference's colours stand for."""

_PLAIN, _SCALE, _DIFFERENCE = 0, 1, 2
_SCALED = ("specular", "shadow")
_CRISP_FROM_ZOOM = 4.0


class PicturePainter:
    """The program of shaders/viewport.glsl.

    Args:
        context: the window's; current whenever a method is called.
        canvas_srgb: the colour around the picture.
    """

    def __init__(self, context: moderngl.Context, canvas_srgb: tuple[float, float, float]) -> None:
        self._context = context
        self._canvas_srgb = canvas_srgb
        stages = (stage_source("viewport", stage) for stage in ("VERTEX_STAGE", "FRAGMENT_STAGE"))
        self._program = context.program(*stages)
        for unit, name in enumerate(("picture", "photo", "colours")):
            self._program[name].value = unit
        self._program["canvas_srgb"].value = canvas_srgb
        self._program["range_ev"].value = RANGE_EV
        self._triangle = context.vertex_array(self._program, [])
        self.colours = {"scale": TextureSlot(context), "difference": TextureSlot(context)}
        self.colours["scale"].show(scale_colours())
        self.colours["difference"].show(difference_colours())

    def clear(self, canvas: Canvas) -> None:
        """Nothing but the canvas."""
        canvas.framebuffer.use()
        canvas.framebuffer.clear(*self._canvas_srgb, 1.0)

    def panes(
        self, canvas: Canvas, panes: Sequence[Pane], slots: dict[str, TextureSlot], paint: Paint, exposure_ev: float
    ) -> None:
        """Each pane's picture in its columns; what lies between them stays canvas."""
        self.clear(canvas)
        height = canvas.framebuffer.size[1]
        for pane in panes:
            canvas.framebuffer.scissor = (pane.left, 0, pane.right - pane.left, height)
            mode = _mode(pane.name, paint)
            self._program["clipping"].value = paint.clipping
            self._program["stripe_px"].value = paint.stripe_px
            self._picture(slots, pane.name, pane.placement, mode, exposure_ev)
        canvas.framebuffer.scissor = None

    def thumbnail(
        self, canvas: Canvas, slots: dict[str, TextureSlot], name: str, scale: float, exposure_ev: float
    ) -> None:
        """One picture that fills its canvas."""
        canvas.framebuffer.use()
        self._program["clipping"].value = False
        self._picture(slots, name, Placement(0, 0, scale, *canvas.framebuffer.size), _PLAIN, exposure_ev)

    def _picture(
        self, slots: dict[str, TextureSlot], name: str, place: Placement, mode: int, exposure_ev: float
    ) -> None:
        slot, program = slots[name], self._program
        # A light has so few texels that only their blend can be read as a place.
        slot.smooth(name in LIGHTS or place.width / slot.texture.width < _CRISP_FROM_ZOOM)
        program["place"].value = (place.x, place.y, place.width, place.height)
        program["encoded"].value = name not in (PHOTO, RESULT)
        program["has_alpha"].value = slot.texture.components == 4
        program["exposure_ev"].value = exposure_ev if name == RESULT else 0.0
        program["paint"].value = mode
        slot.texture.use(0)
        slots[PHOTO].texture.use(1)
        self.colours["difference" if mode == _DIFFERENCE else "scale"].texture.use(2)
        self._context.disable(moderngl.BLEND | moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._triangle.render(moderngl.TRIANGLES, vertices=3)

    def close(self) -> None:
        """Free everything."""
        for slot in self.colours.values():
            slot.close()
        self._triangle.release()
        self._program.release()


def _mode(name: str, paint: Paint) -> int:
    if paint.difference and name == RESULT:
        return _DIFFERENCE
    return _SCALE if paint.false_colour and name in _SCALED else _PLAIN
