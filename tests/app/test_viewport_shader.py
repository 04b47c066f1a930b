"""What the shaders make of pixels: their place, their colours, and the ball in the light."""

import numpy as np
import pytest
from drawn_recipes import HEIGHT, WIDTH, drawn

from app.ui.pictures import Paint
from app.ui.viewport.view import Placement
from app.window.gl_light_ball import LightBall
from relight_core.imaging.colour import srgb_decode, srgb_encode
from relight_core.lighting.environment import Environment
from relight_core.lighting.sphere import directions


def pixels(*values):
    return np.full((HEIGHT, WIDTH, len(values)), values, np.float16)


def test_a_picture_is_turned_counterclockwise(context):
    picture = pixels(0.0, 0.0, 0.0)
    picture[:, WIDTH // 2 :] = 1.0
    shown = drawn(context, picture, Placement(0, 0, 1.0, 64, 64, roll_deg=90.0))
    assert shown[4:28].min() > 0.95
    assert shown[36:60].max() < 0.05


def test_half_transparent_pixels_mix_as_light_with_the_checks_behind_them(context):
    shown = drawn(context, pixels(0.5, 0.2, 0.0, 0.25))
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH] + 0.5
    ground = srgb_decode(np.where((np.floor(x / 12) + np.floor(y / 12)) % 2 < 0.5, 0.32, 0.42)[..., None])
    np.testing.assert_allclose(shown, srgb_encode(0.75 * ground + 0.25 * np.float32([0.5, 0.2, 0.0])), atol=1.5 / 255)


@pytest.mark.parametrize(("exposure_ev", "brighter"), [(0.0, True), (-4.0, False)])
@pytest.mark.parametrize("opaque", [True, False])
def test_a_difference_is_orange_where_the_picture_as_it_is_shown_is_brighter(context, exposure_ev, brighter, opaque):
    photo = pixels(0.1, 0.1, 0.1) if opaque else pixels(0.1, 0.1, 0.1, 0.02)
    shown = drawn(context, pixels(0.4, 0.4, 0.4), None, Paint(difference=True), exposure_ev, photo)
    red, _, blue = shown[HEIGHT // 2, WIDTH // 2]
    assert (red > blue) == brighter


@pytest.mark.parametrize(("yaw_deg", "side"), [(0.0, 1), (97.1, -1)])
def test_the_ball_is_lit_where_its_light_is_and_turns_with_it(context, yaw_deg, side):
    """The lamp is above and at the right of the camera, 48.5 degrees round; twice that and it is at the left."""
    radiance = 0.01 + 50.0 * (directions(64, 128) @ (0.6, 0.6, 0.53) > 0.95)
    environment = Environment.from_radiance(np.repeat(radiance[..., None], 3, -1).astype(np.float32))
    ball = LightBall(context)
    ball.texture(environment, 64, yaw_deg)
    lit = ball._canvas.pixels()[..., 1].astype(float)
    ball.close()
    down, across = np.mgrid[0:64, 0:64] - 31.5
    assert (lit * across).sum() / lit.sum() * side > 4
    assert (lit * down).sum() / lit.sum() < -4
