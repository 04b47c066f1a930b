"""The shader's view transform against the same function on the CPU."""

from pathlib import Path

import moderngl
import numpy as np
import pytest

from app.window.glfw_window import close_window, open_window
from relight_core.imaging.view_transform import apply_view
from tests.hostile_colours import hostile_colours

SHADERS = Path(__file__).parents[2] / "shaders"


@pytest.fixture(scope="module")
def gpu_view(display):
    """A function that runs the shader over (N, 3) colours, in a hidden window's own context."""
    window = open_window("relight", (64, 64), visible=False)
    context = moderngl.create_context(require=330)
    fragment = f"""#version 330
        {(SHADERS / "view_transform.glsl").read_text()}
        uniform sampler2D radiance;
        uniform float exposure_ev;
        out vec4 colour;
        void main() {{
            vec3 linear = texelFetch(radiance, ivec2(gl_FragCoord.xy), 0).rgb;
            colour = vec4(view_transform(linear, exposure_ev), 1.0);
        }}"""
    vertex = """#version 330
        void main() {
            vec2 corner = vec2(gl_VertexID % 2, gl_VertexID / 2);
            gl_Position = vec4(4.0 * corner - 1.0, 0.0, 1.0);
        }"""
    program = context.program(vertex_shader=vertex, fragment_shader=fragment)
    triangle = context.vertex_array(program, [])

    def run(colours, exposure_ev):
        size = (len(colours), 1)
        texture = context.texture(size, 3, np.ascontiguousarray(colours, np.float32).tobytes(), dtype="f4")
        target = context.framebuffer([context.texture(size, 4, dtype="f4")])
        target.use()
        texture.use(0)
        program["exposure_ev"].value = exposure_ev
        triangle.render(moderngl.TRIANGLES, vertices=3)
        return np.frombuffer(target.read(components=4, dtype="f4"), np.float32).reshape(-1, 4)[:, :3]

    yield run
    context.release()
    close_window(window)


@pytest.mark.parametrize("exposure_ev", [0.0, -3.0, 2.5, 100.0])
def test_the_shader_is_the_same_function(gpu_view, exposure_ev):
    colours = hostile_colours()
    difference = np.abs(gpu_view(colours, exposure_ev) - apply_view(colours, exposure_ev))
    assert np.isfinite(difference).all()
    assert difference.max() < 0.5 / 255
