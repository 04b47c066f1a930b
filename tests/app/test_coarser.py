"""The viewport while a hand moves and the processor draws: fewer pixels, everything where it was."""

import pytest

from app.ui.pictures import Paint
from app.ui.viewport.panes import Pane
from app.ui.viewport.view import Placement
from app.window.gl_viewport import coarseness, coarser, covered


def pane(x, y, width, height, roll_deg=0.0, left=0, right=10_000):
    return Pane("result", None, Placement(x, y, 1.5, width, height, roll_deg), left, right)


@pytest.mark.parametrize("size", [(912, 728), (913, 727), (3021, 1777)])
def test_everything_keeps_its_place_and_a_large_picture_has_no_more_pixels_than_can_be_drawn(size):
    whole = (pane(16, 20, size[0] - 50, size[1] - 40, right=size[0]),)
    by = coarseness(whole, size)
    (small,), less, paint = coarser(whole, size, Paint(stripe_px=6.0, check_px=24.0), by)
    assert less[0] * less[1] <= 1.15 * 90_000 * size[0] * size[1] / ((size[0] - 50) * (size[1] - 40))
    across, down = less[0] / size[0], less[1] / size[1]
    spot = small.placement
    assert (spot.x, spot.y) == pytest.approx((16 * across, 20 * down))
    assert (spot.width, spot.height) == pytest.approx(((size[0] - 50) * across, (size[1] - 40) * down))
    assert (paint.stripe_px, paint.check_px) == pytest.approx((6.0 / by, 24.0 / by))


def test_a_small_picture_is_halved():
    assert coarseness((pane(0, 0, 300, 200),), (900, 700)) == 2.0
    assert coarseness((), (900, 700)) == 2.0


def test_a_turned_picture_covers_its_corners_and_no_more_than_its_pane():
    x0, y0, x1, y1 = covered(pane(100, 100, 100, 100, roll_deg=45.0), (400, 400))
    assert (x0, y0, x1, y1) == (79, 79, 221, 221)
    assert covered(pane(-50, 10, 500, 100, left=200, right=300), (400, 400)) == (200, 10, 300, 110)
    x0, _, x1, _ = covered(pane(500, 0, 100, 100), (400, 400))
    assert x1 <= x0
