"""The real window where a desktop makes it smaller than it asks to be: all of it can still be reached."""

from dataclasses import replace

import glfw
import pytest
from imgui_bundle import imgui
from window_hand import Hand

from app.ui.asking import FileRequest
from app.ui.layout import Panels, arrange
from app.ui.panels import light_panel
from app.ui.photo_queue import PhotoQueue
from app.window.window import EditorWindow

SIZE = 500, 350


@pytest.fixture
def small(display, relighter, photo_path):
    window = EditorWindow(lambda: relighter, photo_path, size=SIZE)
    hand = Hand(window, SIZE)
    hand.resize(SIZE)
    hand.settle()
    yield hand
    relighter.gate.set()
    window.close()


def test_the_last_light_is_scrolled_to(small, monkeypatch):
    in_sight, draw = {}, imgui.invisible_button

    def note(label, size):
        clicked = draw(label, size)
        in_sight[label] = imgui.is_item_visible()
        return clicked

    monkeypatch.setattr(light_panel.imgui, "invisible_button", note)
    small.move((60, 120))
    assert not in_sight["rig:split"]
    for _ in range(30):
        small.wheel(-3)
    assert in_sight["rig:split"]


@pytest.mark.parametrize("form", [".png", ".jpg"])
@pytest.mark.parametrize("size", [SIZE, (700, 500)])
def test_no_button_of_the_panels_cuts_its_words(small, monkeypatch, size, form):
    small.resize(size)
    state, cut, draw = small.window.state, set(), imgui.button

    def note(label, size):
        # Words that are too wide begin at the left padding.
        if 0.0 < size.x < imgui.get_style().frame_padding.x + imgui.calc_text_size(label).x:
            cut.add(label)
        return draw(label, size)

    state.export = replace(state.export, form=form)
    state.groups = replace(state.groups, export=True, adjust=True)
    small.key(glfw.KEY_N)
    monkeypatch.setattr(imgui, "button", note)
    state.queue = PhotoQueue((state.photo.path, state.photo.path))
    small.frames(3)
    assert cut == set()


def test_the_palette_and_our_own_file_dialog_stay_within_the_window(small, tmp_path):
    small.key(glfw.KEY_P, ctrl=True)
    small.frames(3)
    ends = []
    for name in ("palette", "file"):
        drawn = imgui.internal.find_window_by_name(name)
        ends.append((drawn.pos.y, drawn.pos.y + drawn.size.y))
        small.key(glfw.KEY_ESCAPE)
        small.window.state.picking = FileRequest("open", "A file", tmp_path, list)
        small.frames(3)
    assert all(top >= 0 and foot <= SIZE[1] for top, foot in ends)


def test_the_histogram_gives_way_to_the_effects():
    assert arrange(500, 350, 15.0, Panels(), scope=True).scope is None
    assert arrange(800, 560, 15.0, Panels(), scope=True).scope is not None


def test_a_long_name_leaves_room_for_what_stands_beside_it_at_the_foot(small, photo_path, monkeypatch):
    small.resize((800, 560))
    small.drop(photo_path.rename(photo_path.with_name(f"{'of the garden ' * 6}.png")))
    small.move((400, 200))
    ends, starts, write, button = [], [], imgui.text_disabled, imgui.invisible_button

    def note_words(words):
        if "128 × 96" in words:
            ends.append(imgui.get_cursor_screen_pos().x + imgui.calc_text_size(words).x)
        write(words)

    def note_link(label, size):
        if label.startswith("Relit in"):
            starts.append(imgui.get_cursor_screen_pos().x)
        return button(label, size)

    monkeypatch.setattr(imgui, "text_disabled", note_words)
    monkeypatch.setattr(imgui, "invisible_button", note_link)
    small.frames(2)
    assert max(ends) < min(starts)
