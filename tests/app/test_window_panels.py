"""Panels moved about in the real window."""

import glfw
import pytest
from fake_relighter import LONG_S
from imgui_bundle import imgui
from window_hand import places_drawn

from app.ui.layout import OpenGroups, Panels


def test_a_panel_is_dragged_by_its_grip_to_the_other_side_and_f9_puts_it_back(opened):
    state = opened.window.state
    opened.move((127, 5))
    opened.button(True)
    opened.move((400, 200))
    opened.move((900, 300))
    shown = opened.window.screenshot()
    assert state.panels == Panels(), "nothing moves before it is let go"
    assert int(shown[500, 700, 0]) - int(shown[500, 700, 2]) > 5, "where it would go is tinted"
    opened.button(False)
    opened.settle()
    assert state.panels == Panels(light_at="right")
    opened.frames(1)
    assert state.light_panel[0] > opened.width / 2
    opened.key(glfw.KEY_F9)
    assert state.panels == Panels()
    opened.frames(1)
    assert state.light_panel[0] == 0


def test_the_panorama_works_on_the_other_side(opened, photo_path):
    state = opened.window.state
    opened.key(glfw.KEY_F7, shift=True)
    x0, _, x1, _ = state.light_panel
    opened.drag((x0 + 60, 90), (x0 + 150, 90))
    assert state.edit.yaw_deg > 60.0
    opened.drop(photo_path, at=((x0 + x1) / 2, 300))
    assert state.light.kind == "portrait"


def test_a_click_or_a_twitch_on_a_grip_moves_nothing_and_a_double_click_does(opened):
    state = opened.window.state
    opened.move((127, 5))
    opened.button(True)
    opened.move((129, 6))
    opened.button(False)
    opened.settle()
    assert state.panels == Panels()
    opened.double_click((127, 5))
    assert state.panels == Panels(light_at="right")


def test_what_reaches_to_the_right_ends_alike_and_is_not_cut(opened, monkeypatch):
    ends, draw = {}, imgui.button

    def note(label, *size):
        clicked = draw(label, *size)
        ends[label] = imgui.get_item_rect_max().x
        return clicked

    monkeypatch.setattr(imgui, "button", note)
    opened.window.state.groups = OpenGroups(effects=False, background=False)
    opened.frames(2)
    reaching = [ends[label] for label in ("Outline…", "Copy", "PNGs", "Batch over a folder…", "Redo")]
    assert reaching == pytest.approx([ends["Copy"]] * len(reaching), abs=0.51)


def test_no_button_below_moves_when_the_first_picture_of_a_photo_comes(hand, relighter, photo_path, monkeypatch):
    buttons = places_drawn(monkeypatch, imgui, "button")
    relighter.gate.clear()
    hand.window.on_drop(None, [str(photo_path)], hand.centre())
    hand.frames(2)
    assert relighter.entered.acquire(timeout=LONG_S)
    hand.frames(2)
    before = dict(buttons)
    hand.click(before["Outline…"])
    assert not hand.window.state.brush.is_open
    relighter.gate.set()
    hand.settle()
    assert buttons["Copy"] == before["Copy"]
    hand.click(buttons["Outline…"])
    assert hand.window.state.brush.is_open
