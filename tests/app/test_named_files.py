"""What the command line names is opened: a photo or a session, and the light beside it."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from app.document.document import Document, LightRef, PhotoRef
from app.document.session_file import read_session, write_session
from app.ui.state import EditorState
from app.window.dropped import open_named
from app.window.run import run_editor
from relight_core.pipeline.edit import Edit


@pytest.fixture
def shoot(tmp_path, monkeypatch):
    """Two photos with a session each, named from the folder they are in."""
    monkeypatch.chdir(tmp_path)
    for name, rig in (("me", "ring"), ("friend", "split")):
        Path(f"{name}.jpg").write_bytes(b"pixels")
        edit = Edit(yaw_deg=30.0, shadow=0.5, quality="final")
        write_session(
            Path(f"{name}.relight.json"), Document(PhotoRef(Path(f"{name}.jpg")), LightRef("rig", rig), edit=edit)
        )
    return tmp_path


@pytest.mark.parametrize("spelt", ["friend.relight.json", "./friend.relight.json", "../{}/friend.relight.json"])
def test_a_named_light_lights_the_named_photo_however_it_is_spelt(shoot, spelt):
    state = EditorState()
    open_named(state, [Path("me.jpg")], spelt.format(shoot.name))
    assert state.photo.path == Path("me.jpg")
    assert (state.light.name, state.edit.yaw_deg, state.edit.shadow) == ("split", 30.0, 1.0)


@pytest.mark.parametrize("light", ["golden-hour", "friend.relight.json", None])
def test_a_named_light_takes_the_place_of_a_session_s_and_leaves_its_sliders(shoot, light):
    state = EditorState()
    open_named(state, [Path("me.relight.json")], light)
    assert state.photo.path == shoot / "me.jpg"
    assert state.edit.shadow == 0.5
    assert state.light.name == {"golden-hour": light, "friend.relight.json": "split", None: "ring"}[light]


def test_a_session_and_its_light_are_known_by_an_ending_in_large_letters(shoot):
    session, light = (Path(f"{name}.relight.json").rename(f"{name}.RELIGHT.JSON") for name in ("me", "friend"))
    state = EditorState()
    open_named(state, [session], str(light))
    assert (state.photo.path, state.light.name, state.edit.shadow) == (shoot / "me.jpg", "split", 0.5)


@pytest.mark.parametrize(
    ("light", "told"),
    [
        ("golden-hour", []),
        ("friend.relight.json", []),
        (None, [("gone.relight.json: the light sky.hdr is not there, and Rembrandt stands in for it", True)]),
    ],
)
def test_nothing_is_said_to_stand_in_for_a_session_s_lost_light_where_another_is_named(shoot, light, told):
    write_session(Path("gone.relight.json"), Document(PhotoRef(Path("me.jpg")), LightRef("panorama", "sky.hdr")))
    state = EditorState()
    open_named(state, [Path("gone.relight.json")], light)
    assert state.asking.notices == told


@pytest.mark.parametrize("names", [["me.jpg", "friend.jpg"], ["."]])
def test_several_named_photos_and_a_folder_of_them_become_a_queue_under_the_named_light(shoot, names):
    state = EditorState()
    open_named(state, [Path(name) for name in names], "split")
    assert [path.name for path in state.queue.paths] == sorted(["me.jpg", "friend.jpg"], reverse=len(names) > 1)
    assert (state.photo.path, state.light.name) == (state.queue.paths[0], "split")


def test_a_photo_named_by_way_of_another_folder_is_opened_by_the_path_that_its_session_has(shoot, monkeypatch):
    window, opened = SimpleNamespace(state=None, run=lambda: None, close=lambda: None), []
    monkeypatch.setattr("app.window.window.EditorWindow", lambda *_, **kept: window)
    monkeypatch.setattr("app.window.dropped.open_named", lambda state, paths, light: opened.extend(paths))
    assert run_editor([Path("..") / shoot.name / "me.jpg"]) == 0
    assert opened == [read_session(Path("me.relight.json")).document.photo.path]


def test_a_named_file_that_is_bad_is_told(shoot):
    state = EditorState()
    Path("friend.relight.json").write_text("{")
    open_named(state, [Path("me.jpg")], "friend.relight.json")
    assert state.photo.path == Path("me.jpg")
    assert state.asking.notices[0][1]
