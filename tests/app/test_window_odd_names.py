"""Photos whose names are no text, in the real window."""

import os
import shutil
import sys

import glfw
import pytest

from app.document.session_file import read_session
from app.ui.asking import FileRequest
from app.ui.file_dialogs import FileDialogs
from app.window.dropped import take_files

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="names are text in Unicode there")


@pytest.fixture
def odd_path(photo_path, tmp_path):
    folder = tmp_path / os.fsdecode(b"sh\xffoot")
    folder.mkdir()
    return shutil.copy(photo_path, folder / os.fsdecode(b"m\xffe.png"))


def test_a_photo_whose_name_is_no_text_is_shown_saved_and_exported(hand, odd_path):
    state = hand.window.state
    hand.drop(odd_path)
    assert state.snapshot.opened.source.path == odd_path
    state.change(shadow=0.5)
    for _ in range(2):
        state.session_path = None
        state.asking.wish("save_session")
        hand.settle()
    assert len(state.asking.questions) == 1
    assert read_session(odd_path.with_suffix(".relight.json")).document.photo.path == odd_path
    state.export_wanted = ".png"
    hand.settle()
    hand.window.exporter.close()
    hand.frames(2)
    assert odd_path.with_name(f"{odd_path.stem}-relit.png").exists()


def test_our_file_dialog_and_the_list_of_lights_show_names_that_are_no_text(hand, odd_path):
    hand.window._deeds._dialogs = FileDialogs(False)
    state = hand.window.state
    hand.drop(odd_path)
    take_files(state, [odd_path], 0.0, 0.0, as_light=True)
    hand.settle()
    assert state.extra_lights[0].name == str(odd_path)
    state.asking.wish("open_file")
    hand.frames(3)
    assert state.picking.text == os.path.join(odd_path.parent, "")


def test_a_drop_of_a_name_that_is_no_text_is_told_and_the_window_goes_on(hand, monkeypatch):
    def wait():
        glfw.set_window_should_close(hand.window.handle, True)
        b"\xff".decode("utf-8")

    monkeypatch.setattr(hand.window, "_wait", wait)
    hand.window.run()
    hand.frames(2)
    assert "no text" in hand.window.state.message().text


def test_a_folder_whose_name_is_no_text_is_shown_in_our_own_dialog(odd_path):
    request = FileRequest("open", "Open", odd_path, print)
    assert FileDialogs(True).ask(request) is request
