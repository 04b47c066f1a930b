"""Undo, sessions and the queue while a photo or a light is on its way, and when it never comes."""

from types import SimpleNamespace

import pytest
from live_editor import Editor, unsaved_files
from opened_things import photo_files, refuse_light, refuse_photo

from app.document.document import Document, PhotoRef
from app.document.session_file import write_session
from app.engine.snapshot import Snapshot
from app.engine.sources import LightSource, PhotoSource
from app.ui.state import EditorState
from relight_core.face.find import FaceBox
from relight_core.pipeline.edit import Edit

SLOW_LIGHT = LightSource("panorama", "/slow.hdr")
BOXES = (FaceBox(0, 0, 2, 2), FaceBox(2, 2, 4, 4))


@pytest.fixture
def photos(tmp_path):
    return photo_files(tmp_path, "a.jpg", "b.jpg", "c.jpg", "d.jpg")


@pytest.fixture
def editor(photos, tmp_path):
    editor = Editor(tmp_path / "settings")
    editor.state.open_photo(photos[0])
    editor.live()
    yield editor
    editor.deeds.close()


def names(editor):
    return [step.name for step in editor.state.history.steps]


def change(editor, **fields):
    editor.state.change(**fields)
    editor.live()


def wait(editor, seconds=5):
    """The engine is at work on what was asked for."""
    for _ in range(seconds):
        editor.now_s += 1.0
        editor.state.remember(editor.now_s)


def undo(editor):
    editor.state.restore(editor.state.history.undo())


def session(folder, photo, **fields):
    path = folder / f"{photo.stem}.relight.json"
    write_session(path, Document(PhotoRef(photo), edit=Edit(quality="final", **fields)))
    return path


def test_an_undo_to_a_photo_that_is_gone_leaves_everything_as_it_was(editor, photos):
    change(editor, shadow=0.5)
    editor.state.open_photo(photos[1])
    editor.live()
    change(editor, shadow=0.9)
    undo(editor)
    editor.live()
    before, steps = editor.state.document(), names(editor)
    undo(editor)
    wait(editor)
    assert editor.state.photo.path == photos[0]
    refuse_photo(editor.state)
    editor.live()
    assert editor.state.document() == before
    assert names(editor) == steps == ["Open a.jpg", "Shadow 0.50", "Open b.jpg", "Shadow 0.90"]
    assert editor.state.history.at == 2
    assert editor.state.history.can_redo


def test_a_jump_to_a_light_that_is_gone_leaves_everything_as_it_was(editor):
    editor.state.choose_light(LightSource("panorama", "/gone.hdr"))
    editor.live()
    change(editor, shadow=0.5)
    editor.state.choose_light(LightSource("rig", "split"))
    editor.live()
    change(editor, specular=0.2)
    before, steps = editor.state.document(), names(editor)
    editor.state.restore(editor.state.history.go(3))
    editor.live()
    for index in (2, 1):
        editor.state.restore(editor.state.history.go(index))
    wait(editor)
    refuse_light(editor.state)
    editor.live()
    assert editor.state.light.name == "split"
    assert editor.state.edit.shadow == 0.5
    assert names(editor) == steps
    assert editor.state.history.at == 3
    editor.state.restore(editor.state.history.redo())
    assert editor.state.document() == before


def test_another_photo_does_not_take_the_settings_of_an_undo_that_never_came(editor, photos):
    change(editor, shadow=0.5)
    editor.state.open_photo(photos[1])
    editor.live()
    change(editor, shadow=0.9)
    editor.state.restore(editor.state.history.go(0))
    wait(editor)
    editor.state.open_photo(photos[2])
    editor.live()
    assert editor.state.edit.shadow == 0.9
    assert names(editor)[-2:] == ["Shadow 0.90", "Open c.jpg"]


def test_undo_while_a_light_loads_takes_back_the_light_alone(editor):
    change(editor, shadow=0.5)
    change(editor, specular=0.3)
    editor.state.choose_light(SLOW_LIGHT)
    wait(editor)
    undo(editor)
    editor.live()
    assert editor.state.light.name == "rembrandt"
    assert editor.state.edit.specular == 0.3
    assert editor.state.history.at == 2


def test_what_is_on_its_way_can_be_undone_though_nothing_came_before_it(editor, photos):
    assert not editor.state.history.can_undo
    editor.state.open_photo(photos[1])
    wait(editor)
    assert editor.state.history.can_undo
    undo(editor)
    editor.live()
    assert editor.state.photo.path == photos[0]
    assert names(editor) == ["Open a.jpg"]


def test_what_is_changed_while_the_rotation_plays_is_a_step_and_the_turn_another(editor):
    editor.state.playing = True
    editor.state.turn(10.0)
    change(editor, shadow=0.5)
    editor.state.turn(10.0)
    wait(editor)
    assert names(editor) == ["Open a.jpg", "Shadow 0.50"]
    undo(editor)
    assert (editor.state.edit.shadow, editor.state.edit.yaw_deg) == (1.0, 20.0)
    wait(editor)
    assert names(editor) == ["Open a.jpg", "Shadow 0.50"]
    editor.state.restore(editor.state.history.redo())
    assert (editor.state.edit.shadow, editor.state.edit.yaw_deg) == (0.5, 20.0)
    editor.state.turn(20.0)
    editor.state.playing = False
    editor.live()
    assert names(editor) == ["Open a.jpg", "Shadow 0.50", "Turn light to 40°"]


def test_a_light_that_plays_stays_where_it_is_when_an_undo_leads_to_a_photo_that_is_gone(editor, photos):
    editor.state.open_photo(photos[1])
    editor.live()
    editor.state.playing = True
    editor.state.turn(10.0)
    undo(editor)
    editor.state.turn(10.0)
    refuse_photo(editor.state)
    assert (editor.state.photo.path, editor.state.edit.yaw_deg, editor.state.playing) == (photos[1], 20.0, True)
    wait(editor)
    assert names(editor) == ["Open a.jpg", "Open b.jpg"]


def test_while_the_rotation_plays_work_is_kept_for_recovery_and_quick(editor, tmp_path):
    editor.state.request()
    editor.state.playing = True
    editor.state.change(shadow=0.5)
    for _ in range(12):
        editor.state.turn(1.0)
        editor.live(1)
    assert len(unsaved_files(tmp_path / "settings")) == 1
    assert editor.state.request().edit.quality == "live"


def test_the_first_photo_stays_wanted_when_a_bad_one_is_dropped_while_it_is_read(photos):
    state = EditorState()
    state.open_photos(photos[:2])
    first = state.photo
    state.accept(Snapshot(coming=SimpleNamespace(source=first)))
    state.open_photos(photos[2:3])
    state.accept(Snapshot(coming=SimpleNamespace(source=first), refused=frozenset({state.photo})))
    assert state.photo is first
    assert state.queue.label == "1 of 2"


@pytest.mark.parametrize("is_session", [True, False])
def test_a_session_and_what_follows_it_at_once_leave_no_settings_behind(editor, photos, tmp_path, is_session):
    change(editor, shadow=0.5)
    editor.deeds._take([session(tmp_path, photos[1], shadow=1.9)])
    editor.deeds._take([session(tmp_path, photos[2], shadow=1.1) if is_session else photos[2]])
    refuse_photo(editor.state)
    editor.live()
    assert editor.state.photo.path == photos[0]
    assert editor.state.edit.shadow == 0.5
    assert names(editor) == ["Open a.jpg", "Shadow 0.50"]


def test_a_photo_that_replaces_a_session_on_its_way_has_the_settings_of_before(editor, photos, tmp_path):
    change(editor, shadow=0.5)
    editor.deeds._take([session(tmp_path, photos[1], shadow=1.9)])
    editor.deeds._take([photos[2]])
    editor.live()
    assert editor.state.photo.path == photos[2]
    assert editor.state.edit.shadow == 0.5


def test_the_queue_goes_where_undo_goes(editor, photos):
    editor.state.open_photos(photos[:3])
    editor.live()
    editor.state.step_photo(1)
    editor.live()
    assert editor.state.queue.label == "2 of 3"
    undo(editor)
    editor.live()
    assert editor.state.queue.label == "1 of 3"
    editor.state.step_photo(1)
    assert editor.state.photo.path == photos[1]


def test_a_photo_beside_the_queue_has_no_number_in_it(editor, photos, tmp_path):
    editor.state.open_photos(photos[:3])
    editor.live()
    editor.deeds._take([session(tmp_path, photos[3])])
    editor.live()
    assert editor.state.photo.path == photos[3]
    assert editor.state.queue.label == "– of 3"
    editor.state.step_photo(1)
    editor.live()
    assert (editor.state.photo.path, editor.state.queue.label) == (photos[1], "2 of 3")


def test_choosing_a_face_while_the_next_photo_is_read_takes_this_photos_boxes(editor, photos):
    editor.state.open_photos(photos[:2])
    editor.live()
    editor.state.step_photo(1)
    editor.live()
    editor.state.photo = PhotoSource(editor.state.snapshot.opened.photo, None, BOXES)
    editor.live()
    editor.state.step_photo(-1)
    editor.live()
    editor.state.step_photo(1)
    assert editor.state.photo.boxes == BOXES
    editor.state.choose_face(0)
    assert (editor.state.photo.path, editor.state.photo.boxes) == (photos[0], None)
    assert editor.state.queue.label == "1 of 2"
