"""The list of the history in the real window."""

import shutil
import threading
from dataclasses import replace

import pytest
from fake_relighter import LONG_S
from imgui_bundle import imgui
from window_hand import places_drawn

from app.ui.layout import OpenGroups


@pytest.fixture
def rows(monkeypatch):
    return places_drawn(monkeypatch, imgui, "text_unformatted")


def test_names_that_differ_only_behind_hashes_look_different_in_the_list(opened):
    state, looks = opened.window.state, []
    opened.window.shelf.wait()
    state.groups = OpenGroups(export=False, background=False)
    for name in ("Open a##1.png", "Open a##1.png", "Open a##2.png"):
        state.history.steps[0] = replace(state.history.steps[0], name=name)
        opened.frames(2)
        looks.append(opened.window.screenshot())
    assert (looks[0] == looks[1]).all()
    assert (looks[0] != looks[2]).any()


def test_while_a_photo_is_read_a_click_on_the_step_before_goes_back(opened, relighter, photo_path, rows, monkeypatch):
    state, window, go_on, read = opened.window.state, opened.window, threading.Event(), relighter.set_portrait
    monkeypatch.setattr(relighter, "set_portrait", lambda *given: go_on.wait(LONG_S) and read(*given))
    other = shutil.copy(photo_path, photo_path.with_name("other.png"))
    state.groups = OpenGroups(effects=False, export=False, background=False)
    window.on_drop(None, [str(other)], opened.centre())
    opened.frames(2)
    assert state.photo.path == other
    opened.click(rows["Open person.png"])
    go_on.set()
    opened.settle()
    assert (state.photo.path, state.snapshot.opened.source.path) == (photo_path, photo_path)
