"""The bar over the picture, and what scrolls beside it."""

import glfw
import pytest
from imgui_bundle import imgui
from window_hand import places_drawn

BEFORE, WIPE, SIDE, SHOW, FIT, FULL_SIZE = ((x, 16) for x in (441, 496, 564, 650, 706, 750))


@pytest.mark.parametrize(("place", "kind"), [(WIPE, "wipe"), (SIDE, "side")])
def test_a_click_compares_and_another_ends_it(opened, place, kind):
    opened.click(place)
    assert opened.window.state.look.compare == kind
    opened.click(place)
    assert opened.window.state.look.compare == "off"


def test_the_photo_is_seen_as_long_as_the_button_is_held(opened):
    opened.move(BEFORE)
    opened.button(True)
    assert opened.window.state.shown_name() == "photo"
    opened.button(False)
    assert opened.window.state.shown_name() == "result"


def test_fit_and_full_size(opened):
    opened.click(FIT)
    assert opened.window.state.view.fit
    opened.click(FULL_SIZE)
    view = opened.window.state.view
    assert (view.fit, view.zoom) == (False, 1.0)


def test_the_menu_switches_what_it_lists(opened):
    look = opened.window.state.look
    scope = look.scope
    opened.click(SHOW)
    em = imgui.get_font_size()
    opened.click((SHOW[0] + 2 * em, 16 + 1.2 * em + 1.55 * em))
    assert (look.scope, look.probe) in (("off", False), (scope, True))


def test_the_menu_lists_both_tools_over_the_picture(opened, monkeypatch):
    listed, draw = [], imgui.menu_item
    monkeypatch.setattr(imgui, "menu_item", lambda name, *rest: listed.append(name) or draw(name, *rest))
    opened.click(SHOW)
    assert {"Edit the face boxes", "Edit the outline"} <= set(listed)


def test_without_a_photo_nothing_can_be_compared(hand):
    hand.click(WIPE)
    assert hand.window.state.look.compare == "off"


def test_a_comparison_waits_while_the_photo_s_own_light_is_shown(opened):
    state = opened.window.state
    opened.click(WIPE)
    bright = opened.window.screenshot()[8:24, 470:520].max()
    opened.key(glfw.KEY_5)
    opened.move(FIT)
    greyed = opened.window.screenshot()[8:24, 470:520].max()
    assert (state.shown_name(), bool(greyed < 0.8 * bright)) == ("source_light", True)
    opened.click(SIDE)
    opened.key(glfw.KEY_W)
    assert state.look.compare == "wipe"
    opened.key(glfw.KEY_9)
    opened.key(glfw.KEY_W)
    assert state.look.compare == "off"


def test_controls_are_as_wide_with_a_scroll_bar_as_without(opened):
    high = [x for x, _ in opened.knobs()]
    groups = opened.window.state.groups
    opened.window.state.groups = type(groups)(export=False, history=False, background=False)
    opened.frames(4)
    assert [x for x, _ in opened.knobs()] == high


def test_what_the_bar_has_no_room_for_is_in_the_menu(opened, monkeypatch):
    listed, drawn = [], []
    entry, button = imgui.menu_item, imgui.button
    monkeypatch.setattr(imgui, "menu_item", lambda name, *rest: listed.append(name) or entry(name, *rest))
    monkeypatch.setattr(imgui, "button", lambda name, *rest: drawn.append(name) or button(name, *rest))
    opened.click(SHOW)
    assert {"Open…", "Save", "Wipe", "Side by side", "Fit", "100 %"} <= set(drawn)
    assert not {"Open…", "Save", "Wipe", "Fit"} & set(listed)
    opened.resize((800, 560))
    drawn.clear()
    opened.frames(2)
    assert not {"Open…", "Save"} & set(drawn)
    assert {"Open…", "Save"} <= set(listed)


def test_a_photo_is_opened_and_saved_from_the_menu_of_a_narrow_window(opened, monkeypatch):
    entry, chosen = imgui.menu_item, []

    def pressed(name, *rest):
        answer = entry(name, *rest)
        return (True, answer[1]) if name in chosen else answer

    opened.resize((800, 560))
    places = places_drawn(monkeypatch, imgui, "button")
    opened.frames(2)
    monkeypatch.setattr(imgui, "menu_item", pressed)
    wished = []
    monkeypatch.setattr(opened.window.state.asking, "wish", wished.append)
    opened.click(places[""])
    for label in ("Open…", "Save"):
        chosen[:] = [label]
        opened.frames(1)
    assert wished == ["open_file", "save_session"]
