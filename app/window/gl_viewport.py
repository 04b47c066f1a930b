"""Paints pictures onto canvases: the viewport's panes, and thumbnails."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import moderngl

from app.ui.channels import PHOTO, RESULT
from app.ui.pictures import Paint
from app.ui.viewport.panes import LIGHTS, Pane
from app.ui.viewport.view import Placement
from app.window.damage import WHOLE, Part, Rect
from app.window.gl_recipe import RelitSlot
from app.window.gl_textures import Canvas, TextureSlot
from app.window.shader_source import shader_program
from relight_core.imaging.false_colour import difference_colours, scale_colours

RANGE_EV = 3.0
"""How many stops brighter or darker the ends of the difference's colours stand for."""

LEAST_COARSENESS, HURRIED_PIXELS = 2.0, 90_000
"""How coarse the viewport gets at least where it has to be quick, and about how many pixels its pictures then have."""

Slots = dict[str, TextureSlot | RelitSlot]

_PLAIN, _SCALE, _DIFFERENCE = 0, 1, 2
_SCALED = ("specular", "shadow")
_CRISP_FROM_ZOOM = 4.0


class PicturePainter:
    """The programs of shaders/viewport.glsl, with and without warnings and colours, from pixels and from recipes.

    Args:
        context: the window's; current whenever a method is called.
        canvas_srgb: the colour around the picture.
    """

    def __init__(self, context: moderngl.Context, canvas_srgb: tuple[float, float, float]) -> None:
        self._context = context
        self._canvas_srgb = canvas_srgb
        self._triangles: dict[tuple[str, ...], moderngl.VertexArray] = {}
        self.colours = {"scale": TextureSlot(context), "difference": TextureSlot(context)}
        self.colours["scale"].show(scale_colours())
        self.colours["difference"].show(difference_colours())

    def _triangle(self, *switches: str) -> moderngl.VertexArray:
        """The program with so many parts of shaders/viewport.glsl, made when it is first used."""
        if switches in self._triangles:
            return self._triangles[switches]
        program = shader_program(self._context, "viewport", *switches)
        program["canvas_srgb"].value = self._canvas_srgb
        if "INSPECTED" in switches:
            for unit, name in ((1, "photo"), (2, "colours")):
                program[name].value = unit
            program["range_ev"].value = RANGE_EV
        self._triangles[switches] = triangle = self._context.vertex_array(program, [])
        return triangle

    def clear(self, canvas: Canvas, part: Part = WHOLE) -> None:
        """Nothing but the canvas."""
        canvas.begin(part)
        canvas.framebuffer.clear(*self._canvas_srgb, 1.0)

    def panes(
        self,
        canvas: Canvas,
        panes: Sequence[Pane],
        slots: Slots,
        paint: Paint,
        exposure_ev: float,
        part: Part = WHOLE,
    ) -> None:
        """Each pane's picture in its columns; what lies between them stays canvas.

        Args:
            part: what of the canvas may look other than before.
        """
        self.clear(canvas, part)
        for pane in panes:
            x0, y0, x1, y1 = covered(pane, canvas.framebuffer.size)
            if x0 >= x1 or y0 >= y1:
                continue
            canvas.framebuffer.scissor = (x0, y0, x1 - x0, y1 - y0)
            mode, slot = _mode(pane.name, paint), slots[pane.name]
            switches, samples = slot.switches(), 1
            if paint.supersampled and gains_by_supersampling(pane, slots):
                switches, samples = ("SUPERSAMPLED", *switches), 2
            if mode != _PLAIN or paint.clipping:
                switches = ("INSPECTED", *switches)
                self._inspect(self._triangle(*switches).program, slots, paint, mode)
            triangle = self._triangle(*switches)
            self._picture(triangle, slots, pane.name, pane.placement, exposure_ev, paint.check_px, samples)
        canvas.framebuffer.scissor = None

    def thumbnail(self, canvas: Canvas, slots: Slots, name: str, scale: float, exposure_ev: float) -> None:
        """One picture that fills its canvas."""
        canvas.begin()
        whole = Placement(0, 0, scale, *canvas.framebuffer.size)
        self._picture(self._triangle(*slots[name].switches()), slots, name, whole, exposure_ev, Paint().check_px)

    def _inspect(self, program: moderngl.Program, slots: Slots, paint: Paint, mode: int) -> None:
        program["paint"].value = mode
        program["clipping"].value = paint.clipping
        program["stripe_px"].value = paint.stripe_px
        slots[PHOTO].texture.use(1)
        self.colours["difference" if mode == _DIFFERENCE else "scale"].texture.use(2)

    def _picture(
        self,
        triangle: moderngl.VertexArray,
        slots: Slots,
        name: str,
        place: Placement,
        exposure_ev: float,
        check_px: float,
        samples: int = 1,
    ) -> None:
        """One picture.

        Args:
            samples: how many samples the program takes within a pixel of the canvas, across and down.
        """
        slot, program = slots[name], triangle.program
        # A light has so few texels that only their blend can be read as a place.
        zoom = place.width / slot.size[0]
        slot.smooth(name in LIGHTS or (zoom != 1.0 and zoom < _CRISP_FROM_ZOOM))
        program["place"].value = (place.x, place.y, place.width, place.height)
        program["check_px"].value = check_px
        program["roll"].value = math.radians(place.roll_deg)
        program["encoded"].value = name not in (PHOTO, RESULT)
        program["has_alpha"].value = slot.has_alpha
        program["exposure_ev"].value = exposure_ev if name == RESULT else 0.0
        slot.bind(program, samples * place.width)
        self._context.disable(moderngl.BLEND | moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        triangle.render(moderngl.TRIANGLES, vertices=3)

    def close(self) -> None:
        """Free everything."""
        for slot in self.colours.values():
            slot.close()
        for triangle in self._triangles.values():
            program = triangle.program
            triangle.release()
            program.release()


def draws_in_software(context: moderngl.Context) -> bool:
    """Whether the processor does the graphics' work, for which every pixel counts."""
    renderer = context.info["GL_RENDERER"].lower()
    return any(name in renderer for name in ("llvmpipe", "softpipe", "swiftshader", "swrast"))


def gains_by_supersampling(pane: Pane, slots: Slots) -> bool:
    """Whether `Paint.supersampled` makes a difference: shown smaller, a recipe's maps are applied to averages."""
    slot = slots[pane.name]
    return "RECIPE" in slot.switches() and pane.placement.width < slot.size[0]


def covered(pane: Pane, size: tuple[int, int]) -> Rect:
    """The pixels of a viewport that a pane's picture can lie on; empty where the picture is out of sight."""
    spot = pane.placement
    turn = math.radians(spot.roll_deg)
    across = abs(spot.width * math.cos(turn)) + abs(spot.height * math.sin(turn))
    down = abs(spot.width * math.sin(turn)) + abs(spot.height * math.cos(turn))
    left, top = spot.x + (spot.width - across) / 2, spot.y + (spot.height - down) / 2
    x0, y0 = max(math.floor(left), pane.left, 0), max(math.floor(top), 0)
    return x0, y0, min(math.ceil(left + across), pane.right, size[0]), min(math.ceil(top + down), size[1])


def coarseness(panes: Sequence[Pane], size: tuple[int, int]) -> float:
    """How many times fewer rows and columns a viewport gets while a hand moves and the processor draws."""
    return max(LEAST_COARSENESS, math.sqrt(covered_pixels(panes, size) / HURRIED_PIXELS))


def covered_pixels(panes: Sequence[Pane], size: tuple[int, int]) -> int:
    """How many pixels of a viewport its pictures can lie on."""
    rects = [covered(pane, size) for pane in panes]
    return sum(max(x1 - x0, 0) * max(y1 - y0, 0) for x0, y0, x1, y1 in rects)


def coarser(
    panes: Sequence[Pane], size: tuple[int, int], paint: Paint, by: float
) -> tuple[tuple[Pane, ...], tuple[int, int], Paint]:
    """The same viewport with `by` times fewer rows and columns, or a little more to be whole ones."""
    smaller = tuple(math.ceil(length / by) for length in size)
    across, down = (length / less for length, less in zip(size, smaller, strict=True))

    def shrunk(pane: Pane) -> Pane:
        spot = pane.placement
        corner = {"x": spot.x / across, "y": spot.y / down}
        lengths = {"zoom": spot.zoom / across, "width": spot.width / across, "height": spot.height / down}
        left, right = round(pane.left / across), math.ceil(pane.right / across)
        return replace(pane, placement=replace(spot, **corner, **lengths), left=left, right=right)

    return (
        tuple(map(shrunk, panes)),
        smaller,
        replace(paint, stripe_px=paint.stripe_px / by, check_px=paint.check_px / by),
    )


def _mode(name: str, paint: Paint) -> int:
    if paint.difference and name == RESULT:
        return _DIFFERENCE
    return _SCALE if paint.false_colour and name in _SCALED else _PLAIN
