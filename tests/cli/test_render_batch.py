"""relight render over folders: past bad files, resumed, and under a light saved in the editor."""

import json
import os
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from app.cli.main import main
from app.cli.outputs import plan_outputs
from app.cli.session import Session
from app.document.document import Document, LightRef, PhotoRef
from app.document.light_file import SavedLight, write_light
from app.document.session_file import write_session
from relight_core.face.find import FaceBox
from relight_core.lighting.environment import network_light
from relight_core.lighting.light_edit import LightEdit
from relight_core.lighting.rigs import load_rig
from relight_core.lighting.soft_box import SoftBox
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.per_photo.brush import BrushStroke


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "shoot"
    folder.mkdir()
    for index, name in enumerate(("a.png", "b.png")):
        pixels = np.random.default_rng(index).integers(40, 200, (16, 24, 3), dtype=np.uint8)
        Image.fromarray(pixels).save(folder / name)
    (folder / "bad.jpg").write_bytes(b"no pixels")
    (folder / "notes.txt").touch()
    return folder


def render(folder, tmp_path, *more):
    return main(["render", str(folder), "--light", "ring", "-o", f"{tmp_path / 'out'}/", *more])


def test_a_folder_is_relit_past_its_bad_file_and_resumed(relighter, folder, tmp_path, capsys):
    assert render(folder, tmp_path) == 2
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["a.png", "b.png"]
    told = capsys.readouterr().err
    assert "bad.jpg" in told
    assert "2 photos relit; 1 could not be relit: bad.jpg" in told
    (folder / "bad.jpg").unlink()
    (tmp_path / "out" / "b.png").unlink()
    done = len(relighter.edits)
    assert render(folder, tmp_path, "--resume", "--json") == 0
    record = json.loads(capsys.readouterr().out)
    assert len(relighter.edits) == done + 1
    assert [os.path.basename(result["output"]) for result in record["results"]] == ["b.png"]
    assert [os.path.basename(path) for path in record["kept"]] == ["a.png"]


@pytest.mark.skipif(os.name == "nt", reason="names there have no line ends")
def test_a_photo_whose_name_breaks_its_line_is_told_of_in_one(relighter, folder, tmp_path, capsys):
    (folder / "bad.jpg").unlink()
    (folder / "b.png").rename(folder / "b\n\x1b[31m.png")
    for word, more in (("wrote", ()), ("kept", ("--resume",))):
        assert render(folder, tmp_path, *more) == 0
        told = [line for line in capsys.readouterr().out.splitlines() if word in line]
        assert len(told) == 2
        assert "b\N{REPLACEMENT CHARACTER}\N{REPLACEMENT CHARACTER}[31m.png" in told[1]
    assert (tmp_path / "out" / "b\n\x1b[31m.png").exists()


def test_an_empty_folder_is_told(relighter, tmp_path, capsys):
    (tmp_path / "empty").mkdir()
    assert render(tmp_path / "empty", tmp_path) == 2
    assert "no photos" in capsys.readouterr().err


def test_a_saved_light_lights_with_its_boxes_and_turn(tmp_path):
    edit = LightEdit(base=0.0, boxes=(SoftBox(0.0, 0.0, 20.0, 20.0),))
    write_light(tmp_path / "mine.light.json", SavedLight(LightRef("rig", "ring"), edit, 90.0))
    session = Session()
    unturned = session.light(str(tmp_path / "mine.light.json"))
    light = network_light(unturned, session.turned(Edit(yaw_deg=0.0)).yaw_deg)
    assert abs(int(light.sum(axis=(0, 2)).argmax()) - 7.5) <= 1
    (tmp_path / "me.jpg").write_bytes(b"pixels")
    document = Document(PhotoRef(tmp_path / "me.jpg"), LightRef("rig", "ring"), LightEdit(), Edit(quality="final"))
    write_session(tmp_path / "me.relight.json", document)
    assert np.array_equal(
        network_light(Session().light(str(tmp_path / "me.relight.json"))), network_light(load_rig("ring"))
    )


@pytest.mark.parametrize(("command", "output"), [("render", "o.png"), ("turntable", "sheet.png"), ("channels", "all")])
def test_a_saved_turn_is_added_to_the_yaw_as_the_window_turns_it(relighter, folder, tmp_path, command, output):
    write_light(tmp_path / "mine.light.json", SavedLight(LightRef("rig", "ring"), LightEdit(), 33.3))
    words = [command, str(folder / "a.png"), "--light", str(tmp_path / "mine.light.json"), "--yaw", "10"]
    assert main([*words, "-o", str(tmp_path / output)]) == 0
    assert relighter.edits[0].yaw_deg == pytest.approx(43.3)


def test_corrections_of_a_session_that_lends_its_light_count_for_their_own_photo_only(relighter, folder, tmp_path):
    boxes, strokes = (FaceBox(1.0, 2.0, 9.0, 10.0),), (BrushStroke(((3.0, 4.0),), 2.0, False),)
    corrected = PhotoRef(folder / "a.png", 0, boxes, strokes=strokes)
    document = Document(corrected, LightRef("rig", "ring"), LightEdit(), Edit())
    write_session(tmp_path / "a.relight.json", document)

    def boxes_for(photo, *more):
        command = ["render", str(photo), "--light", str(tmp_path / "a.relight.json"), "-o", str(tmp_path / "o.png")]
        assert main([*command, *more]) == 0
        return relighter.boxes

    assert boxes_for(folder / "b.png") is None
    assert relighter.strokes == ()
    assert boxes_for(folder / "a.png") == boxes
    assert relighter.strokes == strokes
    assert boxes_for(folder / "a.png", "--box", "3,3,8,8") == [FaceBox(3, 3, 8, 8)]
    assert relighter.strokes == strokes
    assert boxes_for(folder / "a.png", "--add-box", "3,3,8,8") == [*boxes, FaceBox(3, 3, 8, 8)]
    assert relighter.strokes == strokes
    other_way = tmp_path / "by another way"
    other_way.symlink_to(folder)
    assert boxes_for(other_way / "a.png") == boxes
    named_so = replace(document, photo=replace(corrected, path=other_way / "a.png"))
    write_session(tmp_path / "a.relight.json", named_so)
    assert boxes_for(folder / "a.png") == boxes


def test_corrections_of_a_session_fit_a_photo_that_was_resized_or_are_left_out_and_that_is_told(
    relighter, folder, tmp_path, capsys
):
    boxes, strokes = (FaceBox(1.0, 2.0, 9.0, 10.0),), (BrushStroke(((3.0, 4.0),), 2.0, False),)
    light = tmp_path / "a.relight.json"
    words = ["render", str(folder / "a.png"), "--light", str(light), "-o", str(tmp_path / "o.png")]
    with Image.open(folder / "a.png") as photo:
        width, height = photo.size

    def told_of(size):
        work = PhotoRef(folder / "a.png", 0, boxes, strokes=strokes, size=size)
        write_session(light, Document(work, LightRef("rig", "ring")))
        assert main(words) == 0
        return capsys.readouterr().err

    assert "warning" not in told_of((width, height))
    told = told_of((2 * width, 2 * height))
    assert f"a.png: was {2 * width} by {2 * height} pixels" in told
    assert told.count("scaled to that") == 1
    assert relighter.boxes == (FaceBox(0.5, 1.0, 4.5, 5.0),)
    assert relighter.strokes == (BrushStroke(((1.5, 2.0),), 1.0, False),)
    assert "left out: boxes of faces, strokes" in told_of((2 * width, 4 * height))
    assert (relighter.boxes, relighter.strokes) == (None, ())


def test_what_a_saved_light_was_mended_of_is_told(relighter, folder, tmp_path, capsys):
    path = tmp_path / "mine.light.json"
    write_light(path, SavedLight(LightRef("rig", "ring")))
    path.write_text(json.dumps(json.loads(path.read_text()) | {"sparkle": 1}))
    assert main(["render", str(folder / "a.png"), "--light", str(path), "-o", str(tmp_path / "o.png")]) == 0
    assert "mine.light.json: unknown setting sparkle was left out" in capsys.readouterr().err


def test_where_a_session_s_box_shows_no_face_the_mend_is_told_unless_there_is_another_box(relighter, tmp_path, capsys):
    flat, saved = tmp_path / "flat.png", tmp_path / "flat.relight.json"
    Image.new("RGB", (24, 16), (90, 90, 90)).save(flat)
    work = Document(PhotoRef(flat, 0, (FaceBox(1.0, 2.0, 9.0, 10.0),)), LightRef("rig", "ring"), LightEdit(), Edit())
    write_session(saved, work)
    for words, is_told in ((), True), (("--box", "3,3,8,8"), False), (("--add-box", "3,3,8,8"), False):
        assert main(["render", str(flat), "--light", str(saved), *words, "-o", str(tmp_path / "o.png")]) == 2
        assert ("--box says it anew" in capsys.readouterr().err) == is_told


def test_where_a_session_s_boxes_are_no_good_its_name_is_told(relighter, folder, tmp_path, capsys):
    photo = folder / "a.png"
    document = Document(PhotoRef(photo, None, ()), LightRef("rig", "ring"), LightEdit(), Edit())
    write_session(tmp_path / "a.relight.json", document)
    Image.new("RGB", (8, 8)).save(photo)
    words = ["render", str(photo), "-o", str(tmp_path / "o.png"), "--light"]
    assert main([*words, "ring"]) == 2
    assert "says where" not in capsys.readouterr().err
    assert main([*words, str(tmp_path / "a.relight.json")]) == 2
    assert "the light's session says where faces are in it" in capsys.readouterr().err
    assert main([*words, str(tmp_path / "a.relight.json"), "--box", "1,1,5,5"]) == 2
    assert "says where" not in capsys.readouterr().err


def test_a_damaged_or_missing_light_file_is_told_in_a_line(relighter, folder, tmp_path, capsys):
    (tmp_path / "x.json").write_text("{")
    for name in ("x.json", "missing.json"):
        assert (
            main(["render", str(folder / "a.png"), "--light", str(tmp_path / name), "-o", str(tmp_path / "o.png")]) == 2
        )
        told = capsys.readouterr().err
        assert told.count("\n") == 1
        assert name in told


def test_photos_of_one_name_get_a_file_each(relighter, tmp_path):
    shoot = tmp_path / "phone"
    shoot.mkdir()
    for index, name in enumerate(("IMG_1.jpg", "IMG_1.png", "img_1.tif", "b.png")):
        pixels = np.random.default_rng(index).integers(40, 200, (16, 24, 3), dtype=np.uint8)
        Image.fromarray(pixels).save(shoot / name)
    assert render(shoot, tmp_path) == 0
    expected = ["IMG_1-jpg.png", "IMG_1-png.png", "b.png", "img_1-tif.png"]
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == expected
    assert len(relighter.edits) == 4


@pytest.mark.parametrize(
    "names", [("one/a.jpg", "two/a.jpg", "three/a.jpg"), ("A.jpg", "a.jpg", "a.JPG"), ("a-jpg.png", "a.jpg", "a.png")]
)
def test_photos_of_one_name_have_the_same_file_in_whatever_order_they_are_given(tmp_path, names):
    photos = [tmp_path / name for name in names]
    places = dict(zip(photos, plan_outputs(photos, f"{tmp_path}/out/"), strict=True))
    assert len({str(place).lower() for place in places.values()}) == 3
    assert dict(zip(photos[::-1], plan_outputs(photos[::-1], f"{tmp_path}/out/"), strict=True)) == places


def test_a_name_made_for_one_photo_is_not_another_s(tmp_path):
    photos = [tmp_path / name for name in ("a.jpg", "A.png", "a-jpg.png", "b.png")]
    (tmp_path / "one").mkdir()
    for out in (f"{tmp_path}/new/", str(tmp_path / "one"), f"{tmp_path}/{{name}}.exr"):
        names = [path.stem for path in plan_outputs([*photos, tmp_path / "other" / "b.png"], out)]
        assert names == ["a-jpg", "A-png", "a-jpg-2", "b-png", "b-png-2"]
