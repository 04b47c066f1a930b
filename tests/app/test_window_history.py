"""The list of the history in the real window."""

import shutil
import threading

import pytest
from fake_relighter import LONG_S
from imgui_bundle import imgui
from window_hand import places_drawn

from app.ui.layout import OpenGroups


@pytest.fixture
def rows(monkeypatch):
    return places_drawn(monkeypatch, imgui, "selectable")


def test_while_a_photo_is_read_a_click_on_the_step_before_goes_back(opened, relighter, photo_path, rows, monkeypatch):
    state, window, go_on, read = opened.window.state, opened.window, threading.Event(), relighter.set_portrait
    monkeypatch.setattr(relighter, "set_portrait", lambda *given: go_on.wait(LONG_S) and read(*given))
    other = shutil.copy(photo_path, photo_path.with_name("other.png"))
    state.groups = OpenGroups(export=False, background=False)
    window.on_drop(None, [str(other)], opened.centre())
    opened.frames(2)
    assert state.photo.path == other
    opened.click(rows["Open person.png"])
    go_on.set()
    opened.settle()
    assert (state.photo.path, state.snapshot.opened.source.path) == (photo_path, photo_path)
