"""A batch over photos without a window: what it replaces, how far it says it is, and what it says at the end."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
from fake_relighter import FakeRelighter
from opened_things import open_light, opened_for
from PIL import Image

from app.document.document import Document, PhotoRef
from app.engine.exporting import ExportSettings
from app.engine.jobs import Cancelled
from app.engine.snapshot import Picture, Snapshot
from app.engine.sources import PhotoSource
from app.ui.asking import Asking
from app.ui.open_work import KeptWork
from app.ui.state import EditorState
from app.window.batching import relight_many
from app.window.outputs import Outputs
from relight_core.errors import InputError
from relight_core.face.find import FaceBox
from relight_core.pipeline.edit import Edit

NAMES = ("a.png", "b.png", "c.png")


class Exporter:
    """Runs a job while it is handed over, and keeps how far it was; `during` is called at each step.

    Attributes:
        unneeded: at each step, for how many of them there was nothing to do.
    """

    def __init__(self):
        self.steps, self.unneeded, self.during = [], [], lambda done: None

    def start(self, name, work):
        self.said = work(SimpleNamespace(step=self._step))

    def _step(self, done, total, unneeded=0):
        self.steps.append((done, total))
        self.unneeded.append(unneeded)
        self.during(done)


@pytest.fixture
def photos(tmp_path):
    for name in NAMES:
        Image.new("RGB", (128, 96), (120, 80, 60)).save(tmp_path / name)
    return [tmp_path / name for name in NAMES]


@pytest.fixture
def exporter():
    return Exporter()


@pytest.fixture
def outputs(photos, exporter):
    source = PhotoSource(photos[0])
    opened = opened_for(source)
    state = EditorState(photo=source)
    light = open_light(state.light)
    picture = Picture(opened, light, Edit(), None, SimpleNamespace(), opened.screen, {})
    state.snapshot = Snapshot(opened=opened, light=light, picture=picture)
    state.export = replace(state.export, form=".png")
    return Outputs(state, exporter, FakeRelighter)


def test_what_another_window_has_made_while_a_batch_runs_is_not_replaced(outputs, exporter, photos, tmp_path):
    folder, other = tmp_path / "relit", tmp_path / "relit" / "b.png"

    def make_another(done):
        if done == 1:
            other.write_bytes(b"another's")

    exporter.during = make_another
    outputs.batch_over(photos, folder)
    assert other.read_bytes() == b"another's"
    assert exporter.said == f"2 photos relit; 1 was done already. They are in {folder}"
    assert exporter.unneeded == [0, 0, 1, 1]
    exporter.during = lambda done: None
    outputs.batch_over(photos, folder, replaces=True)
    assert other.read_bytes() != b"another's"
    assert exporter.said == f"3 photos relit. They are in {folder}"


def test_a_batch_tells_how_far_it_is_and_counts_what_was_there(outputs, exporter, photos, tmp_path):
    folder = tmp_path / "relit"
    folder.mkdir()
    (folder / "c.png").write_bytes(b"there")
    assert outputs.done_already(photos, folder) == (1, 0)
    outputs.batch_over(photos, folder)
    assert exporter.steps == [(1, 3), (2, 3), (3, 3)]
    assert exporter.unneeded == [1, 1, 1]
    assert (folder / "c.png").read_bytes() == b"there"


def test_a_batch_names_the_photos_that_failed_and_says_why(outputs, exporter, photos, tmp_path):
    photos[1].write_bytes(b"no pixels")
    with pytest.raises(InputError) as failure:
        outputs.batch_over(photos, tmp_path / "relit")
    told, reason = failure.value.args
    assert told == f"2 photos relit; 1 could not be relit: b.png. They are in {tmp_path / 'relit'}"
    assert str(photos[1]) in reason
    assert exporter.steps[-1] == (3, 3)
    assert sorted(path.name for path in (tmp_path / "relit").iterdir()) == ["a.png", "c.png"]


@pytest.mark.parametrize("fails", [False, True])
def test_a_batch_tells_which_photo_was_resized_since_its_faces_were_corrected(
    outputs, exporter, photos, tmp_path, fails
):
    boxes = (FaceBox(10.0, 10.0, 20.0, 20.0),)
    work = Document(PhotoRef(photos[1], None, boxes, size=(256, 192)), edit=Edit(quality="final", shadow=0.5))
    outputs._state.works[photos[1]] = KeptWork(None, Document(PhotoRef(photos[1])), work)
    if fails:
        photos[2].write_bytes(b"no pixels")
        with pytest.raises(InputError) as failure:
            outputs.batch_over(photos, tmp_path / "relit")
        lines = failure.value.args
    else:
        outputs.batch_over(photos, tmp_path / "relit")
        lines = exporter.said.split("\n")
    note = "was 256 by 192 pixels when it was worked on and is 128 by 96 now; scaled to that: boxes of faces"
    assert lines[-1] == f"{photos[1]}: {note}"
    assert len(lines) == 2 + fails


def test_a_batch_whose_folder_can_not_be_made_says_so_before_any_photo_is_relit(outputs, exporter, photos, tmp_path):
    (tmp_path / "relit").write_bytes(b"a file")
    with pytest.raises(InputError, match=r"relit: can't be made \(File exists\); choose another folder"):
        outputs.batch_over(photos, tmp_path / "relit")
    assert (exporter.steps, (tmp_path / "relit").read_bytes()) == ([], b"a file")


def test_a_batch_into_the_photos_own_folder_writes_over_none_of_them(outputs, exporter, photos, tmp_path):
    before = [photo.read_bytes() for photo in photos]
    with pytest.raises(InputError, match="3 could not be relit") as failure:
        outputs.batch_over(photos, tmp_path, replaces=True)
    assert all("one of the photos is there" in reason for reason in failure.value.args[1:])
    assert [photo.read_bytes() for photo in photos] == before


def test_a_batch_is_saved_as_it_was_set_when_it_was_asked_for(outputs, exporter, photos, tmp_path):
    outputs.batch_over(photos, tmp_path / "relit", settings=ExportSettings(".jpg"))
    assert sorted(path.name for path in (tmp_path / "relit").iterdir()) == ["a.jpg", "b.jpg", "c.jpg"]


@pytest.fixture
def waiting(exporter):
    """The jobs that were handed over, none of which has begun."""
    jobs = []
    exporter.start = lambda name, work: jobs.append(work)
    return jobs


def test_a_batch_asks_about_pictures_that_one_before_has_yet_to_make(outputs, waiting, photos, tmp_path):
    asking = Asking()
    relight_many(photos[:2], outputs, asking)
    assert (len(waiting), asking.questions) == (1, [])
    relight_many(photos, outputs, asking)
    (question,) = asking.questions
    will = ", or will once the batch before is done."
    assert question.text == f"2 of these 3 photos have pictures in {tmp_path / 'relit'}{will}"
    assert [label for label, _ in question.choices] == ["Relight the other 1", "Replace", "Cancel"]
    assert len(waiting) == 1


def test_what_a_batch_that_was_cancelled_did_not_make_is_awaited_no_more(outputs, waiting, photos, tmp_path):
    outputs.batch_over(photos, tmp_path / "relit")
    assert outputs.done_already(photos, tmp_path / "relit") == (0, 3)

    def stop(done, total, unneeded):
        raise Cancelled

    with pytest.raises(Cancelled):
        waiting[0](SimpleNamespace(step=stop))
    assert outputs.done_already(photos, tmp_path / "relit") == (0, 0)


def test_a_batch_whose_light_never_comes_is_not_awaited(outputs, photos, tmp_path):
    given_up = []
    outputs._when_finished = lambda task, otherwise: given_up.append(otherwise)
    outputs.batch_over(photos, tmp_path / "relit")
    assert outputs.done_already(photos, tmp_path / "relit") == (0, 3)
    given_up[0]()
    assert outputs.done_already(photos, tmp_path / "relit") == (0, 0)
