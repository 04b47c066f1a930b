"""The shelf of thumbnails: which are kept and which make way, and what of it is told while it is drawn."""

import os
import sys
import threading
from types import SimpleNamespace

import numpy as np
import pytest
from fake_relighter import LONG_S
from PIL import Image

from app.engine import light_shelf
from app.engine.kept_balls import KeptBalls
from app.engine.light_shelf import LightShelf
from app.engine.sources import LightSource

BALL = np.random.default_rng(1).integers(0, 256, (96, 96, 4), dtype=np.uint8)


def test_the_thumbnails_that_were_kept_first_make_way(tmp_path):
    kept = KeptBalls(tmp_path)
    for index in range(33):
        kept.keep("panorama", f"{index}.hdr", BALL)
        for path in tmp_path.glob("*.png"):
            # Files of one moment have no order.
            os.utime(path, (path.stat().st_atime, path.stat().st_mtime - 10))
    later = KeptBalls(tmp_path)
    assert later.ball("panorama", "0.hdr") is None
    assert all(later.ball("panorama", f"{index}.hdr") is not None for index in range(1, 33))


def test_a_thumbnail_is_read_once_and_there_as_soon_as_it_is_kept(tmp_path):
    kept = KeptBalls(tmp_path)
    assert kept.ball("panorama", "sky.hdr") is None
    kept.keep("panorama", "sky.hdr", BALL)
    for path in tmp_path.iterdir():
        path.unlink()
    np.testing.assert_array_equal(kept.ball("panorama", "sky.hdr"), BALL)
    other = 255 - BALL
    kept.keep("panorama", "sky.hdr", other)
    np.testing.assert_array_equal(kept.ball("panorama", "sky.hdr"), other)
    np.testing.assert_array_equal(KeptBalls(tmp_path).ball("panorama", "sky.hdr"), other)


def test_a_light_is_the_same_from_wherever_it_is_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    KeptBalls(tmp_path / "balls").keep("panorama", "sky.hdr", BALL)
    assert KeptBalls(tmp_path / "balls").ball("panorama", str(tmp_path / "sky.hdr")) is not None


@pytest.mark.parametrize("odd", [BALL[:48], BALL[..., :3]])
def test_a_picture_of_another_size_or_kind_is_no_thumbnail(tmp_path, odd):
    KeptBalls(tmp_path).keep("panorama", "sky.hdr", BALL)
    (path,) = tmp_path.glob("*.png")
    Image.fromarray(np.ascontiguousarray(odd)).save(path)
    assert KeptBalls(tmp_path).ball("panorama", "sky.hdr") is None


@pytest.mark.skipif(sys.platform == "darwin" or os.name == "nt", reason="names are text in Unicode there")
def test_a_light_whose_name_is_no_text_has_a_thumbnail_too(tmp_path):
    name = os.fsdecode(b"/lights/sk\xffy.hdr")
    KeptBalls(tmp_path).keep("panorama", name, BALL)
    np.testing.assert_array_equal(KeptBalls(tmp_path).ball("panorama", name), BALL)


@pytest.fixture
def few_rigs(monkeypatch):
    """Three bundled lights, of which the second can't be drawn."""
    names = ("ring", "split", "neon")

    def drawn(name):
        if name == "split":
            raise MemoryError("no room")
        return None, np.zeros((256, 512, 3), np.uint8), BALL

    monkeypatch.setattr(light_shelf, "rig_names", lambda: names)
    monkeypatch.setattr(light_shelf, "rig_for_screen", drawn)
    return names


def test_each_bundled_light_is_told_as_it_is_drawn_past_one_that_fails(few_rigs, caplog):
    woken = []
    shelf = LightShelf(lambda: woken.append(1))
    shelf.wait()
    balls = [shelf.ball(LightSource("rig", name)) for name in few_rigs]
    assert [ball is BALL for ball in balls] == [True, False, True]
    assert balls[1] is None
    assert len(woken) == 3
    assert "no thumbnail of split" in caplog.text
    title, description = shelf.words("ring")
    assert title
    assert description
    assert shelf.words("another") == ("another", "")


def test_a_shelf_that_is_closed_draws_no_more(few_rigs, monkeypatch):
    drawn, closing = [], threading.Event()

    def draw(name):
        drawn.append(name)
        assert closing.wait(LONG_S)
        return None, None, BALL

    monkeypatch.setattr(light_shelf, "rig_for_screen", draw)
    shelf = LightShelf()
    close = threading.Thread(target=shelf.close)
    monkeypatch.setattr(shelf._thread, "join", lambda: closing.set() or threading.Thread.join(shelf._thread))
    close.start()
    close.join()
    assert drawn in ([], ["ring"])


def test_only_lights_of_files_are_kept(few_rigs, tmp_path):
    shelf = LightShelf(folder=tmp_path)
    for light in (LightSource("own"), LightSource("rig", "ring")):
        shelf.keep(SimpleNamespace(source=light, ball=BALL))
    shelf.keep(None)
    assert shelf.ball(LightSource("own")) is None
    shelf.close()
    assert list(tmp_path.glob("*.png")) == []
