"""Thumbnails of lights from files, from one run to the next."""

import struct
import zlib
from types import SimpleNamespace

import numpy as np
import pytest

from app.engine.kept_balls import KeptBalls
from app.engine.light_shelf import LightShelf
from app.engine.sources import LightSource

BALL = np.random.default_rng(1).integers(0, 256, (96, 96, 4), dtype=np.uint8)


def test_a_kept_ball_comes_back_for_that_light_alone(tmp_path):
    KeptBalls(tmp_path / "yet" / "to make").keep("portrait", "a/friend.jpg", BALL)
    later = KeptBalls(tmp_path / "yet" / "to make")
    np.testing.assert_array_equal(later.ball("portrait", "a/friend.jpg"), BALL)
    assert later.ball("panorama", "a/friend.jpg") is None
    assert later.ball("portrait", "b/friend.jpg") is None


def png(width, *others):
    """A PNG file of a width that holds no pixels but other chunks."""
    chunks = (b"IHDR", struct.pack(">IIBBBBB", width, width, 8, 6, 0, 0, 0)), *others, (b"IDAT", b""), (b"IEND", b"")
    parts = (struct.pack(">I", len(p)) + kind + p + struct.pack(">I", zlib.crc32(kind + p)) for kind, p in chunks)
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


@pytest.mark.parametrize(
    "damage",
    [
        *(b"", b"no picture", b"\x89PNG\r\n\x1a\n" + b"\x00" * 40),
        *(png(60_000), png(96, (b"zTXt", b"a\0\0" + zlib.compress(bytes(2_000_000)))), png(96, (b"\0\1\2\3", b""))),
    ],
    ids=["empty", "no picture", "no header", "too many pixels", "too long a text", "no name of a chunk"],
)
def test_a_damaged_one_is_not_there_and_is_replaced(tmp_path, damage):
    KeptBalls(tmp_path).keep("panorama", "sky.hdr", BALL)
    (path,) = tmp_path.glob("*.png")
    path.write_bytes(damage)
    again = KeptBalls(tmp_path)
    assert again.ball("panorama", "sky.hdr") is None
    again.keep("panorama", "sky.hdr", BALL)
    np.testing.assert_array_equal(KeptBalls(tmp_path).ball("panorama", "sky.hdr"), BALL)


def test_the_folder_does_not_grow_without_end_and_a_place_that_is_none_is_survived(tmp_path):
    kept = KeptBalls(tmp_path / "balls")
    for index in range(36):
        kept.keep("panorama", f"{index}.hdr", BALL)
    assert len(list((tmp_path / "balls").iterdir())) == 32
    (tmp_path / "file").write_text("")
    KeptBalls(tmp_path / "file").keep("panorama", "sky.hdr", BALL)


def test_the_shelf_knows_the_lights_of_files(tmp_path):
    KeptBalls(tmp_path).keep("panorama", "sky.hdr", BALL)
    shelf = LightShelf(folder=tmp_path)
    np.testing.assert_array_equal(shelf.ball(LightSource("panorama", "sky.hdr")), BALL)
    assert shelf.ball(LightSource("own")) is None
    shelf.close()


@pytest.mark.parametrize("kind", ["panorama", "portrait"])
def test_the_shelf_keeps_what_lights_of_files_look_like(tmp_path, kind):
    source = LightSource(kind, "a/light.exr")
    shelf = LightShelf(folder=tmp_path)
    shelf.keep(SimpleNamespace(source=source, ball=BALL))
    shelf.close()
    again = LightShelf(folder=tmp_path)
    np.testing.assert_array_equal(again.ball(source), BALL)
    again.close()
