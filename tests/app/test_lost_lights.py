"""Work under a light whose file is gone: unsaved by the next start, or in a session."""

import pytest
from live_editor import Editor, unsaved_files
from opened_things import open_wish, refuse_light

from app.document.document import Document, LightRef, PhotoRef
from app.document.session_file import write_session
from app.engine.sources import LightSource
from relight_core.lighting.light_edit import LightEdit
from relight_core.lighting.soft_box import SoftBox
from relight_core.pipeline.edit import Edit

BOXES = (SoftBox(azimuth_deg=40.0),)


def left_under_a_lost_panorama(tmp_path, light_edit):
    """Settings of an editor that has left unsaved work on me.jpg under sky.hdr, which is gone."""
    photo, light = tmp_path / "me.jpg", tmp_path / "sky.hdr"
    photo.write_bytes(b"pixels")
    light.write_bytes(b"radiance")
    editor = Editor(tmp_path / "settings")
    editor.state.open_photo(photo)
    editor.live()
    editor.state.choose_light(LightSource("panorama", str(light)))
    editor.state.light_edit = light_edit
    editor.state.change(shadow=0.25)
    editor.live()
    editor.deeds.close()
    light.unlink()
    return tmp_path / "settings"


@pytest.fixture
def folder(tmp_path):
    return left_under_a_lost_panorama(tmp_path, LightEdit(level_ev=3.0, base=0.5, boxes=BOXES, metered=True))


def test_it_comes_back_under_the_first_light_with_its_sliders_and_boxes(folder):
    editor = Editor(folder)
    (question,) = editor.state.asking.questions
    assert "The light sky.hdr is not there, and Rembrandt stands in for it." in question.text
    editor.answer_question("Restore")
    state = editor.state
    assert (state.light.kind, state.light.name) == ("rig", "rembrandt")
    assert state.light_edit == LightEdit(base=0.5, boxes=BOXES)
    assert state.edit.shadow == 0.25
    assert editor.said == [
        ("Unsaved work on me.jpg: the light sky.hdr is not there, and Rembrandt stands in for it", True)
    ]
    editor.deeds.close()


def test_it_can_be_discarded(folder):
    editor = Editor(folder)
    editor.answer_question("Discard")
    editor.deeds.close()
    assert unsaved_files(folder) == []
    assert Editor(folder).said == []


def test_lamps_that_shone_alone_go_with_their_light(tmp_path):
    """What stands in for it would be black with as little of it as was left of the lost one."""
    alone = LightEdit(base=0.0, boxes=(SoftBox(name="lamp"),), apart=True, metered=True)
    editor = Editor(left_under_a_lost_panorama(tmp_path, alone))
    editor.answer_question("Restore")
    assert editor.state.light_edit == LightEdit()


@pytest.mark.parametrize(
    ("light", "fault"), [("sky.hdr", "is not there"), ("notes.txt", "can't be used")], ids=["gone", "no picture"]
)
def test_a_session_opens_without_its_light_and_asks_before_its_file_forgets_that(tmp_path, light, fault):
    """Saved in the moment before a light is refused, a session names whatever was asked for."""
    photo, session = tmp_path / "me.jpg", tmp_path / "me.relight.json"
    photo.write_bytes(b"pixels")
    (tmp_path / "notes.txt").write_text("no light")
    lost = LightRef("portrait", str(tmp_path / light))
    write_session(session, Document(PhotoRef(photo), lost, LightEdit(warmth=0.5, boxes=BOXES), Edit(shadow=0.25)))
    saved = session.read_bytes()
    editor = Editor(None)
    editor.deeds._take([session])
    editor.live()
    state = editor.state
    assert (state.photo.path, state.light.name, state.edit.shadow) == (photo, "rembrandt", 0.25)
    assert state.light_edit == LightEdit(boxes=BOXES)
    assert editor.said == [(f"me.relight.json: the light {light} {fault}, and Rembrandt stands in for it", True)]
    editor.deeds.save_session()
    assert session.read_bytes() == saved
    editor.answer_question("Replace")
    assert session.read_bytes() != saved
    assert not state.is_unsaved()
    editor.deeds.close()


@pytest.mark.parametrize("come", [open_wish, lambda state: None], ids=["photo first", "light first"])
def test_a_session_whose_light_proves_damaged_asks_before_its_file_forgets_that(tmp_path, come):
    photo, light, session = (tmp_path / name for name in ("me.jpg", "sky.hdr", "me.relight.json"))
    for path in (photo, light):
        path.write_bytes(b"begins well")
    write_session(session, Document(PhotoRef(photo), LightRef("panorama", str(light)), edit=Edit(shadow=0.25)))
    saved = session.read_bytes()
    editor = Editor(None)
    state = editor.state
    editor.deeds._take([session])
    come(state)
    refuse_light(state)
    editor.live()
    assert (state.photo.path, state.light.name, state.edit.shadow) == (photo, "rembrandt", 0.25)
    editor.deeds.save_session()
    assert session.read_bytes() == saved
    editor.answer_question("Replace")
    assert session.read_bytes() != saved
    editor.deeds.close()


def test_a_session_s_light_that_can_not_be_read_again_stays_and_so_does_its_file(tmp_path):
    photo, light, session = (tmp_path / name for name in ("me.jpg", "sky.hdr", "me.relight.json"))
    for path in (photo, light):
        path.write_bytes(b"begins well")
    write_session(session, Document(PhotoRef(photo), LightRef("panorama", str(light))))
    editor = Editor(None)
    state = editor.state
    editor.deeds._take([session])
    editor.live()
    state.open_light(LightSource("panorama", str(light)))
    refuse_light(state)
    assert (state.light.name, state.session_path) == (str(light), session)
    editor.deeds.close()
