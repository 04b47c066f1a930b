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


def test_the_ball_is_lit_where_its_light_is_and_turns_with_it(context):
    """The lamp is above and at the right of the camera, 48.5 degrees round; twice that and it is at the left."""
    ball = LightBall(context)

    def lit_toward(environment, yaw_deg):
        ball.texture(environment, 64, yaw_deg)
        lit = ball._canvas.pixels()[..., 1].astype(float)
        down, across = np.mgrid[0:64, 0:64] - 31.5
        return (lit * across).sum() / lit.sum(), (lit * down).sum() / lit.sum()

    above, below = (
        Environment.from_radiance(np.float32(0.01 + 50.0 * (directions(64, 128) @ (0.6, y, 0.53) > 0.95)))
        for y in (0.6, -0.6)
    )
    for environment, yaw_deg, side, up in ((above, 0.0, 1, -1), (above, 97.1, -1, -1), (below, 97.1, -1, 1)):
        across, down = lit_toward(environment, yaw_deg)
        assert across * side > 4
        assert down * up > 4
    ball.close()
