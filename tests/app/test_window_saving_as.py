"""Save as, films and lights: what was wanted at the wish is written, and nothing is replaced unasked."""

import threading

import numpy as np
import pytest
from fake_relighter import LONG_S
from PIL import Image

from app.document.light_file import read_light
from app.ui.export_name import choose_form
from app.ui.file_dialogs import FileDialogs
from app.window import outputs
from relight_core.imaging.write import write_image
from relight_core.pipeline.auto_quality import QualityChoice

BRIGHT = 0.9


@pytest.fixture
def saving(opened, monkeypatch):
    """The window with a photo, our own file dialogs, and films that take no time."""
    opened.window._deeds._dialogs = FileDialogs(False)

    def film(path, frames, count, control):
        path.write_bytes(b"film")

    def pictures(folder, frames, count, control, write):
        folder.mkdir()

    monkeypatch.setattr(outputs, "write_film", film)
    monkeypatch.setattr(outputs, "write_pictures", pictures)
    return opened


def ask(hand, wish):
    hand.window.state.asking.wish(wish)
    hand.frames(2)
    request, hand.window.state.picking = hand.window.state.picking, None
    return request


def open_another(hand, tmp_path):
    other = tmp_path / "other.png"
    write_image(other, np.full((50, 40, 3), BRIGHT, np.float32))
    hand.drop(other)
    return other


def size_of(path):
    with Image.open(path) as picture:
        return picture.size


@pytest.mark.parametrize(
    ("wish", "names"),
    [
        ("export_as", ["person-relit-2.png", "person-relit.png"]),
        ("turntable_film", ["person-relit-turntable-2.mp4", "person-relit-turntable.mp4"]),
    ],
)
def test_two_wishes_while_a_job_runs_make_two_files(saving, photo_path, wish, names):
    go_on, places = threading.Event(), []
    saving.window.exporter.start("Batch", lambda control: "done" if go_on.wait(LONG_S) else "")
    for _ in range(2):
        request = ask(saving, wish)
        places.append(request.start.name)
        request.then([request.start])
        saving.settle()
    assert places == [names[1], names[1]]
    assert saving.window.state.asking.questions == []
    go_on.set()
    saving.window.exporter.close()
    assert sorted(path.name for path in photo_path.parent.glob("person-relit*")) == names


def test_numbered_pictures_asked_for_twice_make_two_folders(saving, photo_path):
    go_on = threading.Event()
    saving.window.exporter.start("Batch", lambda control: "done" if go_on.wait(LONG_S) else "")
    for _ in range(2):
        saving.window.state.asking.wish("turntable_pictures")
        saving.settle()
    go_on.set()
    saving.window.exporter.close()
    folders = sorted(path.name for path in photo_path.parent.iterdir() if path.is_dir())
    assert folders == ["person-relit-turntable", "person-relit-turntable-2"]


def test_the_picture_of_the_wish_is_saved_though_another_photo_is_open_by_the_answer(saving, photo_path, tmp_path):
    there = photo_path.with_name("there.png")
    write_image(there, np.zeros((4, 4, 3), np.float32))
    request = ask(saving, "export_as")
    request.then([there])
    open_another(saving, tmp_path)
    saving.answer("Replace")
    saving.window.exporter.close()
    assert size_of(there) == (128, 96)
    assert size_of(photo_path) == (128, 96)


def test_the_picture_of_the_wish_is_saved_though_another_photo_is_open_by_the_place(saving, photo_path, tmp_path):
    request = ask(saving, "export_as")
    open_another(saving, tmp_path)
    request.then([photo_path.with_name("chosen")])
    saving.settle()
    saving.window.exporter.close()
    assert size_of(photo_path.with_name("chosen.png")) == (128, 96)
    assert saving.window.state.export_path == "other-relit.png"


def test_the_sliders_of_the_wish_are_in_the_file(saving, photo_path):
    state = saving.window.state
    state.change(yaw_deg=35.0, exposure_ev=1.0)
    request = ask(saving, "export_as")
    state.change(yaw_deg=-70.0, exposure_ev=-2.0)
    saving.settle()
    request.then([request.start])
    saving.settle()
    saving.window.exporter.close()
    with Image.open(photo_path.with_name("person-relit.png")) as picture:
        assert (float(picture.text["relightYawDeg"]), float(picture.text["relightExposureEv"])) == (35.0, 1.0)


@pytest.mark.parametrize(("wish", "quality"), [("draft", "draft"), ("auto", "final")])
def test_a_film_is_relit_at_the_quality_that_is_chosen(saving, relighter, monkeypatch, wish, quality):
    saving.window.state.quality = QualityChoice(wish)
    saving.settle()
    before = len(relighter.relights)
    monkeypatch.setattr(outputs, "write_film", lambda path, frames, count, control: next(frames))
    request = ask(saving, "turntable_film")
    request.then([request.start])
    saving.settle()
    saving.window.exporter.close()
    assert [edit.quality for edit in relighter.relights[before:]] == [quality]


def test_a_jpeg_keeps_the_name_it_was_given(saving, photo_path):
    choose_form(saving.window.state, ".jpg")
    ask(saving, "export_as").then([photo_path.with_name("mine.jpeg")])
    saving.settle()
    saving.window.exporter.close()
    assert size_of(photo_path.with_name("mine.jpeg")) == (128, 96)


def test_a_place_named_as_another_kind_of_picture_makes_one_of_that_kind(saving, photo_path):
    ask(saving, "export_as").then([photo_path.with_name("mine.tif")])
    saving.settle()
    saving.window.exporter.close()
    with Image.open(photo_path.with_name("mine.tif")) as picture:
        assert (picture.format, picture.size) == ("TIFF", (128, 96))
    assert (saving.window.state.export.form, saving.window.state.export_path) == (".tif", "mine.tif")


def test_the_light_of_the_wish_is_saved(saving, tmp_path):
    saving.light("split")
    request = ask(saving, "save_light")
    saving.light("butterfly")
    request.then([tmp_path / "mine"])
    assert read_light(tmp_path / "mine.light.json").light.name == "split"


def test_only_replace_replaces(saving, photo_path):
    there = photo_path.with_name("there.png")
    there.write_bytes(b"mine")
    for label in ("Keep both", "Cancel"):
        ask(saving, "export_as").then([there])
        saving.answer(label)
    saving.window.exporter.close()
    assert there.read_bytes() == b"mine"
    assert size_of(photo_path.with_name("there-2.png")) == (128, 96)
