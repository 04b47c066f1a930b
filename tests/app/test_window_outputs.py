"""Files of pictures, asked for in the real window at any moment."""

import threading

import glfw
import numpy as np
import pytest
from fake_relighter import LONG_S
from PIL import Image

from app.engine.sources import LightSource
from app.ui.export_name import choose_form
from app.ui.news import put_message_away
from relight_core.errors import InputError
from relight_core.imaging.view_transform import apply_view
from relight_core.imaging.write import write_image
from relight_core.lighting.light_edit import LightEdit
from relight_core.pipeline.auto_quality import QualityChoice


def saved(path):
    with Image.open(path) as picture:
        picture.load()
        return np.asarray(picture.convert("RGB"), np.float32) / 255, float(picture.text["relightYawDeg"])


@pytest.fixture
def busy(opened, relighter):
    """The window after the light was turned by 35 degrees, of which nothing has been relit yet."""
    relighter.gate.clear()
    opened.move(opened.centre())
    opened.window.on_wheel(None, 0.0, 7.0)
    opened.frames(3)
    return opened


def press(hand, key):
    hand.hold(key)
    hand.release(key)


def finish(hand, relighter):
    relighter.gate.set()
    hand.settle()
    hand.window.exporter.close()


def test_an_export_right_after_a_change_is_the_changed_picture(busy, relighter, photo_path):
    press(busy, glfw.KEY_E)
    finish(busy, relighter)
    pixels, yaw_deg = saved(photo_path.with_name("person-relit.png"))
    picture = busy.window.state.snapshot.picture
    assert yaw_deg == busy.window.state.edit.yaw_deg == 35.0
    assert picture.edit.yaw_deg == 35.0
    assert np.abs(pixels - apply_view(picture.relit.image)).max() < 0.6 / 255


def test_an_export_is_made_of_a_window_that_was_minimised_meanwhile(busy, relighter, photo_path):
    press(busy, glfw.KEY_E)
    busy.window.on_minimise(None, True)
    finish(busy, relighter)
    assert saved(photo_path.with_name("person-relit.png"))[1] == 35.0


def test_another_name_typed_meanwhile_is_that_of_the_next_export(busy, relighter, photo_path):
    press(busy, glfw.KEY_E)
    busy.frames(2)
    busy.window.state.export_path = "second.png"
    busy.window.on_wheel(None, 0.0, 1.0)
    busy.frames(2)
    press(busy, glfw.KEY_E)
    finish(busy, relighter)
    assert saved(photo_path.with_name("person-relit.png"))[1] == 35.0
    assert saved(photo_path.with_name("second.png"))[1] == 40.0


def test_another_photo_opened_meanwhile_does_not_get_into_the_export(busy, relighter, photo_path, tmp_path):
    other = tmp_path / "other.png"
    write_image(other, np.full((50, 40, 3), 0.2, np.float32))
    press(busy, glfw.KEY_E)
    busy.window.on_drop(None, [str(other)], busy.centre())
    busy.frames(2)
    finish(busy, relighter)
    pixels, yaw_deg = saved(photo_path.with_name("person-relit.png"))
    assert (pixels.shape, yaw_deg) == ((96, 128, 3), 35.0)
    assert not other.with_name("other-relit.png").exists()
    assert busy.window.state.snapshot.opened.source.path == other


@pytest.mark.parametrize("wish", ["draft", "live"])
def test_a_changed_light_is_in_the_export_at_every_quality(opened, photo_path, wish):
    state = opened.window.state
    state.quality, state.light_edit = QualityChoice(wish), LightEdit(warmth=0.5)
    press(opened, glfw.KEY_E)
    opened.settle()
    opened.window.exporter.close()
    assert photo_path.with_name("person-relit.png").exists(), state.message()


def test_what_can_not_be_relit_is_not_saved_and_that_is_told(busy, relighter, photo_path):
    relighter.fail_with = InputError("no room")
    press(busy, glfw.KEY_E)
    finish(busy, relighter)
    assert list(photo_path.parent.glob("*-relit*")) == []
    assert "Nothing was saved" in busy.window.state.message().text


@pytest.fixture
def lost_light(opened, photo_path, monkeypatch):
    """The window on its way to a light that can't be had, and what lets that turn out."""
    goes_on = threading.Event()

    def read(path):
        assert goes_on.wait(LONG_S)
        raise InputError(f"{path}: no light")

    monkeypatch.setattr("relight_core.lighting.environment.read_environment", read)
    opened.window.state.open_light(LightSource("panorama", str(photo_path.with_name("sky.hdr"))))
    opened.frames(3)
    yield opened, goes_on
    goes_on.set()


def test_nothing_is_saved_under_another_light_than_was_wanted_and_why_is_told(lost_light, photo_path):
    opened, goes_on = lost_light
    press(opened, glfw.KEY_E)
    goes_on.set()
    opened.settle()
    opened.window.exporter.close()
    assert list(photo_path.parent.glob("*-relit*")) == []
    first, second = opened.window.state.message().text.splitlines()
    assert first == "Nothing was saved: the light sky can't be had"
    assert second.endswith("sky.hdr: no light")


def test_a_place_chosen_once_the_light_is_lost_is_told_that_nothing_is_saved(lost_light, photo_path, monkeypatch):
    opened, goes_on = lost_light
    monkeypatch.setattr(opened.window._deeds._dialogs, "_has_native", False)
    opened.window.state.asking.wish("export_as")
    opened.frames(2)
    request, opened.window.state.picking = opened.window.state.picking, None
    goes_on.set()
    opened.settle()
    put_message_away(opened.window.state)
    request.then([photo_path.with_name("chosen.png")])
    opened.settle()
    assert opened.window.state.message().text.startswith("Nothing was saved")
    assert not photo_path.with_name("chosen.png").exists()


@pytest.fixture
def shoot(tmp_path):
    """A folder with three photos, two of one name, and a broken file."""
    folder = tmp_path / "shoot"
    folder.mkdir()
    for name, value in (("a.png", 0.2), ("a.tif", 0.4), ("b.png", 0.3)):
        write_image(folder / name, np.full((20, 24, 3), value, np.float32))
    (folder / "c.jpg").write_bytes(b"no picture")
    return folder


def batch(hand, monkeypatch, folder):
    monkeypatch.setattr(hand.window._deeds._dialogs, "_has_native", False)
    hand.key(glfw.KEY_B, ctrl=True)
    request, hand.window.state.picking = hand.window.state.picking, None
    request.then([folder])
    hand.settle()


def wait_for_jobs(hand):
    jobs = hand.window.exporter
    done = jobs._pool.submit(lambda: None)
    done.result(60)
    hand.settle()


def test_a_batch_gives_photos_of_one_name_a_file_each_and_says_why_one_failed(opened, monkeypatch, shoot):
    batch(opened, monkeypatch, shoot)
    wait_for_jobs(opened)
    outputs = {path.name: saved(path)[0].mean() for path in (shoot / "relit").iterdir()}
    assert sorted(outputs) == ["a-png.png", "a-tif.png", "b.png"]
    assert outputs["a-png.png"] < outputs["b.png"] < outputs["a-tif.png"]
    message = opened.window.state.message()
    first, reason = message.text.splitlines()
    assert first.startswith("3 photos relit; 1 could not be relit: c.jpg.")
    assert "c.jpg: not an image" in reason
    assert message.is_error


@pytest.mark.parametrize(("wish", "quality"), [("draft", "draft"), ("auto", "final")])
def test_a_batch_is_relit_at_the_quality_that_is_chosen(opened, relighter, monkeypatch, shoot, wish, quality):
    opened.window.state.quality = QualityChoice(wish)
    opened.settle()
    before = len(relighter.relights)
    batch(opened, monkeypatch, shoot)
    wait_for_jobs(opened)
    assert [edit.quality for edit in relighter.relights[before:]] == [quality] * 3


def test_a_batch_over_pictures_that_are_there_asks_first(opened, monkeypatch, shoot):
    (shoot / "c.jpg").unlink()
    batch(opened, monkeypatch, shoot)
    wait_for_jobs(opened)
    (shoot / "relit" / "b.png").unlink()
    opened.window.state.change(yaw_deg=90.0)
    batch(opened, monkeypatch, shoot)
    opened.answer("Cancel")
    wait_for_jobs(opened)
    assert not (shoot / "relit" / "b.png").exists()
    batch(opened, monkeypatch, shoot)
    opened.answer("Relight the other 1")
    wait_for_jobs(opened)
    turns = {path.name: saved(path)[1] for path in (shoot / "relit").iterdir()}
    assert turns == {"a-png.png": 0.0, "a-tif.png": 0.0, "b.png": 90.0}
    batch(opened, monkeypatch, shoot)
    opened.answer("Replace")
    wait_for_jobs(opened)
    assert {saved(path)[1] for path in (shoot / "relit").iterdir()} == {90.0}


def test_a_batch_makes_the_kind_of_file_it_asked_about(opened, monkeypatch, shoot):
    (shoot / "c.jpg").unlink()
    batch(opened, monkeypatch, shoot)
    wait_for_jobs(opened)
    (shoot / "relit" / "b.png").unlink()
    batch(opened, monkeypatch, shoot)
    choose_form(opened.window.state, ".jpg")
    opened.answer("Relight the other 1")
    wait_for_jobs(opened)
    assert sorted(path.name for path in (shoot / "relit").iterdir()) == ["a-png.png", "a-tif.png", "b.png"]
