"""Numbers typed at a slider, and the keys that zoom on keyboards of other countries."""

import glfw
import pytest

from app.ui import binding, widgets
from app.ui.panels import light_controls, light_panel

GERMAN = {glfw.KEY_RIGHT_BRACKET: "+", glfw.KEY_SLASH: "-", glfw.KEY_Y: "z", glfw.KEY_EQUAL: "\N{ACUTE ACCENT}"}
FRENCH = {glfw.KEY_6: "-", glfw.KEY_EQUAL: "=", glfw.KEY_Q: "a", glfw.KEY_M: ",", glfw.KEY_SEMICOLON: "m"}
DVORAK = {glfw.KEY_W: ",", glfw.KEY_E: ".", glfw.KEY_Q: "'", glfw.KEY_S: "o"}
RUSSIAN = {glfw.KEY_W: "\N{CYRILLIC SMALL LETTER TSE}"}


def type_shadow(hand, value, text, end=glfw.KEY_ENTER):
    """The shadow slider's value after a Ctrl-click on its track and some typing."""
    state = hand.window.state
    (x, y), *_ = hand.knobs()
    state.change(shadow=value)
    hand.settle()
    hand.click((x, y), ctrl=True)
    hand.frames(3)
    assert state.typing is not None
    hand.type(text)
    hand.hold(end)
    hand.release(end)
    assert state.typing is None
    return state.edit.shadow


def test_a_gel_brighter_than_a_screen_is_typed_as_a_colour_of_its_hue():
    # In linear light 0.2, 0.8 and 1 of its brightest.
    assert widgets.hex_of(light_controls.gel_on_screen((0.25, 1.0, 1.25))) == "#7ce7ff"


@pytest.mark.parametrize(("typed", "linear"), [("#ff8000", (1.0, 0.21586, 0.0)), ("#0000ff", (0.0, 0.0, 1.0))])
def test_a_gel_gives_white_cloth_just_the_colour_that_is_picked_on_the_screen(typed, linear):
    gel = light_controls.gel_from_screen([value / 255 for value in bytes.fromhex(typed[1:])])
    assert gel == pytest.approx(linear, abs=1e-4)
    assert widgets.hex_of(light_controls.gel_on_screen(gel)) == typed


@pytest.mark.parametrize("end", [glfw.KEY_ENTER, glfw.KEY_ESCAPE])
@pytest.mark.parametrize("value", [0.7034, 2.5])
def test_a_number_that_is_not_touched_stays_as_it_is(opened, value, end):
    assert type_shadow(opened, value, "", end) == value


@pytest.mark.parametrize(("text", "value"), [("1.5", 1.5), ("9", 2.0)])
def test_a_number_that_is_typed_counts_within_the_track(opened, text, value):
    assert type_shadow(opened, 0.7034, text) == pytest.approx(value)


def test_tab_takes_the_number_and_the_next_keys_are_no_name_of_a_file(opened):
    state = opened.window.state
    assert type_shadow(opened, 0.7034, "1.5", glfw.KEY_TAB) == 1.5
    opened.type("2")
    opened.settle()
    assert (state.shown, state.export_path, state.panels.light) == ("albedo", "person-relit.png", True)


@pytest.mark.parametrize(("text", "value"), [("725", 5.0), ("190", -170.0), ("-190", 170.0), ("180", 180.0)])
def test_an_angle_that_is_typed_wraps_around(opened, text, value):
    state = opened.window.state
    state.typing, state.typing_began, state.typing_seen = light_panel.ROTATION.label, True, True
    opened.frames(3)
    opened.type(text)
    opened.hold(glfw.KEY_ENTER)
    opened.release(glfw.KEY_ENTER)
    assert state.edit.yaw_deg == pytest.approx(value)


@pytest.mark.parametrize(("number", "taken"), [(-180.0, -180.0), (540.0, 180.0), (float("inf"), 180.0)])
def test_an_angle_stays_on_the_track(number, taken):
    assert light_panel.ROTATION.taken(number) == taken


@pytest.mark.parametrize(
    ("layout", "key", "counts_as"),
    [
        (GERMAN, glfw.KEY_RIGHT_BRACKET, glfw.KEY_EQUAL),
        (GERMAN, glfw.KEY_SLASH, glfw.KEY_MINUS),
        (GERMAN, glfw.KEY_Y, glfw.KEY_Z),
        (FRENCH, glfw.KEY_EQUAL, glfw.KEY_EQUAL),
        (FRENCH, glfw.KEY_6, glfw.KEY_6),
        (FRENCH, glfw.KEY_Q, glfw.KEY_A),
        (FRENCH, glfw.KEY_M, glfw.KEY_COMMA),
        (DVORAK, glfw.KEY_W, glfw.KEY_COMMA),
        (DVORAK, glfw.KEY_E, glfw.KEY_PERIOD),
        (DVORAK, glfw.KEY_Q, glfw.KEY_UNKNOWN),
        (DVORAK, glfw.KEY_S, glfw.KEY_O),
        (RUSSIAN, glfw.KEY_W, glfw.KEY_W),
        (FRENCH, glfw.KEY_KP_ADD, glfw.KEY_KP_ADD),
    ],
)
def test_a_key_counts_as_what_is_printed_on_it(monkeypatch, layout, key, counts_as):
    monkeypatch.setattr(glfw, "get_key_name", lambda key, _: layout.get(key))
    assert binding._as_labelled(key) == counts_as


def test_plus_zooms_in_where_another_key_has_it(opened, monkeypatch):
    monkeypatch.setattr(glfw, "get_key_name", lambda key, _: GERMAN.get(key))
    opened.move(opened.centre())
    opened.key(glfw.KEY_RIGHT_BRACKET)
    assert opened.window.state.view.zoom > 1.0


@pytest.mark.parametrize(
    ("picked", "background", "gel"),
    [((1.2, -0.3, 0.5), "#ff0080", (1.0, 0.0, 0.21404)), ((0.0, 1e9, -1e9), "#00ff00", (0.0, 1.0, 0.0))],
)
def test_colours_beyond_all_colours_are_the_nearest_that_there_are(opened, monkeypatch, picked, background, gel):
    state = opened.window.state
    opened.key(glfw.KEY_N)
    monkeypatch.setattr(widgets.imgui, "color_edit3", lambda label, colour, flags: (True, list(picked)))
    opened.frames(2)
    assert state.edit.background == background
    assert state.light_edit.boxes[0].colour == pytest.approx(gel, abs=1e-4)


CTRL_A = ((glfw.KEY_LEFT_CONTROL, 0), (glfw.KEY_A, glfw.MOD_CONTROL))


def type_in_one_frame(hand, *strokes):
    """Keys pressed and let go one after the other while a single slow frame is drawn, with what each of them types."""
    for key, letter in strokes:
        hand.window.on_key(None, key, 0, glfw.PRESS, 0)
        if letter:
            hand.window.on_character(None, ord(letter))
        hand.window.on_key(None, key, 0, glfw.RELEASE, 0)


@pytest.fixture
def palette(opened):
    opened.window.state.look.palette = True
    opened.frames(3)
    return opened


def test_what_is_typed_while_a_modifier_waits_for_the_next_frame_is_not_lost(palette):
    palette.type("fit")
    for key, held in CTRL_A:
        palette.window.on_key(None, key, 0, glfw.PRESS, held)
    for key, _ in reversed(CTRL_A):
        palette.window.on_key(None, key, 0, glfw.RELEASE, glfw.MOD_CONTROL)
    type_in_one_frame(palette, (glfw.KEY_Z, "z"), (glfw.KEY_O, "o"), (glfw.KEY_M, "m"))
    palette.frames(12)
    assert palette.window.state.look.palette_text == "zom"


def test_what_is_typed_around_a_backspace_keeps_its_order(palette):
    palette.window.on_key(None, glfw.KEY_LEFT_SHIFT, 0, glfw.PRESS, 0)
    palette.window.on_key(None, glfw.KEY_F, 0, glfw.PRESS, glfw.MOD_SHIFT)
    palette.window.on_character(None, ord("F"))
    palette.window.on_key(None, glfw.KEY_F, 0, glfw.RELEASE, glfw.MOD_SHIFT)
    palette.window.on_key(None, glfw.KEY_LEFT_SHIFT, 0, glfw.RELEASE, glfw.MOD_SHIFT)
    type_in_one_frame(palette, (glfw.KEY_U, "u"), (glfw.KEY_BACKSPACE, ""), (glfw.KEY_I, "i"), (glfw.KEY_T, "t"))
    palette.frames(16)
    assert palette.window.state.look.palette_text == "Fit"
