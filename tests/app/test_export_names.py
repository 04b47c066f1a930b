"""Whatever stands in the line for the export's name: the panel draws it, and an export lies in a sensible place."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
from opened_things import open_light, open_wish, opened_for

from app.engine.exporting import ExportSettings, free_path
from app.engine.places import from_home
from app.engine.snapshot import Picture, Snapshot
from app.engine.sources import PhotoSource
from app.ui.export_name import choose_form, export_place, named_as, take_named_form
from app.ui.file_dialogs import FileDialogs
from app.ui.state import EditorState
from app.window.deeds import Deeds
from app.window.finished import Finished
from app.window.outputs import Outputs
from relight_core.errors import InputError

TYPED = [
    ("~b", "~b", "~b.exr"),
    ("~b.png", "~b.png", "~b.exr"),
    ("/", "~me-relit.png", "~me-relit.exr"),
    (".", "~me-relit.png", "~me-relit.exr"),
    ("..", "~me-relit.png", "~me-relit.exr"),
    ("~", "~me-relit.png", "~me-relit.exr"),
    ("", "~me-relit.png", "~me-relit.exr"),
]


@pytest.mark.parametrize(
    ("typed", "suffix", "name"),
    [
        ("x.jpeg", ".jpg", "x.jpeg"),
        ("x.TIFF", ".tif", "x.TIFF"),
        ("x.png", ".jpg", "x.jpg"),
        ("x.tiff", ".exr", "x.exr"),
        ("x v1.2", ".png", "x v1.2.png"),
        ("x.png", ".mp4", "x.png.mp4"),
        ("x.png", ".relight.json", "x.png.relight.json"),
        ("x.json", ".light.json", "x.json"),
    ],
)
def test_a_name_takes_the_suffix_of_its_kind_unless_it_says_so_already(typed, suffix, name):
    assert named_as(Path(typed), suffix) == Path(name)


@pytest.fixture
def state(tmp_path):
    state = EditorState()
    state.open_photo(tmp_path / "~me.jpg")
    open_wish(state)
    return state


def test_a_photo_whose_name_begins_with_a_tilde_is_exported_beside_itself(state, tmp_path):
    assert export_place(state) == tmp_path / "~me-relit.png"


@pytest.mark.parametrize(("typed", "place", "as_exr"), TYPED)
def test_what_names_no_file_means_the_name_beside_the_photo(state, tmp_path, typed, place, as_exr):
    state.export_path = typed
    assert export_place(state) == tmp_path / place
    assert export_place(state, ".exr") == tmp_path / as_exr
    choose_form(state, ".exr")
    assert state.export_path == (as_exr if typed else "")


def test_a_slash_at_the_end_names_a_folder_where_the_picture_keeps_the_suggested_name(state, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("USERPROFILE", str(tmp_path / "home"))
    for typed, folder in (("sub/", tmp_path / "sub"), ("~/", tmp_path / "home"), ("a/b v1.2/", tmp_path / "a/b v1.2")):
        state.export_path = typed
        assert export_place(state, ".exr") == folder / "~me-relit.exr"


def test_a_folder_chooses_no_kind_of_picture_by_its_name(state, tmp_path):
    state.export_path = "scans.tif/"
    take_named_form(state)
    assert (state.export.form, state.export_path) == (".png", "scans.tif/")


@pytest.mark.parametrize(
    ("typed", "name"), [("best.JPG ", "best.JPG"), ("  ", "~me-relit.png"), ("a b/ ", "a b/~me-relit.png")]
)
def test_a_space_behind_a_name_that_is_typed_is_no_part_of_it(state, tmp_path, typed, name):
    state.export_path = typed
    take_named_form(state)
    assert export_place(state, state.export.form) == tmp_path / name


@pytest.mark.parametrize("typed", ["", "  ", "/", ".", "..", "~"])
def test_where_what_was_typed_names_nothing_the_suggested_name_comes_back_into_sight(state, typed):
    state.export_path = typed
    take_named_form(state)
    assert (state.export.form, state.export_path) == (".png", "~me-relit.png")
    choose_form(state, ".jpg")
    state.export_path = typed
    take_named_form(state)
    assert (state.export.form, state.export_path) == (".jpg", "~me-relit.jpg")


def test_a_place_typed_by_way_of_the_folder_above_is_in_sight_without_the_detour(state, tmp_path):
    (tmp_path / "far" / "deep").mkdir(parents=True)
    (tmp_path / "link").symlink_to(tmp_path / "far" / "deep")
    for typed, shown in (
        ("../x/y.tif", str(tmp_path.parent / "x" / "y.tif")),
        (f"../{tmp_path.name}/y.tif", "y.tif"),
        ("link/y.tif", str(tmp_path / "link" / "y.tif")),
        ("link/../y.tif", str(tmp_path / "link" / ".." / "y.tif")),
    ):
        state.export, state.export_path = ExportSettings(), typed
        take_named_form(state)
        assert (state.export.form, state.export_path) == (".tif", shown)


def test_beside_a_photo_that_was_opened_by_a_detour_a_name_alone_stays_one(tmp_path):
    state = EditorState()
    (tmp_path / "sub").mkdir()
    state.open_photo(tmp_path / "sub" / ".." / "me.jpg")
    open_wish(state)
    state.export_path = "x.png"
    choose_form(state, ".jpg")
    assert state.export_path == "x.jpg"


@pytest.mark.parametrize("typed", ["~/", "../", "best/", "~b"])
def test_a_folder_or_a_name_that_was_typed_stays_in_sight(state, typed):
    state.export_path = typed
    take_named_form(state)
    assert state.export_path == typed


def test_only_a_tilde_by_itself_is_the_users_folder(state, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("USERPROFILE", str(tmp_path / "home"))
    state.export_path = "~/best.png"
    assert export_place(state) == tmp_path / "home" / "best.png"
    monkeypatch.chdir(tmp_path)
    named = from_home(state.photo.path.relative_to(tmp_path))
    assert str(named) == "~me.jpg"
    assert free_path(named) == named


@pytest.fixture
def outputs(state):
    """Outputs of the state, what waits for a finished picture, and the exports that were begun."""
    waiting, jobs = [], []
    exporter = SimpleNamespace(submit=jobs.append)
    return Outputs(state, exporter, lambda: None, waiting.append), waiting, jobs


def test_outputs_are_named_after_the_photo_that_is_wanted_while_another_one_is_still_open(state, outputs, tmp_path):
    state.export_path = "best.png"
    assert outputs[0].suggested(".mp4", "-turntable") == tmp_path / "best-turntable.mp4"
    (tmp_path / "far").mkdir()
    state.open_photo(tmp_path / "far" / "you.jpg")
    assert outputs[0].suggested(".mp4", "-turntable") == tmp_path / "far" / "you-relit-turntable.mp4"
    assert outputs[0].suggested(".exr") == tmp_path / "far" / "you-relit.exr"


def test_a_dot_in_a_name_without_a_suffix_is_no_suffix_in_what_save_as_and_turntable_suggest(state, outputs, tmp_path):
    state.export_path = "best v1.5"
    assert outputs[0].suggested(".png") == tmp_path / "best v1.5.png"
    assert outputs[0].suggested(".mp4", "-turntable") == tmp_path / "best v1.5-turntable.mp4"


def test_an_export_is_named_after_the_photo_in_it(state, outputs, tmp_path):
    outputs[0].export(".jpg")
    assert outputs[1] == [], "there is no picture yet"
    state.snapshot = replace(state.snapshot, picture=SimpleNamespace(opened=state.snapshot.opened))
    state.change(exposure_ev=1.0)
    outputs[0].export(".jpg")
    state.change(exposure_ev=2.0)
    state.accept(Snapshot(opened=opened_for(PhotoSource(tmp_path / "you.jpg")), picture=state.snapshot.picture))
    (write,), jobs = outputs[1:]
    write(state.snapshot.picture)
    (job,) = jobs
    assert (job.path, job.settings.form, job.exposure_ev) == (tmp_path / "~me-relit.jpg", ".jpg", 1.0)
    assert not job.replaces


@pytest.mark.parametrize("is_there", [True, False])
def test_what_is_saved_under_a_chosen_name_is_as_it_was_set_then_and_of_the_kind_that_is_named(
    state, tmp_path, is_there
):
    jobs, waiting = [], []
    state.snapshot = replace(state.snapshot, picture=SimpleNamespace(opened=state.snapshot.opened))
    outputs = Outputs(state, SimpleNamespace(submit=jobs.append), print, lambda *run, **_: waiting.append(*run))
    state.change(exposure_ev=1.0)
    state.export = replace(state.export, quality=50)
    save = outputs.export_writer()
    state.change(exposure_ev=2.0)
    state.export = replace(state.export, quality=92)
    deeds = [lambda: waiting[0](state.snapshot.picture), lambda: save(tmp_path / "me.jpeg", True)]
    for deed in deeds if is_there else reversed(deeds):
        deed()
    (job,) = jobs
    assert (job.path, job.exposure_ev, job.replaces) == (tmp_path / "me.jpeg", 1.0, True)
    assert (job.settings.form, job.settings.quality) == (".jpg", 50)


def test_a_place_chosen_for_a_picture_that_never_came_is_told_to_get_nothing(state, tmp_path):
    given_up = []
    state.snapshot = replace(state.snapshot, picture=SimpleNamespace(opened=state.snapshot.opened))
    outputs = Outputs(state, None, print, lambda *_, otherwise: given_up.append(otherwise))
    save = outputs.export_writer()
    given_up[0]()
    with pytest.raises(InputError, match="Nothing was saved"):
        save(tmp_path / "me.jpg", False)


def test_a_place_chosen_for_the_next_photo_is_not_that_of_the_one_still_open(state, tmp_path):
    written = []
    outputs = SimpleNamespace(
        export_writer=lambda: lambda path, _: written.append(path), suggested=lambda _: tmp_path / "you.png"
    )
    deeds = Deeds(state, print, None, FileDialogs(False), outputs)
    state.export_path = "best.png"
    state.open_photo(tmp_path / "you.jpg")
    deeds.export_as()
    state.picking.then([tmp_path / "chosen.png"])
    deeds.close()
    assert written == [tmp_path / "chosen.png"]
    assert state.export_path == "best.png"


def test_a_task_that_fails_with_its_picture_is_told_and_the_next_one_goes_on(state):
    said, given = [], []
    opened = state.snapshot.opened
    light = open_light(state.light)
    picture = Picture(opened, light, state.request_at_rest().edit, None, None, opened.photo.linear, {})
    finished = Finished(state, lambda text, is_error: said.append((text, is_error)))

    def fail(_):
        raise ValueError("no such name")

    finished.then(fail)
    finished.then(given.append)
    finished.hand_out(Snapshot(opened=opened, light=light, picture=picture), is_idle=False)
    assert given == [picture]
    assert finished.failures == 1
    ((text, is_error),) = said
    assert "no such name" in text
    assert is_error
    state.photo = PhotoSource(state.photo.path)
    finished.then(given.append)
    finished.hand_out(Snapshot(opened=opened, light=light, picture=replace(picture)), is_idle=True)
    assert (len(given), finished.failures) == (1, 2)
