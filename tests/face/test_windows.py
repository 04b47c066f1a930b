"""Squares to look for a face in: all of the photo, nothing beside it, not too many."""

import numpy as np
import pytest

from relight_core.face.windows import search_windows


@pytest.mark.parametrize("size", [(100, 100), (240, 160), (90, 400), (401, 301), (1, 1), (30, 6000)])
def test_windows_lie_in_the_photo_and_a_few_of_them_cover_it(size):
    windows = search_windows(size)
    assert len(windows) <= 45
    assert windows[0].side == min(size)
    seen = np.zeros(size, bool)
    for window in windows:
        x0, y0, x1, y1 = window.window
        assert min(x0, y0) >= -0.5
        assert x1 <= size[1] + 0.5
        assert y1 <= size[0] + 0.5
        seen[max(int(y0), 0) : int(np.ceil(y1)), max(int(x0), 0) : int(np.ceil(x1))] = True
    if max(size) < 9 * min(size):
        assert seen.all()


@pytest.mark.parametrize("width", [300, 540])
def test_a_small_face_is_whole_in_one_of_them(width):
    rng = np.random.default_rng(0)
    for _ in range(50):
        x, y = rng.uniform(0, width - 50), rng.uniform(0, 200 - 50)
        corners = [window.window for window in search_windows((200, width)) if window.side == 100]
        assert any(x0 <= x + 1 and y0 <= y + 1 and x + 49 <= x1 and y + 49 <= y1 for x0, y0, x1, y1 in corners)
