"""Our own file dialog in the real window, whatever is typed into it."""

import os
from pathlib import Path
from types import SimpleNamespace

import glfw
import pytest
from imgui_bundle import imgui

from app.ui import file_dialogs, file_picker
from app.ui.asking import FileRequest
from app.ui.file_dialogs import Candidates, FileDialogs, candidates


@pytest.mark.parametrize("kind", ["open", "save", "folder"])
@pytest.mark.parametrize("ending", ["", "/", "/a.png"])
def test_a_name_too_long_for_any_file_is_only_not_there(opened, tmp_path, kind, ending):
    state, chosen = opened.window.state, []
    state.picking = FileRequest(kind, "A file", tmp_path / "x", chosen.append, text=f"{tmp_path}/{'x' * 300}{ending}")
    opened.frames(3)
    opened.key(glfw.KEY_ENTER)
    assert kind == "save" or (state.picking is not None and chosen == [])
    assert candidates(f"{tmp_path}/{'x' * 300}{ending}", ()) == Candidates()


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "shoot"
    place.mkdir()
    return place


def ask(hand, text):
    """Our own dialog with a typed path; what it gives in the end."""
    chosen = []
    hand.window.state.picking = None
    hand.frames(2)
    hand.window.state.picking = FileRequest("open", "A file", Path(text), chosen.extend, (".png",), str(text))
    hand.frames(3)
    return chosen


def row(hand, number):
    """Where a row of the list is, from the first below the folder above."""
    style, line = imgui.get_style(), imgui.get_text_line_height_with_spacing()
    top = (hand.height - (file_picker._ROWS + 6) * 1.5 * imgui.get_font_size()) / 2 + style.window_padding.y
    return hand.width / 2, top + line + imgui.get_frame_height_with_spacing() + (number + 1.5) * line


@pytest.fixture
def greyed(monkeypatch):
    """What the dialog says in grey."""
    said, draw = [], imgui.text_disabled

    def note(text):
        said.append(text)
        draw(text)

    monkeypatch.setattr(file_picker.imgui, "text_disabled", note)
    return said


def test_names_that_differ_only_behind_hashes_look_different(opened, folder):
    looks = []
    opened.window.shelf.wait()
    for changed_ns, name in enumerate(("a##1.png", "a##2.png")):
        (folder / name).touch()
        os.utime(folder, ns=(changed_ns, changed_ns))
        ask(opened, f"{folder}{os.sep}")
        looks.append(opened.window.screenshot())
        (folder / name).unlink()
    assert (looks[0] != looks[1]).any()


def test_nothing_is_wrong_before_a_file_is_named(opened, folder, greyed):
    ask(opened, f"{folder}{os.sep}")
    assert "There is no such file" not in greyed
    ask(opened, folder / "b")
    assert "There is no such file" in greyed


def test_a_name_typed_narrows_the_list_in_which_a_double_click_takes_a_file(opened, folder):
    for name in ("ab.png", "b1.png", "b2.png"):
        (folder / name).touch()
    chosen = ask(opened, f"{folder}{os.sep}")
    opened.type("b")
    assert opened.window.state.picking.text == str(folder / "b")
    opened.double_click(row(opened, 1))
    assert chosen == [folder / "b2.png"]


def test_the_arrow_keys_and_enter_go_through_folders_to_a_file(opened, folder):
    (folder / "inside").mkdir()
    for name in ("a.png", "b.png"):
        (folder / "inside" / name).touch()
    chosen = ask(opened, f"{folder}{os.sep}")
    picking = opened.window.state.picking
    for _ in range(2):
        opened.key(glfw.KEY_DOWN)
    opened.key(glfw.KEY_ENTER)
    assert picking.text == f"{folder / 'inside'}{os.sep}"
    opened.key(glfw.KEY_DOWN)
    opened.key(glfw.KEY_ENTER)
    assert picking.text == f"{folder}{os.sep}"
    opened.type("i")
    opened.key(glfw.KEY_DOWN)
    opened.key(glfw.KEY_ENTER)
    assert picking.text == f"{folder / 'inside'}{os.sep}"
    for _ in range(9):
        opened.key(glfw.KEY_DOWN)
    opened.key(glfw.KEY_UP)
    opened.key(glfw.KEY_ENTER)
    assert (chosen, opened.window.state.picking) == ([folder / "inside" / "a.png"], None)


def test_a_file_typed_by_way_of_the_folder_above_is_given_in_full(opened, folder):
    (folder / "a.png").touch()
    chosen = ask(opened, folder / ".." / "shoot" / "a.png")
    opened.key(glfw.KEY_ENTER)
    assert chosen == [folder / "a.png"]


@pytest.mark.parametrize("typed", ["a.png", "./a.png", "inside/../a.png"])
def test_a_path_that_is_not_typed_in_full_begins_where_the_dialog_did(opened, folder, monkeypatch, typed):
    elsewhere = folder.parent / "elsewhere"
    for place in (folder, elsewhere):
        (place / "inside").mkdir(parents=True)
        (place / "a.png").touch()
    monkeypatch.chdir(elsewhere)
    chosen = ask(opened, f"{folder}{os.sep}")
    opened.key(glfw.KEY_A, ctrl=True)
    for letter in typed:
        opened.window.on_character(None, ord(letter))
    opened.frames(2)
    assert opened.window.state.picking.text == typed
    opened.key(glfw.KEY_ENTER)
    assert chosen == [folder / "a.png"]


def test_above_a_name_alone_lies_the_folder_above_the_dialog_s(opened, folder, monkeypatch, tmp_path_factory):
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))
    ask(opened, f"{folder}{os.sep}")
    opened.key(glfw.KEY_A, ctrl=True)
    opened.type("b")
    assert opened.window.state.picking.text == "b"
    opened.hold(glfw.KEY_UP, glfw.MOD_ALT)
    opened.release(glfw.KEY_UP)
    assert opened.window.state.picking.text == f"{folder.parent}{os.sep}"


def test_a_dialog_that_begins_at_no_full_path_begins_in_the_current_folder(opened, folder, monkeypatch):
    monkeypatch.chdir(folder.parent)
    chosen = []
    opened.window.state.picking = FileRequest("save", "A film", Path("shoot/turn.mp4"), chosen.extend, (".mp4",))
    opened.frames(3)
    opened.key(glfw.KEY_ENTER)
    assert chosen == [folder / "turn.mp4"]


def test_nothing_typed_lists_the_folder_that_was_gone_into(opened, folder, monkeypatch):
    (folder / "inside").mkdir()
    (folder / "inside" / "a.png").touch()
    monkeypatch.chdir(folder.parent)
    chosen = ask(opened, f"{folder}{os.sep}")
    for key in (glfw.KEY_DOWN, glfw.KEY_DOWN, glfw.KEY_ENTER):
        opened.key(key)
    opened.key(glfw.KEY_A, ctrl=True)
    opened.key(glfw.KEY_BACKSPACE)
    assert opened.window.state.picking.text == ""
    opened.double_click(row(opened, 0))
    assert chosen == [folder / "inside" / "a.png"]


def test_enter_goes_into_a_folder_that_was_typed_without_its_slash(opened, folder):
    (folder / "a.png").touch()
    chosen = ask(opened, folder)
    opened.key(glfw.KEY_ENTER)
    opened.type("a.png")
    opened.key(glfw.KEY_ENTER)
    assert chosen == [folder / "a.png"]


def test_the_folder_above_is_a_key_away_while_a_path_is_typed(opened, folder):
    ask(opened, f"{folder}{os.sep}")
    opened.type("b")
    opened.hold(glfw.KEY_UP, glfw.MOD_ALT)
    opened.release(glfw.KEY_UP)
    opened.frames(2)
    assert opened.window.state.picking.text == f"{folder.parent}{os.sep}"
    opened.type("s")
    assert opened.window.state.picking.text == f"{folder.parent}{os.sep}s"


def test_above_a_path_that_is_not_typed_in_full_lies_the_folder_above(opened, folder, monkeypatch):
    (folder / "inside").mkdir()
    monkeypatch.chdir(folder)
    for typed in ("b", "./", f"{folder / 'inside'}/../"):
        ask(opened, typed)
        opened.hold(glfw.KEY_UP, glfw.MOD_ALT)
        opened.release(glfw.KEY_UP)
        assert opened.window.state.picking.text == f"{folder.parent}{os.sep}"


def test_a_file_to_be_saved_is_carried_through_the_folders(opened, folder):
    (folder / "inside").mkdir()
    chosen = []
    opened.window.state.picking = picking = FileRequest("save", "A film", folder / "turn.mp4", chosen.extend, (".mp4",))
    opened.frames(3)
    for _ in range(2):
        opened.key(glfw.KEY_DOWN)
    opened.key(glfw.KEY_ENTER)
    assert picking.text == str(folder / "inside" / "turn.mp4")
    opened.hold(glfw.KEY_UP, glfw.MOD_ALT)
    opened.release(glfw.KEY_UP)
    assert picking.text == str(folder / "turn.mp4")
    opened.frames(2)
    opened.key(glfw.KEY_ENTER)
    assert chosen == [folder / "turn.mp4"]


@pytest.mark.parametrize(
    ("name", "suffixes", "saved"),
    [
        ("turn.mp4", (".mp4",), "B.mp4"),
        ("ä.b.relight.json", (".relight.json",), "B.relight.json"),
        ("ä.jpeg", (".png",), "B.jpeg"),
        ("", (".png",), "B"),
    ],
)
def test_what_is_typed_takes_the_place_of_the_name_that_is_suggested(opened, folder, name, suffixes, saved):
    chosen = []
    request = FileRequest("save", "A file", folder / name, chosen.extend, suffixes, f"{folder}{os.sep}{name}")
    opened.window.state.picking = request
    opened.frames(3)
    opened.type("B")
    opened.key(glfw.KEY_ENTER)
    assert chosen == [folder / saved]


def test_a_folder_that_is_not_there_is_no_file_to_be_saved(opened, folder, greyed):
    state, chosen, typed = opened.window.state, [], f"{folder}{os.sep}best{os.sep}"
    state.picking = FileRequest("save", "A file", folder / "best", chosen.extend, text=typed)
    opened.frames(3)
    opened.key(glfw.KEY_ENTER)
    assert chosen == []
    assert state.picking is not None
    assert "That is a folder; add a name" in greyed


def test_where_a_folder_is_wanted_the_arrow_keys_pass_files_by(opened, folder):
    (folder / "a.png").touch()
    ask(opened, f"{folder}{os.sep}")
    opened.window.state.picking.kind = "folder"
    for _ in range(3):
        opened.key(glfw.KEY_DOWN)
    assert opened.window.state.picking.row == 0


def test_files_beyond_those_listed_are_counted(opened, folder, greyed, monkeypatch):
    monkeypatch.setattr(file_picker, "_MOST", 2)
    for number in range(5):
        (folder / f"{number}.png").touch()
    ask(opened, f"{folder}{os.sep}")
    assert any(line.startswith("3 more") for line in greyed)


def test_one_dialog_of_the_system_is_open_at_a_time_and_gives_what_was_chosen(monkeypatch, folder):
    opened, given, is_done, answers = [], [], [], [["a.png", "b.png"], []]
    dialog = SimpleNamespace(ready=lambda _: bool(is_done), result=lambda: answers.pop(0))
    monkeypatch.setattr(file_dialogs.native, "open_file", lambda *words: (opened.append(words), dialog)[1])
    dialogs = FileDialogs(True)
    for _ in range(2):
        assert dialogs.ask(FileRequest("open", "Open", folder, given.append)) is None
        dialogs.poll()
    assert (len(opened), given) == (1, [])
    is_done.append(True)
    dialogs.poll()
    assert given == [[Path("a.png"), Path("b.png")]]
    dialogs.ask(FileRequest("open", "Open", folder, given.append))
    dialogs.poll()
    assert (len(opened), len(given), dialogs.waiting) == (2, 1, False), "the user thought better of it"


def test_a_folder_is_read_again_only_once_it_has_changed(folder, monkeypatch):
    reads, read = [], Path.iterdir
    monkeypatch.setattr(Path, "iterdir", lambda path: (reads.append(path), read(path))[1])
    for _ in range(3):
        assert candidates(f"{folder}{os.sep}", ()) == Candidates()
    assert candidates(f"{folder}{os.sep}a", ()) == Candidates()
    assert reads == [folder]
    (folder / "a.png").touch()
    os.utime(folder, ns=(1, 1))
    assert candidates(f"{folder}{os.sep}a", ()).files == (folder / "a.png",)
