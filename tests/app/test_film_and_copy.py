"""A turntable and a copy are of the picture as it is set: its faces, strokes, exposure and size."""

import io
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from fake_relighter import FakeRelighter
from opened_things import open_light, opened_for
from PIL import Image

from app.document.document import PhotoRef
from app.engine.snapshot import Picture, Snapshot
from app.ui.state import EditorState
from app.window import outputs as module
from app.window.outputs import Outputs
from relight_core.errors import InputError
from relight_core.face.find import FaceBox
from relight_core.imaging.read import read_photo
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.per_photo.brush import BrushStroke

BOXES = (FaceBox(0.0, 0.0, 2.0, 2.0), FaceBox(2.0, 0.0, 4.0, 2.0))
STROKES = (BrushStroke(((1.0, 1.0),), 3.0, True),)
GREY = np.full((4, 4, 3), 100, np.uint8)


class AtOnce:
    """Stands for the exporter: runs a job while it is handed over."""

    def start(self, name, work):
        self.said = work(SimpleNamespace(step=lambda done, total: None))


@pytest.fixture
def relighter():
    return FakeRelighter()


@pytest.fixture
def state(tmp_path):
    source = PhotoRef(tmp_path / "us.jpg", 1, BOXES, strokes=STROKES).wish()
    opened, edit = opened_for(source), Edit(yaw_deg=30.0)
    relit = SimpleNamespace(image=np.full((4, 4, 3), 0.1, np.float32), alpha=None, full=None)
    picture = Picture(opened, open_light(EditorState().light), edit, None, relit, opened.screen, {})
    state = EditorState(photo=source, edit=replace(edit, exposure_ev=1.0))
    state.snapshot = Snapshot(opened=opened, light=picture.light, picture=picture)
    return state


@pytest.fixture
def turned(monkeypatch):
    """What each turntable was made of."""
    turned = []

    def turning(relighter, light, edit, side, for_film=True):
        turned.append((edit.yaw_deg, edit.exposure_ev, side, for_film))
        return iter([GREY])

    monkeypatch.setattr(module, "turning", turning)
    monkeypatch.setattr(module, "write_film", lambda path, frames, count, step: path.write_bytes(b"film"))
    return turned


@pytest.mark.parametrize(("side", "px", "name"), [(None, 1080, "turn.mp4"), (2048, 2048, "TURN.MP4")])
def test_a_film_is_of_the_faces_and_strokes_at_the_size_and_exposure_that_are_set(
    state, relighter, turned, tmp_path, side, px, name
):
    state.export = replace(state.export, longest_side=side)
    save = Outputs(state, AtOnce(), lambda: relighter).film_writer()
    state.change(exposure_ev=-3.0)
    save(tmp_path / name, False)
    assert turned == [(30.0, 1.0, px, True)]
    assert [portrait[1:] for portrait in relighter.portraits] == [(1, BOXES)]
    assert relighter.strokes == STROKES
    assert (tmp_path / name).read_bytes() == b"film"


def test_a_film_that_is_asked_for_while_a_photo_of_another_size_opens_is_of_its_faces_where_they_are(
    state, relighter, turned, tmp_path
):
    source = PhotoRef(tmp_path / "us.jpg", 0, (FaceBox(0.0, 1.0, 4.0, 8.0),), size=(8, 8)).wish()
    opened = opened_for(source)
    state.snapshot = replace(state.snapshot, picture=replace(state.snapshot.picture, opened=opened), opened=opened)
    Outputs(state, AtOnce(), lambda: relighter).film_writer()(tmp_path / "turn.mp4", False)
    assert [portrait[1:] for portrait in relighter.portraits] == [(0, (FaceBox(0.0, 0.5, 2.0, 4.0),))]


@pytest.mark.parametrize(("replaces", "held"), [(False, b"another"), (True, b"film")])
def test_a_film_replaces_another_only_where_that_was_agreed_to(state, relighter, turned, tmp_path, replaces, held):
    exporter, place = AtOnce(), tmp_path / "turn.mp4"
    place.write_bytes(b"another")
    Outputs(state, exporter, lambda: relighter).film_writer()(place, replaces)
    assert place.read_bytes() == held
    assert exporter.said == f"Saved {place if replaces else tmp_path / 'turn-2.mp4'}"


def test_pictures_of_a_turntable_are_as_transparent_as_they_were_made(state, relighter, monkeypatch, tmp_path):
    frame = np.dstack([GREY, np.full((4, 4), 51, np.uint8)])
    frame[0, :, 3] = 255
    monkeypatch.setattr(module, "turning", lambda *_, **__: iter([frame]))
    Outputs(state, AtOnce(), lambda: relighter).film_writer()(tmp_path / "turn", False)
    assert np.array_equal(np.asarray(Image.open(tmp_path / "turn" / "0001.png")), frame)


def test_pictures_of_a_turntable_take_a_free_folder(state, relighter, turned, tmp_path):
    (tmp_path / "turn").mkdir()
    exporter = AtOnce()
    Outputs(state, exporter, lambda: relighter).film_writer()(tmp_path / "turn", False)
    assert turned == [(30.0, 1.0, 1080, False)]
    assert exporter.said == f"Saved {tmp_path / 'turn-2'}"
    assert len(list((tmp_path / "turn-2").iterdir())) == 1


@pytest.mark.parametrize("wish", ["copy_picture", "film_writer", "export_writer"])
def test_without_a_picture_there_is_nothing_to_make_a_file_of(state, relighter, wish):
    state.snapshot = replace(state.snapshot, picture=None)
    with pytest.raises(InputError, match="no relit picture yet"):
        getattr(Outputs(state, AtOnce(), lambda: relighter), wish)()


def test_a_copy_is_as_bright_as_the_picture_is_shown(state, relighter, monkeypatch, tmp_path):
    copied = []
    monkeypatch.setattr(module, "copy_png", copied.append)
    Outputs(state, AtOnce(), lambda: relighter).copy_picture()
    (tmp_path / "copy.png").write_bytes(copied[0])
    assert Image.open(io.BytesIO(copied[0])).size == (4, 4)
    assert read_photo(tmp_path / "copy.png").linear == pytest.approx(0.2, abs=0.01)
