"""What is remembered between runs, and what happens to a file that is not what it should be."""

import json
from dataclasses import replace

import pytest

from app.settings import Looking, Settings, config_folder, read_settings, write_settings
from app.ui.layout import OpenGroups, Panels
from app.ui.state import EditorState
from app.window.memory import Memory

GROUPS = OpenGroups(effects=False, quality=True)
CHANGED = Settings(
    Panels(20.0, 18.5, 9.0, light=False, light_at="right", filmstrip_at="top"),
    Looking("waveform", False, True, True),
    (1200, 800),
    GROUPS,
)


def test_settings_come_back_as_they_were(tmp_path):
    path = tmp_path / "made" / "settings.json"
    assert write_settings(path, CHANGED)
    assert read_settings(path) == CHANGED
    assert [entry.name for entry in path.parent.iterdir()] == ["settings.json"]


@pytest.mark.parametrize(
    "text",
    ["", "{", "[]", "null", '{"version": 2, "panels": {"light_em": 20}}', "\x00\xff", "[" * 100000],
)
def test_a_damaged_or_foreign_file_gives_the_defaults(tmp_path, text):
    path = tmp_path / "settings.json"
    path.write_bytes(text.encode("latin-1"))
    assert read_settings(path) == Settings()


def test_a_missing_file_gives_the_defaults(tmp_path):
    assert read_settings(tmp_path / "settings.json") == Settings()
    assert read_settings(tmp_path) == Settings()


@pytest.mark.parametrize("bad", ["wide", None, True, -1, 1e9, float("nan"), float("inf"), [], {}])
def test_each_wrong_value_alone_falls_back(tmp_path, bad):
    path = tmp_path / "settings.json"
    content = {
        "version": 1,
        "panels": {"light_em": bad, "effects_em": 20, "light": bad if bad is not True else 1, "light_at": bad, "x": 3},
        "looking": {"scope": bad, "timings": True},
        "window_size": [bad, 700],
    }
    path.write_text(json.dumps(content))
    read = read_settings(path)
    assert read.panels == replace(Panels(), effects_em=20)
    assert read.looking == replace(Looking(), timings=True)
    assert read.window_size is None


def test_a_folder_that_cannot_be_made_is_survived(tmp_path):
    (tmp_path / "relight").write_text("a file where the folder should be")
    assert not write_settings(tmp_path / "relight" / "settings.json", Settings())


def test_the_folder_follows_the_systems_setting(monkeypatch, tmp_path):
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    assert config_folder() == tmp_path / "relight"
    monkeypatch.delenv("XDG_CONFIG_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert config_folder() == tmp_path / ".config" / "relight"


def test_a_window_that_was_left_without_panels_comes_back_with_them(tmp_path):
    path, state = tmp_path / "settings.json", EditorState()
    write_settings(path, Settings(Panels(light_em=20.0).all_shown(False)))
    Memory(path).recall(state)
    assert state.panels == Panels(light_em=20.0)


def test_the_memory_writes_only_what_changed(tmp_path):
    path = tmp_path / "settings.json"
    memory, state = Memory(path), EditorState()
    memory.recall(state)
    memory.keep(state, (1000, 700))
    path.unlink()
    memory.keep(state, (1000, 700))
    assert not path.exists()
    state.panels = state.panels.switched("effects")
    state.look.timings = True
    memory.keep(state, (1000, 700))
    again, later = Memory(path), EditorState()
    again.recall(later)
    assert not later.panels.effects
    assert later.look.timings
    assert again.window_size == (1000, 700)


def test_a_memory_without_a_file_keeps_nothing():
    memory, state = Memory(None), EditorState()
    memory.recall(state)
    memory.keep(state, (1000, 700))
    assert memory.window_size is None
