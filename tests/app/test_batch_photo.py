"""One photo of a batch: under which light it is relit, and what of it is in its file."""

import re
from dataclasses import replace

import numpy as np
import pytest
from fake_relighter import FakeRelighter
from opened_things import open_light
from PIL import Image

from app.document.document import Document, LightRef, PhotoRef
from app.engine.exporting import ExportSettings
from app.engine.sources import LightSource
from app.window.batch_photo import BatchLights, relight_as
from relight_core.errors import InputError
from relight_core.face.find import FaceBox
from relight_core.imaging.files import KnownFiles
from relight_core.lighting.light_edit import LightEdit
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.per_photo.brush import BrushStroke

RING, OWN = LightRef("rig", "ring"), LightRef("own", "")
MAKE = 0x010F


@pytest.fixture
def photo(tmp_path):
    notes = Image.Exif()
    notes[MAKE] = "Maker"
    path = tmp_path / "me.png"
    Image.fromarray(np.full((96, 128, 3), 90, np.uint8)).save(path, exif=notes)
    return path


@pytest.fixture
def lights():
    """The ring light is open, as it is."""
    return BatchLights(open_light(LightSource("rig", "ring")))


@pytest.mark.parametrize("light", [RING, LightRef("rig", "rim")])
def test_a_light_has_what_each_photo_changed_about_it_be_it_the_one_that_is_open_or_not(photo, lights, light):
    levels = [
        lights.of(Document(PhotoRef(photo), light, LightEdit(level_ev=stops)), FakeRelighter()).level
        for stops in (0.0, 1.0)
    ]
    assert levels[1] == pytest.approx(2.0 * levels[0])


def test_what_a_photo_changed_about_the_open_light_is_no_change_of_what_the_open_photo_made_of_it(photo):
    ring = open_light(LightSource("rig", "ring"))
    brighter = replace(ring, edit=LightEdit(level_ev=2.0), environment=ring.environment.at_level(4.0))
    document = Document(PhotoRef(photo), RING, LightEdit(level_ev=1.0))
    assert BatchLights(brighter).of(document, FakeRelighter()).level == pytest.approx(2.0 * ring.base.level)


def test_of_photos_that_borrow_the_light_of_others_each_is_relit_itself_and_each_lender_read_once(photo, lights):
    lenders = [photo.with_name(f"lender{index}.png") for index in (0, 1)]
    for index, lender in enumerate(lenders):
        Image.fromarray(np.full((48, 64, 3), 60 + 60 * index, np.uint8)).save(lender)
    relighter = FakeRelighter()
    for index, lender in enumerate((*lenders, *lenders)):
        document = Document(PhotoRef(photo), LightRef("portrait", str(lender)))
        output = photo.with_name(f"relit{index}.png")
        relight_as(document, lights, relighter, output, ExportSettings(".png"), KnownFiles([photo]))
        assert Image.open(output).size == (128, 96)
    read = [portrait.path for portrait, *_ in relighter.portraits]
    assert read == [lenders[0], photo, lenders[1], photo, photo, photo]


@pytest.mark.parametrize("written_over", ["me.png", "you.png"])
def test_no_photo_is_written_over_by_its_own_picture_or_by_another_s(photo, lights, written_over):
    other = photo.with_name("you.png")
    other.write_bytes(photo.read_bytes())
    before, place, photos = photo.read_bytes(), photo.with_name(written_over), KnownFiles([photo, other])
    with pytest.raises(InputError, match=f"{written_over}: one of the photos is there"):
        relight_as(Document(PhotoRef(photo), RING), lights, FakeRelighter(), place, ExportSettings(".png"), photos)
    assert place.read_bytes() == before


def test_the_photo_s_own_light_and_exposure_are_as_they_were_left_and_its_notes_go_along(photo, lights):
    relighter, means = FakeRelighter(), []
    for stops in (0.0, 1.0):
        document = Document(PhotoRef(photo), OWN, LightEdit(level_ev=stops), Edit(quality="final", exposure_ev=stops))
        output = photo.with_name(f"relit{stops}.png")
        relight_as(document, lights, relighter, output, ExportSettings(".png"), KnownFiles([photo]))
        with Image.open(output) as picture:
            means.append(np.asarray(picture, np.float32).mean())
            assert picture.getexif()[MAKE] == "Maker"
    assert relighter.environments[1].level == pytest.approx(2.0 * relighter.environments[0].level)
    assert [edit.exposure_ev for edit in relighter.relights] == [0.0, 0.0]
    assert means[1] > 1.2 * means[0]


@pytest.mark.parametrize(("quality", "at_rest"), [("auto", "final"), ("draft", "draft")])
def test_the_faces_the_outline_and_the_quality_are_those_of_the_photo(photo, lights, quality, at_rest):
    boxes, strokes = (FaceBox(0, 0, 30, 30), FaceBox(40, 0, 70, 30)), (BrushStroke(((1.0, 1.0),), 3.0, True),)
    document = Document(PhotoRef(photo, 1, boxes, strokes=strokes), RING, quality=quality)
    relighter, output = FakeRelighter(), photo.with_name("relit.png")
    relight_as(document, lights, relighter, output, ExportSettings(".png"), KnownFiles([photo]))
    ((_, face_index, relit_boxes),) = relighter.portraits
    assert (face_index, relit_boxes, relighter.strokes) == (1, boxes, strokes)
    assert [edit.quality for edit in relighter.relights] == [at_rest]


@pytest.mark.parametrize(
    ("size", "seen", "told"),
    [
        ((64, 48), (0, (FaceBox(20, 10, 60, 50),), (BrushStroke(((2.0, 4.0),), 6.0, True),)), "64 by 48 .* scaled to"),
        ((64, 64), (None, (FaceBox(32, 16, 96, 80),), ()), "64 by 64 .* left out: boxes of faces"),
    ],
)
def test_faces_and_outline_of_a_photo_that_was_resized_are_where_they_belong_or_left_out_and_that_is_told(
    photo, lights, size, seen, told
):
    boxes, strokes = (FaceBox(10, 5, 30, 25),), (BrushStroke(((1.0, 2.0),), 3.0, True),)
    document = Document(PhotoRef(photo, 0, boxes, strokes=strokes, size=size), RING)
    relighter, output = FakeRelighter(), photo.with_name("relit.png")
    note = relight_as(document, lights, relighter, output, ExportSettings(".png"), KnownFiles([photo]))
    ((_, face_index, relit_boxes),) = relighter.portraits
    assert (face_index, relit_boxes, relighter.strokes) == seen
    assert re.match(f"{photo}: was {told}", note)


@pytest.mark.parametrize(("settings", "channels"), [(ExportSettings(".exr"), None), (ExportSettings(".png"), ())])
def test_the_channels_that_a_kind_of_file_holds_are_asked_for(photo, lights, settings, channels):
    relighter, output = FakeRelighter(), photo.with_name(f"relit{settings.form}")
    relight_as(Document(PhotoRef(photo), RING), lights, relighter, output, settings, KnownFiles([photo]))
    assert [edit.channels for edit in relighter.relights] == [channels]
    assert output.exists()
