"""What a dropped file becomes."""

from pathlib import Path

import numpy as np
import pytest

from app.ui.state import EditorState
from app.window.dropped import is_panorama, take_files
from relight_core.imaging.write import write_image

ELSEWHERE = (500.0, 300.0)


@pytest.fixture
def state():
    return EditorState(light_panel=(0.0, 0.0, 255.0, 560.0))


def exr(path, height, width):
    write_image(path, np.ones((height, width, 3), np.float32))
    return path


def test_only_an_exr_twice_as_wide_as_high_is_a_panorama(tmp_path):
    assert is_panorama(exr(tmp_path / "a.exr", 8, 16))
    assert not is_panorama(exr(tmp_path / "b.exr", 8, 15))
    (tmp_path / "c.exr").write_bytes(b"junk")
    assert not is_panorama(tmp_path / "c.exr")
    assert is_panorama(Path("studio.HDR"))
    assert not is_panorama(Path("me.jpg"))


def test_a_photo_and_a_light_together_open_both(state, tmp_path):
    lamp = exr(tmp_path / "lamp.exr", 4, 8)
    take_files(state, [Path("me.jpg"), lamp], *ELSEWHERE)
    assert state.photo.path == Path("me.jpg")
    assert (state.light.kind, state.light.name) == ("panorama", str(lamp))


def test_what_falls_on_the_light_panel_is_a_light(state):
    take_files(state, [Path("friend.jpg")], 100.0, 100.0)
    assert state.photo is None
    assert (state.light.kind, state.light.name) == ("portrait", "friend.jpg")
