"""The lit ball in the viewport's corner: turned by the shader, so that it follows the hand at once."""

from __future__ import annotations

import moderngl
import numpy as np

from app.window.gl_textures import Canvas, TextureSlot
from app.window.shader_source import shader_program
from relight_core.lighting.environment import Environment
from relight_core.lighting.preview import ball_tables


class LightBall:
    """The program of shaders/light_ball.glsl and the ball it drew last."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._program = shader_program(context, "light_ball")
        self._program["matte"].value, self._program["gloss"].value = 0, 1
        self._triangle = context.vertex_array(self._program, [])
        self._tables = [TextureSlot(context, repeat_x=True) for _ in range(2)]
        self._canvas = Canvas(context)
        self._environment: Environment | None = None
        self._drawn: tuple | None = None

    def texture(self, environment: Environment | None, side: int, yaw_deg: float) -> moderngl.Texture | None:
        """The ball in a light, `side` pixels large; None without a light."""
        if environment is None:
            return None
        if environment is not self._environment:
            self._environment, self._drawn = environment, None
            for slot, table in zip(self._tables, ball_tables(environment), strict=True):
                slot.show(table.astype(np.float16))
        wanted = (side, yaw_deg)
        if self._canvas.fit((side, side)) or self._drawn != wanted:
            self._drawn = wanted
            self._draw(side, yaw_deg)
        return self._canvas.texture

    def close(self) -> None:
        """Free everything."""
        for item in (*self._tables, self._canvas):
            item.close()
        self._triangle.release()
        self._program.release()

    def _draw(self, side: int, yaw_deg: float) -> None:
        self._canvas.begin()
        self._program["side_px"].value = float(side)
        self._program["yaw_turns"].value = yaw_deg / 360.0
        for unit, slot in enumerate(self._tables):
            slot.texture.use(unit)
        self._context.disable(moderngl.BLEND | moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._triangle.render(moderngl.TRIANGLES, vertices=3)
