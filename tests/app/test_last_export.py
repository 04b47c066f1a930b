"""How pictures were saved last comes back at the next start."""

import json
from dataclasses import replace
from types import SimpleNamespace

import glfw
import pytest
from opened_things import open_light, opened_for
from window_hand import HEIGHT, WIDTH, Hand

from app.engine.exporting import ExportSettings
from app.engine.snapshot import Picture, Snapshot
from app.engine.sources import PhotoSource
from app.ui.export_name import choose_form
from app.ui.state import EditorState
from app.window.last_export import LastExport, read_last_export
from app.window.outputs import Outputs
from app.window.window import EditorWindow

LAYERS = ("albedo", "matte")
CHOSEN = ExportSettings(".tif", True, 70, 2048, "photo", LAYERS)
USUAL = ExportSettings()


@pytest.fixture
def state(photos):
    source = PhotoSource(photos[0])
    opened, state = opened_for(source), EditorState(photo=source)
    light = open_light(state.light)
    picture = Picture(opened, light, state.request_at_rest().edit, None, SimpleNamespace(), opened.screen, {})
    state.snapshot = Snapshot(opened=opened, light=light, picture=picture)
    return state


@pytest.fixture
def outputs(state, folder):
    """Whose exporter does nothing; all that is set in the panel was chosen after the start."""
    outputs = Outputs(state, SimpleNamespace(submit=print, start=print), print, folder=folder)
    state.export = CHOSEN
    return outputs


def at_the_next_start(folder):
    state = EditorState()
    Outputs(state, None, print, folder=folder)
    return state.export


@pytest.mark.parametrize(
    ("save", "kept"),
    [
        (lambda outputs, path: outputs.export(".tif"), CHOSEN),
        (lambda outputs, path: outputs.export(".exr"), CHOSEN),
        (lambda outputs, path: outputs.export_writer()(path, True), replace(CHOSEN, form=".jpg")),
        (lambda outputs, path: outputs.film_writer()(path.with_suffix(".mp4"), True), CHOSEN),
        (lambda outputs, path: outputs.batch_over([path], path.parent), CHOSEN),
        (lambda outputs, path: None, USUAL),
    ],
    ids=["as set", "once as EXR", "under a name", "turntable", "batch", "nothing was saved"],
)
def test_the_next_start_has_the_settings_that_were_saved_with_last(outputs, folder, photos, save, kept):
    save(outputs, photos[1])
    assert at_the_next_start(folder) == kept


def test_what_is_chosen_after_a_picture_was_saved_is_not_there_at_the_next_start(outputs, state, folder):
    outputs.export(".tif")
    state.export = replace(state.export, quality=90)
    assert at_the_next_start(folder) == CHOSEN


def test_of_two_windows_the_one_that_saved_a_picture_last_is_remembered(tmp_path):
    one, other = (LastExport(tmp_path / "last.json") for _ in range(2))
    one.keep(USUAL)
    other.keep(CHOSEN)
    one.keep(USUAL)
    assert read_last_export(tmp_path / "last.json") == USUAL


@pytest.mark.parametrize("content", ["", "{", "[]", "7", "null", "\x00\xff", "[" * 99999, '{"form": NaN}'])
def test_a_damaged_file_stops_nothing_and_is_mended_by_the_next_export(tmp_path, content):
    path, state = tmp_path / "last.json", EditorState()
    path.write_bytes(content.encode("latin-1"))
    last = LastExport(path)
    last.recall(state)
    assert state.export == USUAL
    last.keep(CHOSEN)
    assert read_last_export(path) == CHOSEN


@pytest.mark.parametrize(
    ("name", "bad"),
    [
        *[("form", value) for value in (".bmp", "", None, 1, [".png"], {})],
        *[("deep", value) for value in (1, 0, "yes", None, [])],
        *[("quality", value) for value in (49, 101, 70.0, True, "70", None, float("nan"), 10**30)],
        *[("longest_side", value) for value in (0, 2047, 2048.0, True, "2048", [], float("inf"))],
        *[("profile", value) for value in ("p3", None, 0, ["srgb"])],
        *[("layers", value) for value in ("matte", None, 3, {"matte": 1})],
    ],
)
def test_each_wrong_value_alone_is_as_it_usually_is(tmp_path, name, bad):
    path = tmp_path / "last.json"
    LastExport(path).keep(CHOSEN)
    path.write_text(json.dumps({**json.loads(path.read_text()), name: bad, "of a later version": 1}))
    assert read_last_export(path) == replace(CHOSEN, **{name: getattr(USUAL, name)})


def test_layers_that_are_not_known_here_are_left_out_and_the_others_keep_their_order(tmp_path):
    (tmp_path / "last.json").write_text('{"layers": ["matte", "depth", ["albedo"], "albedo", "matte", 3]}')
    assert read_last_export(tmp_path / "last.json") == replace(USUAL, layers=LAYERS)


def test_a_folder_that_can_not_be_written_to_stops_no_export(state, tmp_path):
    (tmp_path / "file").write_bytes(b"no folder")
    (tmp_path / "taken" / "last-export.json").mkdir(parents=True)
    for folder in (tmp_path / "file", tmp_path / "taken"):
        jobs = []
        outputs = Outputs(state, SimpleNamespace(submit=jobs.append), print, folder=folder)
        assert state.export == USUAL
        state.export = CHOSEN
        outputs.export(".tif")
        assert len(jobs) == 1
        state.export = USUAL


def test_a_window_exports_as_the_one_before_it_did_and_lets_the_next_one_know(windows, relighter, photo_path, folder):
    LastExport(folder / "last-export.json").keep(replace(USUAL, form=".jpg"))
    paths = {"settings_path": folder / "settings.json"}
    window = EditorWindow(lambda: relighter, photo_path, size=(WIDTH, HEIGHT), **paths)
    try:
        hand = Hand(window, (WIDTH, HEIGHT))
        hand.settle()
        assert (window.state.export.form, window.state.export_path) == (".jpg", "person-relit.jpg")
        choose_form(window.state, ".tif")
        hand.key(glfw.KEY_E)
    finally:
        window.close()
    assert at_the_next_start(folder) == replace(USUAL, form=".tif")
