"""The picture on the clipboard: by which tool it gets there, and what is told where there is none."""

import re
from pathlib import Path
from types import SimpleNamespace

import pytest

from app.window.clipboard import copy_png
from relight_core.errors import InputError


def test_without_a_clipboard_tool_that_is_told(monkeypatch):
    monkeypatch.setattr("app.window.clipboard.sys", SimpleNamespace(platform="linux"))
    monkeypatch.setattr("app.window.clipboard.shutil.which", lambda name: None)
    with pytest.raises(InputError, match="xclip"):
        copy_png(b"png")


@pytest.mark.parametrize(("wayland", "tool"), [("wayland-0", "wl-copy"), ("", "xclip")])
def test_the_clipboard_tool_is_that_of_the_running_display(monkeypatch, wayland, tool):
    ran = []
    monkeypatch.setenv("WAYLAND_DISPLAY", wayland)
    monkeypatch.setattr("app.window.clipboard.sys", SimpleNamespace(platform="linux"))
    monkeypatch.setattr("app.window.clipboard.shutil.which", lambda name: f"/bin/{name}")
    monkeypatch.setattr("app.window.clipboard._run", lambda command, given: ran.append(command[0]))
    copy_png(b"png")
    assert ran == [tool]


def test_on_windows_a_picture_is_copied_from_the_folder_of_whatever_user(monkeypatch, tmp_path):
    ran, home = [], tmp_path / "O'Brien"
    home.mkdir()
    monkeypatch.setattr("app.window.clipboard.sys", SimpleNamespace(platform="win32"))
    monkeypatch.setattr("app.window.clipboard.tempfile.tempdir", str(home))
    monkeypatch.setattr("app.window.clipboard._run", lambda command, given: ran.append(command[-1]))
    copy_png(b"png")
    (quoted,) = re.findall(r"FromFile\('((?:[^']|'')*)'\)", ran[0])
    assert Path(quoted.replace("''", "'")).parent.parent == home
