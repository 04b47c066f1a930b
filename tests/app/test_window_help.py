"""The overview of all keys in the real window."""

import numpy as np

from app.ui.actions import help_overlay


def test_the_overview_opens_with_a_question_mark_and_a_click_closes_it(opened):
    before = opened.window.screenshot()
    opened.window.on_character(None, ord("?"))
    opened.frames(2)
    assert opened.window.state.look.help
    assert np.abs(opened.window.screenshot().astype(int) - before).mean() > 10
    opened.click(opened.centre())
    assert not opened.window.state.look.help


def test_in_a_window_too_low_for_it_the_overview_scrolls_above_its_last_line(opened):
    size = (800, 560)
    opened.resize(size)
    opened.window.on_character(None, ord("?"))
    opened.move((300, 300))
    before = opened.window.screenshot()
    for _ in range(8):
        opened.window.on_wheel(None, 0.0, -5.0)
        opened.frames(2)
    after = opened.window.screenshot()
    changed = (before != after).any(axis=(1, 2))
    assert changed[: size[1] - 60].mean() > 0.5
    assert not changed[size[1] - 34 :].any()
    assert (after[size[1] - 34 :] > 100).any(), "how to close it"


def test_no_line_of_the_overview_ends_amid_keys_that_are_pressed_together(opened, monkeypatch):
    written, wrapped = [], help_overlay._wrapped

    def noted(words, *rest):
        written.append(words)
        wrapped(words, *rest)

    monkeypatch.setattr(help_overlay, "_wrapped", noted)
    opened.window.on_character(None, ord("?"))
    opened.frames(2)
    (redo,) = {words for words in written if "Shift" in words and "Y" in words}
    assert [keys.split() for keys in redo.replace("\N{NO-BREAK SPACE}", "_").split("  or  ")] == [
        ["Ctrl_+_Shift_+_Z"],
        ["Ctrl_+_Y"],
    ]
