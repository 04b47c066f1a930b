"""The export's controls in the real window."""

import numpy as np
from window_hand import EFFECTS_PANEL, HEIGHT, STRIPS, WIDTH

from app.ui.layout import OpenGroups


def test_the_export_buttons_stay_where_they_are_whatever_kind_of_file_is_chosen(opened):
    state = opened.window.state
    state.groups = OpenGroups(effects=False, background=False)
    panel = slice(WIDTH - EFFECTS_PANEL + 2, WIDTH)
    opened.move((WIDTH / 2, HEIGHT - 3))
    before = opened.window.screenshot()[: HEIGHT - STRIPS, panel]
    state.choose_form(".jpg")
    opened.settle()
    after = opened.window.screenshot()[: HEIGHT - STRIPS, panel]
    (rows,) = (before != after).any(axis=(1, 2)).nonzero()
    assert len(rows) > 20, "another kind, its quality, another name"
    assert np.ptp(rows) < 110, "three rows of controls, and nothing below them"


def test_the_quality_of_a_jpeg_is_dragged_and_a_double_click_resets_it(opened):
    state = opened.window.state
    state.groups = OpenGroups(effects=False, background=False)
    opened.move((WIDTH / 2, HEIGHT - 3))
    before = opened.window.screenshot()[: HEIGHT - STRIPS, WIDTH - EFFECTS_PANEL + 2 :]
    state.choose_form(".jpg")
    opened.settle()
    after = opened.window.screenshot()[: HEIGHT - STRIPS, WIDTH - EFFECTS_PANEL + 2 :]
    (rows,) = (before != after).any(axis=(1, 2)).nonzero()
    y = rows.min() + 12 + 32
    opened.drag((WIDTH - 180, y), (WIDTH - EFFECTS_PANEL + 16, y))
    assert state.export.quality < 60
    opened.double_click((WIDTH - 150, y))
    assert state.export.quality == 92
