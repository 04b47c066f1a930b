"""Frames of a turning light as they are seen, counted and written."""

from types import SimpleNamespace

import av
import numpy as np
import pytest
from fake_relighter import FakeRelighter

from app.engine.film import write_film
from app.engine.turntable import turning, write_pictures
from relight_core.errors import InputError
from relight_core.imaging.photo import Photo
from relight_core.lighting.rigs import load_rig
from relight_core.pipeline.edit import Edit


@pytest.fixture
def relighter():
    relighter = FakeRelighter()
    relighter.set_portrait(Photo(np.full((33, 47, 3), 0.2, np.float32)))
    return relighter


def unheeded(done, total):
    """Nobody asks."""


def test_frames_are_as_bright_as_the_picture_is_shown(relighter):
    light = load_rig("split")
    plain, brighter = (next(turning(relighter, light, Edit(exposure_ev=stops), None, 2)) for stops in (0.0, 1.0))
    assert brighter.mean() > 1.2 * plain.mean()


def test_frames_are_as_large_as_was_chosen_and_of_the_picture_alone(relighter):
    films, pictures = (next(turning(relighter, load_rig("split"), Edit(), 30, for_film=film)) for film in (True, False))
    assert (films.shape, pictures.shape) == ((20, 30, 3), (21, 30, 3))
    assert [edit.channels for edit in relighter.relights] == [(), ()]


def test_each_written_picture_is_counted(tmp_path):
    told = []
    frames = iter(np.zeros((3, 2, 2, 3), np.uint8))
    write_pictures(tmp_path / "turn", frames, 3, lambda *done: told.append(done), lambda path, frame: path.touch())
    assert told == [(1, 3), (2, 3), (3, 3)]


def test_pictures_may_have_the_longest_name_that_a_folder_can_have(tmp_path):
    folder = tmp_path / ("\N{CJK UNIFIED IDEOGRAPH-7167}" * 85)
    write_pictures(folder, iter(np.zeros((1, 2, 2, 3), np.uint8)), 1, unheeded, lambda path, frame: path.touch())
    assert [path.name for path in folder.iterdir()] == ["0001.png"]


def test_a_place_where_pictures_can_not_be_is_told_by_the_name_that_was_chosen(tmp_path):
    frames = iter(np.zeros((1, 2, 2, 3), np.uint8))
    with pytest.raises(InputError, match=r"gone/turn: can't be made"):
        write_pictures(tmp_path / "gone" / "turn", frames, 1, unheeded, lambda path, frame: path.touch())


def test_where_there_is_no_codec_pictures_are_recommended(tmp_path, monkeypatch):
    monkeypatch.setattr("app.engine.film._CODEC", "none of this name")
    with pytest.raises(InputError, match="no codec for MP4 here; export the turntable as pictures"):
        write_film(tmp_path / "turn.mp4", iter(np.zeros((1, 32, 32, 3), np.uint8)), 1, unheeded)
    assert list(tmp_path.iterdir()) == []


def test_a_film_has_24_frames_a_second_and_begins_to_play_before_all_of_it_is_there(tmp_path):
    told = []
    path = tmp_path / "turn.mp4"
    write_film(path, iter(np.full((48, 32, 32, 3), 90, np.uint8)), 48, lambda *done: told.append(done))
    with av.open(str(path)) as film:
        stream = film.streams.video[0]
        assert (stream.average_rate, float(stream.duration * stream.time_base)) == (24, 2.0)
    content = path.read_bytes()
    assert content.index(b"moov") < content.index(b"mdat")
    assert told[0] == (1, 48)
    assert told[-1] == (48, 48)


def test_a_film_that_fails_as_it_is_encoded_is_told_by_its_name_and_leaves_nothing(tmp_path, monkeypatch):
    def fail(*_, **__):
        raise av.error.ExternalError(1, "no room")

    monkeypatch.setattr(av, "VideoFrame", SimpleNamespace(from_ndarray=fail))
    with pytest.raises(InputError, match=r"turn\.mp4: the film can't be written"):
        write_film(tmp_path / "turn.mp4", iter(np.zeros((1, 32, 32, 3), np.uint8)), 1, unheeded)
    assert list(tmp_path.iterdir()) == []
