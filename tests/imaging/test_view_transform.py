from pathlib import Path

import moderngl
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from relight_core.imaging.view_transform import apply_view

SHADERS = Path(__file__).parents[2] / "shaders"


def hostile_colours():
    """(N, 3) random radiance over many magnitudes, and every pair of troublesome values."""
    rng = np.random.default_rng(7)
    values = [0.0, -0.0, 1.0, 1.0001, 0.0031308, 1e-30, 65504.0, 1e30, -1.0, np.nan, np.inf, -np.inf]
    grid = np.array(np.meshgrid(values, values, [0.0, 0.5, 3.0])).reshape(3, -1).T
    magnitudes = rng.random((3000, 3)) * 10.0 ** rng.uniform(-4, 4, (3000, 1))
    return np.concatenate([grid, magnitudes, rng.random((3000, 3))]).astype(np.float32)


def test_displayable_colours_are_exactly_srgb():
    codes = np.arange(256) / 255
    linear = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
    shown = apply_view(np.repeat(linear[:, None], 3, 1))
    np.testing.assert_allclose(shown[:, 0], codes, atol=1e-5)
    assert apply_view(np.array([[1.0, 0.0, 0.3]]))[0, 0] == pytest.approx(1.0)


def test_one_stop_doubles_the_light():
    np.testing.assert_allclose(apply_view(np.full((1, 3), 0.2), 1.0), apply_view(np.full((1, 3), 0.4)))


def decode(srgb):
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


@given(st.tuples(*[st.floats(0.01, 1.0)] * 3), st.floats(1.0, 50.0))
def test_over_range_colours_keep_hue_and_grow_whiter(colour, gain):
    colour = np.array(colour) / max(colour)
    before = decode(apply_view(colour[None])[0])
    after = decode(apply_view(gain * colour[None])[0])
    assert after.max() == pytest.approx(1.0, abs=1e-5)
    assert (after >= before - 1e-4).all()
    # Distances from white shrink together: the mix with white keeps the hue.
    distance_before, distance_after = 1.0 - before, 1.0 - after
    if distance_before.max() > 0.05:
        share = distance_after.max() / distance_before.max()
        np.testing.assert_allclose(distance_after, share * distance_before, atol=2e-4)


def test_bright_skin_does_not_turn_yellow():
    skin = np.array([[1.0, 0.72, 0.55]]) * 1.6
    shown = decode(apply_view(skin))[0]
    clipped = np.minimum(skin[0], 1.0)
    assert shown[1] - shown[2] < 0.6 * (clipped[1] - clipped[2])


def test_the_step_past_one_is_continuous_and_brightness_never_falls():
    gains = np.linspace(0.5, 6.0, 4000)
    ramp = apply_view(gains[:, None] * np.array([1.0, 0.6, 0.3]))
    assert (np.diff(ramp, axis=0) > -1e-6).all()
    assert np.abs(np.diff(ramp, axis=0)).max() < 2.5e-3


def test_hostile_values_show_as_something():
    shown = apply_view(hostile_colours())
    assert np.isfinite(shown).all()
    assert shown.min() >= 0.0
    assert shown.max() <= 1.0
    np.testing.assert_array_equal(apply_view(np.array([[np.nan, -1.0, -np.inf]])), 0.0)
    np.testing.assert_allclose(apply_view(np.full((1, 3), np.inf)), 1.0)


def test_the_input_is_not_changed():
    linear = np.array([[np.nan, 5.0, -1.0]], np.float32)
    apply_view(linear, 1.0)
    np.testing.assert_array_equal(linear, np.array([[np.nan, 5.0, -1.0]], np.float32))


@pytest.fixture(scope="module")
def gpu_view():
    """A function that runs the shader over (N, 3) colours."""
    context = moderngl.create_context(standalone=True, backend="egl")
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


@pytest.mark.parametrize("exposure_ev", [0.0, -3.0, 2.5, 100.0])
def test_the_shader_is_the_same_function(gpu_view, exposure_ev):
    colours = hostile_colours()
    difference = np.abs(gpu_view(colours, exposure_ev) - apply_view(colours, exposure_ev))
    assert np.isfinite(difference).all()
    assert difference.max() < 0.5 / 255
