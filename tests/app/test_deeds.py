"""What the window does for its panels: sessions, recovery, recent lights, dialogs; no window is needed for it."""

import json
import sys
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path
from types import SimpleNamespace

import pytest
from live_editor import Editor, unsaved_files
from opened_things import refuse_photo

from app.document.session_file import read_session
from app.engine.sources import LightSource
from app.ui import file_dialogs
from app.ui.asking import FileRequest
from app.ui.file_dialogs import Candidates, FileDialogs, candidates
from app.ui.state import EditorState
from app.window.dropped import open_named, take_files
from app.window.recent_lights import RecentLights, read_recent
from relight_core.lighting.light_edit import LightEdit


@pytest.fixture
def photo(tmp_path):
    (tmp_path / "shoot").mkdir()
    path = tmp_path / "shoot" / "me.jpg"
    path.write_bytes(b"pixels")
    return path


@pytest.fixture
def editor(folder, photo):
    editor = Editor(folder)
    editor.state.open_photo(photo)
    editor.live()
    yield editor
    editor.deeds.close()


def test_a_session_is_saved_beside_the_photo_and_opens_again(editor, photo, folder):
    editor.state.change(shadow=0.5)
    editor.state.light_edit = LightEdit(warmth=0.4)
    editor.state.asking.wish("save_session")
    editor.live()
    saved = photo.with_name("me.relight.json")
    assert editor.said == [(f"Saved {saved}", False)]
    assert not editor.state.is_unsaved()
    other = Editor(None)
    other.deeds._take([saved])
    other.live()
    assert other.state.document() == editor.state.document()
    assert other.state.session_path == saved
    assert not other.state.is_unsaved()


def test_saving_again_replaces_the_own_file_without_asking_but_asks_for_another(editor, photo):
    for shadow in (0.5, 0.6):
        editor.state.change(shadow=shadow)
        editor.state.asking.wish("save_session")
        editor.live()
    assert read_session(photo.with_name("me.relight.json")).document.edit.shadow == 0.6
    editor.state.session_path = None
    editor.state.change(shadow=0.7)
    editor.state.asking.wish("save_session")
    editor.live()
    assert read_session(photo.with_name("me.relight.json")).document.edit.shadow == 0.6
    editor.answer_question("Keep both")
    assert read_session(photo.with_name("me-jpg.relight.json")).document.edit.shadow == 0.7


def test_a_file_that_is_no_session_is_never_replaced(editor, photo):
    notes = photo.with_name("me.relight.json")
    notes.write_text("my notes")
    editor.state.asking.wish("save_session")
    editor.live()
    editor.answer_question("Replace")
    assert notes.read_text() == "my notes"
    assert editor.said[-1][1]


def test_a_session_whose_photo_is_refused_leaves_everything_as_it_was(editor, photo):
    editor.state.change(shadow=0.5)
    editor.live()
    before = editor.state.document()
    bad = photo.with_name("bad.jpg")
    bad.write_bytes(b"no pixels")
    editor.state.open_session(
        replace(before, photo=replace(before.photo, path=bad), edit=replace(before.edit, yaw_deg=90.0)), None
    )
    refuse_photo(editor.state)
    editor.live()
    assert editor.state.document() == before
    assert editor.state.is_unsaved()


def test_unsaved_work_is_kept_offered_and_comes_back(editor, folder, photo):
    assert unsaved_files(folder) == []
    editor.state.change(shadow=0.25)
    editor.live()
    assert len(unsaved_files(folder)) == 1
    editor.deeds.close()
    again = Editor(folder)
    again.live()
    assert "me.jpg" in again.state.asking.questions[0].text
    again.answer_question("Restore")
    assert again.state.edit.shadow == 0.25
    assert again.state.photo.path == photo
    assert again.state.is_unsaved()
    assert len(unsaved_files(folder)) == 1
    again.state.asking.wish("save_session")
    again.live()
    again.deeds.close()
    assert unsaved_files(folder) == []
    assert Editor(folder).state.asking.questions == []


def test_discarded_work_is_offered_no_more(editor, folder):
    editor.state.change(shadow=0.25)
    editor.live()
    editor.deeds.close()
    again = Editor(folder)
    again.answer_question("Discard")
    again.deeds.close()
    assert Editor(folder).state.asking.questions == []


def test_opening_a_photo_alone_is_no_work(editor, folder):
    editor.live(60)
    assert not editor.state.is_unsaved()
    assert not editor.deeds.waiting
    assert unsaved_files(folder) == []


def test_a_photo_with_a_session_beside_it_offers_to_go_on(editor, photo):
    editor.state.change(shadow=0.5)
    editor.state.asking.wish("save_session")
    editor.live()
    other = Editor(None)
    other.state.open_photo(photo)
    other.live()
    assert other.state.edit.shadow == 1.0
    other.answer_question("Continue")
    assert other.state.edit.shadow == 0.5


def test_recent_lights_come_back_while_their_files_are_there(tmp_path):
    state = EditorState()
    for name in ("a.hdr", "gone.hdr"):
        (tmp_path / name).write_bytes(b"light")
        state.extra_lights.append(LightSource("panorama", str(tmp_path / name)))
    RecentLights(tmp_path / "recent.json").keep(state)
    (tmp_path / "gone.hdr").unlink()
    later = EditorState()
    RecentLights(tmp_path / "recent.json").recall(later)
    assert [light.title for light in later.extra_lights] == ["a"]


def test_a_light_from_a_file_is_listed_at_the_next_start(editor, folder, tmp_path):
    sky = tmp_path / "sky.hdr"
    sky.write_bytes(b"light")
    editor.state.choose_light(LightSource("panorama", str(sky)))
    editor.live(2)
    assert [light.name for light in Editor(folder).state.extra_lights] == [str(sky)]


def test_two_windows_keep_the_lights_of_both(tmp_path):
    lights = [LightSource("panorama", str(tmp_path / f"{number}.hdr")) for number in range(4)]
    for light in lights:
        Path(light.name).write_bytes(b"light")
    one, other = (RecentLights(tmp_path / "recent.json") for _ in range(2))
    shown, beside = EditorState(extra_lights=lights[:1]), EditorState(extra_lights=lights[1:2])
    one.recall(shown)
    other.recall(beside)
    one.keep(shown)
    other.keep(beside)
    shown.extra_lights.insert(0, lights[2])
    one.keep(shown)
    shown.extra_lights.insert(0, lights[3])
    one.keep(shown)
    kept = [Path(name).stem for _, name in read_recent(tmp_path / "recent.json")]
    assert kept == ["3", "2", "1", "0"]
    shown.extra_lights.remove(lights[2])
    one.keep(shown)
    assert (lights[2].kind, lights[2].name) not in read_recent(tmp_path / "recent.json")


def test_a_light_that_is_named_from_here_is_the_recent_one_and_not_another(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sky.hdr").write_bytes(b"light")
    state = EditorState(extra_lights=[LightSource.named(str(tmp_path / "sky.hdr"))])
    open_named(state, [], "sky.hdr")
    assert state.light is state.extra_lights[0]
    take_files(state, [Path("sky.hdr")], -1.0, -1.0)
    assert state.light is state.extra_lights[0]


def test_a_file_is_kept_and_recalled_once(tmp_path):
    paths = [tmp_path / f"{number}.hdr" for number in range(12)]
    for path in paths:
        path.write_bytes(b"light")
    known = [LightSource("panorama", str(path)) for path in (paths[0], *paths)]
    RecentLights(tmp_path / "recent.json").keep(EditorState(extra_lights=known))
    names = [str(path) for path in paths]
    assert [name for _, name in read_recent(tmp_path / "recent.json")] == names
    (tmp_path / "recent.json").write_text(json.dumps([["panorama", names[0]], *[["panorama", name] for name in names]]))
    later = EditorState()
    RecentLights(tmp_path / "recent.json").recall(later)
    assert [light.name for light in later.extra_lights] == names


def test_the_lights_that_are_kept_are_those_that_were_used_last(tmp_path):
    paths = [tmp_path / f"{number}.hdr" for number in range(13)]
    recent, state = RecentLights(tmp_path / "recent.json"), EditorState()

    def use(path):
        source = LightSource("panorama", str(path))
        if source not in state.extra_lights:
            state.extra_lights.insert(0, source)
        state.snapshot = replace(state.snapshot, light=SimpleNamespace(source=source))
        for _ in range(2):
            recent.keep(state)

    for path in (*paths[:12], paths[0], paths[12]):
        use(path)
    kept = [Path(name) for _, name in read_recent(tmp_path / "recent.json")]
    assert kept == [paths[12], paths[0], *paths[11:1:-1]]
    assert state.extra_lights[-1].name == str(paths[0]), "none moves in the panel"


@pytest.mark.parametrize(
    "content", ["{", "[[1, 2]]", '[["spell", "x"]]', '[["panorama", "a\\u0000b"]]', "[" * 99999, "7"]
)
def test_a_damaged_list_of_recent_lights_is_empty(tmp_path, content):
    (tmp_path / "recent.json").write_text(content)
    state = EditorState()
    RecentLights(tmp_path / "recent.json").recall(state)
    assert state.extra_lights == []


def test_without_native_dialogs_ours_is_drawn(editor, photo):
    editor.state.asking.wish("open_file")
    editor.live(1)
    request = editor.state.picking
    assert request.kind == "open"
    session = photo.with_name("me.relight.json")
    session.touch()
    assert {photo, session} <= set(candidates(request.text, request.suffixes).files)
    request.then([photo.with_name("missing.json")])
    editor.live(1)
    assert editor.said[-1][1]


def test_our_dialog_lists_folders_then_fitting_files_and_hides_dot_files(tmp_path):
    for name in ("b.jpg", "B2.JPG", "c.txt", ".h.jpg"):
        (tmp_path / name).touch()
    (tmp_path / "sub").mkdir()
    folders, files = candidates(f"{tmp_path}/", (".jpg",))
    assert [path.name for path in folders + files] == ["sub", "b.jpg", "B2.JPG"]
    assert [path.name for path in candidates(f"{tmp_path}/b2", (".jpg",)).files] == ["B2.JPG"]
    assert candidates(f"{tmp_path}/nowhere/", ()) == Candidates()


def test_the_systems_dialog_lists_names_in_large_letters_too_and_all_files_on_demand(monkeypatch, tmp_path):
    asked = []
    monkeypatch.setattr(file_dialogs.native, "open_file", lambda *words: asked.append(words))
    FileDialogs(True).ask(FileRequest("open", "Open", tmp_path, print, (".jpg", ".relight.json")))
    _, _, (_, patterns, _, everything), _ = asked[0]
    for name in ("dsc_1.jpg", "DSC_1.JPG", "me.relight.json"):
        assert any(fnmatchcase(name, pattern) for pattern in patterns.split())
    assert not any(fnmatchcase("notes.txt", pattern) for pattern in patterns.split())
    assert fnmatchcase("notes.txt", everything)


def test_a_dialog_is_of_a_known_kind(tmp_path):
    with pytest.raises(ValueError, match="kind"):
        FileRequest("guess", "", tmp_path, print)


def test_a_saved_light_can_be_opened_alone(editor, tmp_path):
    editor.state.light_edit = LightEdit(tint=0.3)
    editor.state.change(yaw_deg=40.0)
    editor.state.asking.wish("save_light")
    editor.live(1)
    target = tmp_path / "mine.light.json"
    editor.state.picking.then([target])
    editor.live(1)
    assert json.loads(target.read_text())["light"]["tint"] == 0.3
    editor.state.light_edit = LightEdit()
    editor.state.change(yaw_deg=0.0)
    editor.deeds._take_light(target)
    assert (editor.state.light_edit.tint, editor.state.edit.yaw_deg) == (0.3, 40.0)


@pytest.mark.parametrize(("content", "replaced"), [('{"relight": "session"}', False), ('{"relight": "light"}', True)])
def test_a_light_replaces_only_a_light(editor, tmp_path, content, replaced):
    there = tmp_path / "mine.light.json"
    there.write_text(content)
    editor.state.asking.wish("save_light")
    editor.live(1)
    editor.state.picking.then([there])
    editor.answer_question("Replace")
    assert (there.read_text() != content) is replaced
    assert editor.said[-1][1] is not replaced


def test_a_dialog_that_gives_a_name_that_is_no_text_is_told_and_the_window_goes_on(editor):
    def result():
        return b"\xff".decode("utf-8")

    editor.deeds._dialogs._dialog = SimpleNamespace(ready=lambda _: True, result=result, kill=lambda: None)
    editor.live(1)
    assert "no text" in editor.said[-1][0]
    assert not editor.deeds._dialogs.waiting


@pytest.mark.parametrize("from_queue", [True, False])
def test_a_batch_goes_to_the_current_folder_where_the_photos_own_is_no_place_for_it(
    tmp_path, photo, monkeypatch, from_queue
):
    monkeypatch.setattr(sys, "prefix", str(photo.parent))
    monkeypatch.chdir(tmp_path)
    (photo.parent / "you.jpg").write_bytes(b"pixels")
    photos, started = [photo, photo.with_name("you.jpg")], []
    outputs = SimpleNamespace(done_already=lambda *_: (0, 0), batch_over=lambda *words, **_: started.append(words))
    editor = Editor(None, outputs=outputs)
    editor.state.open_photos(photos if from_queue else photos[:1])
    editor.state.asking.wish("batch")
    editor.live(1)
    if not from_queue:
        editor.state.picking.then([photo.parent])
    editor.deeds.close()
    assert started == [(photos, tmp_path / "relit")]


def test_a_batch_over_a_folder_leaves_out_the_panorama_that_is_the_light(photo):
    started, sky = [], photo.with_name("sky.exr")
    sky.write_bytes(b"radiance")
    outputs = SimpleNamespace(
        done_already=lambda *_: (0, 0), batch_over=lambda photos, *_, **__: started.append(photos)
    )
    editor = Editor(None, outputs=outputs)
    for light in (LightSource("panorama", str(sky)), LightSource("rig", "rim")):
        editor.state.light = light
        editor.state.asking.wish("batch")
        editor.live(1)
        editor.state.picking.then([photo.parent])
    editor.deeds.close()
    assert started == [[photo], [photo, sky]]


def test_a_picture_whose_portrait_is_lost_while_its_place_is_asked_for_is_exported(editor, photo):
    exported = []
    editor.deeds._outputs = SimpleNamespace(
        suggested=lambda *_: photo.with_name("me-relit.png"),
        export_writer=lambda: lambda path, replaces: exported.append(path),
    )
    editor.state.asking.wish("export_as")
    editor.live(1)
    lost = editor.state.snapshot
    editor.state.accept(replace(lost, opened=None, picture=None, refused=frozenset({lost.opened.source})))
    editor.state.picking.then([photo.with_name("you.png")])
    assert exported == [photo.with_name("you.png")]


@pytest.mark.parametrize("name", ["anna v1.2", "anna.mov", "anna", "anna.MP4"])
def test_a_film_is_a_film_whatever_it_is_called(photo, name):
    filmed = []
    outputs = SimpleNamespace(
        suggested=lambda *_: photo.with_name("me.mp4"),
        film_writer=lambda: lambda path, replaces: filmed.append(path),
    )
    editor = Editor(None, outputs=outputs)
    editor.state.asking.wish("turntable_film")
    editor.live(1)
    editor.state.picking.then([photo.with_name(name)])
    editor.deeds.close()
    assert [path.name for path in filmed] == [name if name == "anna.MP4" else f"{name}.mp4"]


def test_a_wish_that_fails_unforeseen_is_told_and_the_window_goes_on(editor, monkeypatch):
    def fail():
        raise OSError("the disk is gone")

    monkeypatch.setattr(editor.deeds, "save_session", fail)
    editor.state.asking.wish("save_session")
    editor.live(2)
    assert any("disk is gone" in text and is_error for text, is_error in editor.said)
