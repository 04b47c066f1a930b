"""Faces told by a parsing that is drawn, in views of several sizes."""

import numpy as np
import pytest

from relight_core.errors import NoFaceError
from relight_core.face.crop import Crop
from relight_core.face.find import FaceBox
from relight_core.face.parsing import INDEX
from relight_core.imaging.photo import Photo
from relight_core.pipeline.face_search import FaceSearch

NIGHT = Photo(np.zeros((1000, 1000, 3), np.float32))
SIZE, GUESS = 128, FaceBox(450, 450, 550, 550, doubtful=True)
PARTS = (
    ("background", 0, 0, 1000, 1000),
    ("hair", 420, 400, 580, 600),
    ("skin", 450, 425, 550, 570),
    ("right_eye", 462, 474, 486, 482),
    ("left_eye", 514, 474, 538, 482),
    ("lips", 476, 530, 524, 540),
)
BROWS = (("right_brow", 462, 458, 486, 463), ("left_brow", 514, 458, 538, 463))


class Drawn(FaceSearch):
    """Sees a drawing of a face; brows only where a view shows them large enough."""

    def __init__(self, certainty, widest_with_brows, parts=PARTS, photo=NIGHT):
        super().__init__(None, photo)
        self.certainty, self.widest_with_brows, self.parts = certainty, widest_with_brows, parts

    def _parse(self, view):
        labels = np.zeros((SIZE, SIZE), int)
        for name, x0, y0, x1, y1 in self.parts + (BROWS if view.side <= self.widest_with_brows else ()):
            corners = np.array([[x0, y0], [x1, y1]], float)
            (left, top), (right, bottom) = np.clip(np.round(view.from_photo(corners, SIZE)), 0, SIZE).astype(int)
            labels[top:bottom, left:right] = INDEX[name]
        probability = np.full((14, SIZE, SIZE), (1 - self.certainty) / 13, np.float32)
        np.put_along_axis(probability, labels[None], self.certainty, 0)
        return probability


def companions(monkeypatch, search):
    known = FaceBox(50, 450, 150, 550)
    chooser = "relight_core.pipeline.per_photo.choosing_faces"
    monkeypatch.setattr(f"{chooser}.find_faces", lambda photo, is_face: [known, FaceBox(0, 0, 9, 9, doubtful=True)])
    monkeypatch.setattr(f"{chooser}.guess_companions", lambda photo, faces: [GUESS])
    monkeypatch.setattr(f"{chooser}.guess_faces", lambda photo: [])
    return [face for face in search.faces() if face.x0 == GUESS.x0]


@pytest.mark.parametrize(("certainty", "found"), [(0.75, True), (0.5, False)])
def test_a_face_beside_others_has_to_be_told_with_certainty(monkeypatch, certainty, found):
    assert bool(companions(monkeypatch, Drawn(certainty, 1000))) == found


def test_a_face_seen_whole_counts_though_its_framing_is_too_wide_to_show_it_so(monkeypatch):
    without_eyes = (*PARTS[:3], PARTS[5])
    between_both_views = 300
    assert companions(monkeypatch, Drawn(0.75, 1000, without_eyes))
    assert not companions(monkeypatch, Drawn(0.75, 0, without_eyes))
    assert companions(monkeypatch, Drawn(0.75, between_both_views, without_eyes))


def test_paper_shows_nobody_whatever_the_parsing_sees_in_it(monkeypatch):
    """Where the cascades see nothing, places that parsing maps agree on are faces; white ones showed one too."""
    chooser = "relight_core.pipeline.per_photo.choosing_faces"
    for look in ("guess_faces", "guess_companions", "find_small_faces"):
        monkeypatch.setattr(f"{chooser}.{look}", lambda *asked: [])
    monkeypatch.setattr(f"{chooser}.find_faces", lambda photo, is_face: [])
    grain = np.random.default_rng(0).uniform(-1, 0, (1000, 1000, 1)).astype(np.float32)

    def search(contrast):
        return Drawn(0.75, 1000, photo=Photo(np.repeat(1 + contrast * grain, 3, axis=2)))

    assert len(search(0.3).faces()) == 1
    for contrast in (0.0, 0.05):
        with pytest.raises(NoFaceError):
            search(contrast).faces()


def test_a_view_is_read_once_however_often_it_is_asked_about(monkeypatch):
    search, read = Drawn(0.75, 1000), []
    parse = search._parse
    monkeypatch.setattr(search, "_parse", lambda view: read.append(view) or parse(view))
    view, other = Crop(500.0, 500.0, 300.0), Crop(500.0, 500.0, 320.0)
    for asked in (view, other, Crop(500.0, 500.0, 300.0)):
        np.testing.assert_array_equal(search.labels(asked), search.parsing(asked).argmax(0))
    assert read == [view, other]


@pytest.mark.parametrize(
    ("alpha", "told"),
    [(1 / 255, "its alpha is nowhere above 0.4 %; export it without alpha"), (0.75, "say where it is")],
)
def test_of_a_photo_that_is_hardly_there_it_is_told_that_nobody_is_found_for_its_alpha(monkeypatch, alpha, told):
    for look in ("find_faces", "find_small_faces", "guess_faces"):
        monkeypatch.setattr(f"relight_core.pipeline.per_photo.choosing_faces.{look}", lambda *asked: [])
    hidden = Photo(NIGHT.linear, np.full((1000, 1000), alpha, np.float32))
    with pytest.raises(NoFaceError, match=told):
        Drawn(0.75, 0, PARTS[:1], hidden).faces()
