"""The bar over the picture, and what scrolls beside it."""

import pytest
from imgui_bundle import imgui

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


def test_controls_are_as_wide_with_a_scroll_bar_as_without(opened):
    high = [x for x, _ in opened.knobs()]
    groups = opened.window.state.groups
    opened.window.state.groups = type(groups)(export=False, history=False, background=False)
    opened.frames(4)
    assert [x for x, _ in opened.knobs()] == high
