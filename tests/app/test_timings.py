"""Which stages the card of timings has room for, and that their reasons stay within it."""

from dataclasses import replace

import glfw
import numpy as np
import pytest
from fake_relighter import FakeStage
from window_hand import WIDTH

from app.ui.panels.timings import stages_that_fit
from relight_core.pipeline.cache import Stage

STAGES = {
    "read": Stage(30.0, "computed", "new photo"),
    "outline": Stage(5.0, "computed", "new photo"),
    "delight": Stage(90.0, "reused", "same photo"),
    "relief": Stage(60.0, "computed", "new photo"),
    "matte": Stage(20.0, "computed", "new photo"),
}

FIRST_ROW, WORD_GAP = slice(16, 28), 5
"""Of the card at scale 1, in pixels: where its first row is, and more than lies between two words."""


def test_all_are_shown_where_they_and_their_sum_fit():
    assert list(stages_that_fit(STAGES, 6)) == ["read", "outline", "delight", "relief", "matte"]


def test_in_a_low_window_the_longest_stay_in_their_order_above_the_others_and_the_sum():
    assert list(stages_that_fit(STAGES, 5)) == ["read", "relief", "matte"]
    assert list(stages_that_fit(STAGES, 1)) == []


@pytest.mark.parametrize("words", [8, 60])
def test_a_reason_ends_within_the_card(opened, relighter, monkeypatch, words):
    opened.window.shelf.wait()
    relight, stages = relighter.relight, {"catchlights": FakeStage(0.0, "skipped", "reasons " * words)}
    monkeypatch.setattr(relighter, "relight", lambda *asked, **how: replace(relight(*asked, **how), stages=stages))
    opened.key(glfw.KEY_TAB)
    opened.key(glfw.KEY_RIGHT)
    without = opened.window.screenshot().astype(int)
    opened.key(glfw.KEY_T)
    changed = np.flatnonzero(np.abs(opened.window.screenshot() - without).any(axis=(0, 2)))
    assert WIDTH - 16 < changed.max() < WIDTH - 6


def test_the_longest_name_stays_clear_of_what_its_stage_took(opened, relighter, monkeypatch):
    opened.window.shelf.wait()
    relight, stages = relighter.relight, {"weightsxwherexunseen": FakeStage(1234.5)}
    monkeypatch.setattr(relighter, "relight", lambda *asked, **how: replace(relight(*asked, **how), stages=stages))
    opened.key(glfw.KEY_TAB)
    opened.key(glfw.KEY_RIGHT)
    opened.key(glfw.KEY_T)
    drawn = np.flatnonzero((opened.window.screenshot()[FIRST_ROW, WIDTH // 2 :] > 120).any(axis=(0, 2)))
    name, milliseconds, bar = np.split(drawn, np.flatnonzero(np.diff(drawn) > WORD_GAP) + 1)
    assert name[0] < milliseconds[0] < bar[0]
