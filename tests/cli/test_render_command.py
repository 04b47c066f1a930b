"""relight render: what is written, what is told."""

import json
import os
import time

import numpy as np
import pytest
from PIL import Image

from app.document.document import Document, LightRef, PhotoRef
from app.document.light_file import SavedLight, write_light
from app.document.session_file import write_session
from relight_core.face.find import FaceBox
from relight_core.imaging.read import read_radiance
from relight_core.imaging.write import write_image
from relight_core.lighting.light_edit import LightEdit


def test_writes_the_relit_photo_at_its_size(relight, photo, tmp_path):
    out = tmp_path / "relit.png"
    done = relight("render", photo, "--light", "ring", "-o", out)
    assert done.code == 0
    assert Image.open(out).size == (24, 16)
    assert np.array_equal(np.asarray(Image.open(out)), np.asarray(Image.open(photo)))
    assert "relit.png" in done.out


def test_json_is_one_object_and_all_of_stdout(relight, photo, tmp_path):
    out = tmp_path / "relit.png"
    done = relight("render", photo, "--light", "ring", "--json", "-o", out)
    record = json.loads(done.out)
    of_file = {name: record["stages"].pop(name) for name in ("read", "find", "write")}
    assert all(stage["state"] == "computed" and stage["ms"] >= 0 for stage in of_file.values())
    assert record.pop("after_networks_ms") >= of_file["write"]["ms"]
    assert record == {
        "input": str(photo),
        "output": str(out),
        "size": [24, 16],
        "faces": [{"box": [1.0, 2.0, 11.0, 14.0]}],
        "stages": {
            "delight": {"ms": 1.25, "state": "computed", "why": "new photo"},
            "sliders": {"ms": 2.0, "state": "computed", "why": "new light"},
            "compose": {"ms": 0.5, "state": "skipped", "why": "nothing to do"},
        },
        "plan": [
            {
                "effect": "relief",
                "state": "skipped",
                "why": "no need",
                "bound": 0.001,
                "forced": None,
                "saved_ms": 2.5,
            }
        ],
    }


def test_the_file_is_told_from_the_end_of_the_last_network_on(relight, relighter, photo, tmp_path):
    relighter.networks_ended_s = time.perf_counter() - 7.0
    done = relight("render", photo, "--light", "ring", "--json", "-o", tmp_path / "relit.png")
    assert json.loads(done.out)["after_networks_ms"] > 7000.0


def test_json_shares_stdout_with_nobody(relight, relighter, photo, tmp_path, monkeypatch):
    def chatter(portrait, *_which):
        print("printed")
        os.write(1, b"written to the descriptor\n")
        relighter.photo = portrait

    monkeypatch.setattr(relighter, "set_portrait", chatter)
    done = relight("render", photo, "--light", "ring", "--json", "-o", tmp_path / "relit.png")
    assert json.loads(done.out)["size"] == [24, 16]
    assert "printed" in done.err
    assert "written to the descriptor" in done.err


def test_sliders_reach_the_edit(relight, relighter, photo, tmp_path):
    words = "--yaw -90.5 --exposure 1.5 --specular 0 --shadow 2 --background #FF8000 --quality draft"
    words += " --specular-tint -5e-1 --shadow-softness 0.3 --strength 0.6"
    assert relight("render", photo, "--light", "ring", *words.split(), "-o", tmp_path / "o.png").code == 0
    (edit,) = relighter.edits
    assert (edit.yaw_deg, edit.exposure_ev, edit.specular, edit.shadow) == (-90.5, 1.5, 0.0, 2.0)
    assert (edit.specular_tint, edit.shadow_softness, edit.strength) == (-0.5, 0.3, 0.6)
    assert (edit.background, edit.quality) == ("#ff8000", "draft")


def test_the_tolerance_and_the_last_wish_about_each_effect_reach_the_edit(relight, relighter, photo, tmp_path):
    words = "--force shadow=off --force shadow=on --force detail=off --tolerance 2.55"
    assert relight("render", photo, "--light", "ring", *words.split(), "-o", tmp_path / "o.png").code == 0
    (edit,) = relighter.edits
    assert (edit.forced_on, edit.forced_off) == ({"shadow"}, {"detail"})
    assert edit.tolerance == pytest.approx(0.01)


@pytest.mark.parametrize("wish", ["shadow", "shadow=maybe", "glow=on"])
def test_a_wish_that_is_none_names_the_effects(relight, photo, tmp_path, wish):
    done = relight("render", photo, "--light", "ring", "--force", wish, "-o", tmp_path / "o.png")
    assert done.code == 2
    assert "correction" in done.err


def test_a_picture_alone_asks_for_no_channels(relight, relighter, photo, tmp_path):
    relight("render", photo, "--light", "ring", "-o", tmp_path / "o.png")
    assert relighter.edits[0].channels == ()


def test_exposure_multiplies_the_radiance_in_an_exr(relight, photo, tmp_path):
    plain, brighter = tmp_path / "plain.exr", tmp_path / "brighter.exr"
    relight("render", photo, "--light", "ring", "--bits", 32, "-o", plain)
    relight("render", photo, "--light", "ring", "--bits", 32, "--exposure", 2, "-o", brighter)
    assert np.allclose(read_radiance(brighter), read_radiance(plain) * 4.0, rtol=1e-6)


def test_a_light_is_matched_to_the_face_by_its_level(relight, relighter, photo, tmp_path):
    """The relit face of these tests is 1.5 stops brighter than the photo's."""
    relight("render", photo, "--light", "ring", "--match-face", "-o", tmp_path / "o.png")
    as_it_is, matched = (light.level for light in relighter.lights)
    assert matched == pytest.approx(as_it_is * 2**-1.5)
    assert relighter.edits[-1].exposure_ev == 0.0


@pytest.mark.parametrize(("stops", "told"), [(-10.0, 0), (-60.0, 1)])
def test_a_light_in_units_of_its_own_is_matched_or_it_is_told(relight, relighter, photo, tmp_path, stops, told):
    relighter.level_ev = stops
    done = relight("render", photo, "--light", "ring", "--match-face", "-o", tmp_path / "o.png")
    assert done.code == 0
    as_it_is, matched = (light.level for light in relighter.lights)
    assert matched == pytest.approx(as_it_is * 2.0 ** max(stops, -40.0))
    assert done.err.count("\n") == told
    assert done.err.count("photo.png: --match-face changes a light by 40 stops at the most") == told


def test_matching_a_face_hides_nothing_of_what_the_photo_took(relight, photo, tmp_path):
    """The face is matched by a second relighting, which finds most of the first one's stages ready."""
    done = relight("render", photo, "--light", "ring", "--match-face", "--json", "-o", tmp_path / "o.png")
    stages = json.loads(done.out)["stages"]
    assert stages["delight"] == {"ms": 1.25, "state": "computed", "why": "new photo"}
    assert stages["sliders"]["ms"] == 4.0
    assert stages["compose"]["state"] == "skipped"


def test_transparency_reaches_the_file(relight, photo, tmp_path):
    out = tmp_path / "relit.png"
    relight("render", photo, "--light", "ring", "--background", "transparent", "-o", out)
    assert Image.open(out).mode == "RGBA"


def test_the_light_can_be_a_panorama_or_borrowed_from_a_portrait(relight, photo, another_photo, tmp_path):
    from relight_core.imaging.write import write_image

    panorama = tmp_path / "sky.exr"
    write_image(panorama, np.ones((8, 16, 3), np.float32))
    for light in (panorama, another_photo):
        assert relight("render", photo, "--light", light, "-o", tmp_path / "o.png").code == 0
        assert np.array_equal(np.asarray(Image.open(tmp_path / "o.png")), np.asarray(Image.open(photo)))


def test_a_light_of_a_picture_without_a_face_is_refused_without_asking_where_it_is(relight, photo, tmp_path):
    Image.new("RGB", (40, 40)).save(tmp_path / "wall.png")
    refused = relight("render", photo, "--light", tmp_path / "wall.png", "-o", tmp_path / "o.png")
    assert refused.code == 2
    assert "wall.png: no face found to borrow light from" in refused.err


def test_a_session_under_its_original_light_lends_that_of_its_photo(relight, relighter, photo, another_photo, tmp_path):
    session = tmp_path / "another.relight.json"
    write_session(session, Document(PhotoRef(another_photo), LightRef("own"), LightEdit(level_ev=1.0)))
    assert relight("render", photo, "--light", session, "-o", tmp_path / "o.png").code == 0
    assert relighter.estimates == ["final"]
    assert relighter.lights[-1].level == pytest.approx(2 * relighter.estimated_light("final").level)


@pytest.mark.parametrize("quality", ["draft", "final"])
def test_a_light_is_borrowed_as_the_window_does_whatever_the_quality(
    relight, relighter, photo, another_photo, tmp_path, quality
):
    words = "--light", another_photo, "--quality", quality
    assert relight("render", photo, *words, "-o", tmp_path / "o.png").code == 0
    assert relighter.estimates == ["final"]


@pytest.mark.parametrize("out", ["new/folder/", "made", "made/{name}.jpg"])
def test_several_photos_go_to_a_folder_or_a_pattern(relight, photo, another_photo, tmp_path, out):
    (tmp_path / "made").mkdir()
    done = relight("render", photo, another_photo, "--light", "ring", "--json", "-o", f"{tmp_path}/{out}")
    assert done.code == 0
    record = json.loads(done.out)
    assert [result["input"] for result in record["results"]] == [str(photo), str(another_photo)]
    assert all(os.path.getsize(result["output"]) for result in record["results"])
    assert record["errors"] == []


def test_a_bad_photo_among_several_is_told_and_the_others_are_done(relight, photo, tmp_path):
    missing = tmp_path / "missing.jpg"
    done = relight("render", missing, photo, "--light", "ring", "--json", "-o", f"{tmp_path}/out/")
    record = json.loads(done.out)
    assert done.code == 2
    assert [result["input"] for result in record["results"]] == [str(photo)]
    assert [error["input"] for error in record["errors"]] == [str(missing)]
    assert "missing.jpg" in done.err
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["photo.png"]


def test_a_fault_of_ours_among_several_is_told_by_the_exit_code(relight, relighter, photo, another_photo, tmp_path):
    open_it = relighter.set_portrait

    def fails_at_one(portrait, *which):
        if portrait.path == photo:
            raise RuntimeError("a slip")
        open_it(portrait, *which)

    relighter.set_portrait = fails_at_one
    done = relight("render", photo, another_photo, "--light", "ring", "-o", f"{tmp_path}/out/")
    assert done.code == 1
    assert "fault of ours" in done.err
    assert "RELIGHT_DEBUG=1" in done.err
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["another.png"]


def test_one_photo_is_resumed_as_many_are(relight, relighter, photo, tmp_path):
    words = ("render", photo, "--light", "ring", "--resume", "--json", "-o", tmp_path / "relit.png")
    first, then = (json.loads(relight(*words).out) for _ in range(2))
    assert [len(record["results"]) for record in (first, then)] == [1, 0]
    assert then["kept"] == [str(tmp_path / "relit.png")]


def test_several_photos_need_more_than_one_file(relight, photo, another_photo, tmp_path):
    done = relight("render", photo, another_photo, "--light", "ring", "-o", tmp_path / "one.png")
    assert done.code == 2
    assert not (tmp_path / "one.png").exists()


def test_a_box_says_where_the_face_is(relight, relighter, photo, tmp_path):
    assert relight("render", photo, "--light", "rembrandt", "--box", "4,5.5,40,50", "-o", tmp_path / "a.png").code == 0
    assert relighter.boxes == [FaceBox(4, 5.5, 40, 50)]


def test_several_boxes_are_several_faces(relight, relighter, photo, tmp_path):
    words = ["--box", "4,5,40,50", "--box", "-2,5,8,9"]
    assert relight("render", photo, "--light", "rembrandt", *words, "-o", tmp_path / "a.png").code == 0
    assert relighter.boxes == [FaceBox(4, 5, 40, 50), FaceBox(-2, 5, 8, 9)]


def test_a_line_tells_how_large_and_how_good_a_picture_is_and_what_it_took(relight, photo, tmp_path):
    done = relight("render", photo, "--light", "ring", "--quality", "draft", "-o", tmp_path / "a.png")
    assert done.out == f"wrote {tmp_path / 'a.png'} (24 x 16, draft quality, 3 ms)\n"


@pytest.mark.parametrize("command", ["render", "channels", "turntable"])
def test_a_box_can_be_added_to_the_faces_that_are_found(relight, relighter, photo, tmp_path, command):
    words = ["--add-box", "-4,5,12,18", "--add-box", "1,1,9,9", "--face", "1"]
    assert relight(command, photo, "--light", "ring", *words, "-o", tmp_path / "a.png").code == 0
    assert relighter.boxes == [*relighter.people, FaceBox(-4, 5, 12, 18), FaceBox(1, 1, 9, 9)]
    assert relighter.face_index == 1


def test_a_box_is_added_where_no_face_is_found(relight, relighter, photo, tmp_path):
    relighter.people = ()
    words = ["--light", "ring", "--add-box", "4,5,12,18", "-o", tmp_path / "a.png"]
    assert relight("render", photo, *words).code == 0
    assert relighter.boxes == [FaceBox(4, 5, 12, 18)]


def test_a_box_is_added_to_those_that_are_given(relight, relighter, photo, tmp_path):
    words = ["--add-box", "1,1,9,9", "--box", "4,5,40,50"]
    assert relight("render", photo, "--light", "ring", *words, "-o", tmp_path / "a.png").code == 0
    assert relighter.boxes == [FaceBox(4, 5, 40, 50), FaceBox(1, 1, 9, 9)]


@pytest.mark.parametrize("text", ["-10,-20.5,200,200", "-.5,2,40,50"])
@pytest.mark.parametrize("form", ["--box {}", "--box={}"])
def test_a_box_may_begin_outside_the_photo(relight, relighter, photo, tmp_path, text, form):
    words = form.format(text).split()
    assert relight("render", photo, "--light", "rembrandt", *words, "-o", tmp_path / "a.png").code == 0
    assert relighter.boxes == [FaceBox(*(float(edge) for edge in text.split(",")))]


@pytest.mark.parametrize(
    ("option", "value"),
    [("fov", "0"), ("fov", "171"), ("fov", "-5"), ("blur", "-1"), ("blur", "20.5"), ("blur", "nan")],
)
def test_a_view_of_the_light_that_no_camera_has_is_told_before_anything_is_read(relight, tmp_path, option, value):
    wish = f"--background-{option}"
    done = relight("render", "missing.jpg", "--light", "ring", f"{wish}={value}", "-o", tmp_path / "a.png")
    assert done.code == 2
    assert wish in done.err


@pytest.mark.parametrize(
    "wish", [("--box", "1,2,3"), ("--box", "a,b,c,d"), ("--box", "1,2,3,4", "--face", "0"), ("--add-box", "1")]
)
def test_a_box_that_is_none_is_wrong_usage(relight, photo, tmp_path, wish):
    assert relight("render", photo, "--light", "rembrandt", *wish, "-o", tmp_path / "a.png").code == 2


@pytest.fixture
def sky(tmp_path):
    """A panorama four times as bright as the rigs."""
    write_image(tmp_path / "sky.exr", np.full((8, 16, 3), 6.0, np.float32))
    return tmp_path / "sky.exr"


@pytest.mark.parametrize(("command", "output"), [("render", "o.png"), ("turntable", "sheet.png"), ("channels", "all")])
@pytest.mark.parametrize(("words", "level"), [((), 6.0), (("--meter",), 1.5)])
def test_a_panorama_is_as_bright_as_its_file_says_unless_it_is_metered(
    relight, relighter, photo, sky, tmp_path, command, output, words, level
):
    assert relight(command, photo, "--light", sky, *words, "-o", tmp_path / output).code == 0
    assert relighter.lights[-1].level == pytest.approx(level)
    assert relighter.edits[-1].exposure_ev == 0.0


def test_rigs_and_borrowed_light_are_not_metered(relight, relighter, photo, another_photo, tmp_path):
    for light in ("neon", another_photo):
        for words in ((), ("--meter",)):
            assert relight("render", photo, "--light", light, *words, "-o", tmp_path / "o.png").code == 0
        assert relighter.lights[-1].level == relighter.lights[-2].level


@pytest.mark.parametrize(("metered", "level"), [(False, 12.0), (True, 3.0)])
@pytest.mark.parametrize("words", [(), ("--meter",)])
def test_a_saved_light_says_itself_whether_it_is_metered(
    relight, relighter, photo, sky, tmp_path, metered, level, words
):
    saved = SavedLight(LightRef("panorama", str(sky)), LightEdit(level_ev=1.0, metered=metered))
    write_light(tmp_path / "my.light.json", saved)
    assert relight("render", photo, "--light", tmp_path / "my.light.json", *words, "-o", tmp_path / "o.png").code == 0
    assert relighter.lights[-1].level == pytest.approx(level)
