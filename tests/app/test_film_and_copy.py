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


@pytest.mark.parametrize(("side", "px"), [(None, 1080), (2048, 2048)])
def test_a_film_is_of_the_faces_and_strokes_at_the_size_and_exposure_that_are_set(
    state, relighter, turned, tmp_path, side, px
):
    state.export = replace(state.export, longest_side=side)
    save = Outputs(state, AtOnce(), lambda: relighter).film_writer()
    state.change(exposure_ev=-3.0)
    save(tmp_path / "turn.mp4", False)
    assert turned == [(30.0, 1.0, px, True)]
    assert [portrait[1:] for portrait in relighter.portraits] == [(1, BOXES)]
    assert relighter.strokes == STROKES
    assert (tmp_path / "turn.mp4").read_bytes() == b"film"


def test_pictures_of_a_turntable_take_a_free_folder(state, relighter, turned, tmp_path):
    (tmp_path / "turn").mkdir()
    exporter = AtOnce()
    Outputs(state, exporter, lambda: relighter).film_writer()(tmp_path / "turn", False)
    assert turned == [(30.0, 1.0, 1080, False)]
    assert exporter.said == f"Saved {tmp_path / 'turn-2'}"
    assert len(list((tmp_path / "turn-2").iterdir())) == 1


def test_a_copy_is_as_bright_as_the_picture_is_shown(state, relighter, monkeypatch, tmp_path):
    copied = []
    monkeypatch.setattr(module, "copy_png", copied.append)
    Outputs(state, AtOnce(), lambda: relighter).copy_picture()
    (tmp_path / "copy.png").write_bytes(copied[0])
    assert Image.open(io.BytesIO(copied[0])).size == (4, 4)
    assert read_photo(tmp_path / "copy.png").linear == pytest.approx(0.2, abs=0.01)
