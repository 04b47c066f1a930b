"""Taking a portrait stops where nobody waits for it any more, and is then as if it had never been begun."""

from types import SimpleNamespace

import numpy as np
import pytest
from tiny_relighter import EDIT, some_light, some_photo

from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.pipeline import face_search
from relight_core.pipeline.per_photo import choosing_faces
from relight_core.pipeline.per_photo.choosing_faces import choose_faces
from relight_core.unwanted import UnwantedError, stopping_when

FOUND = FaceBox(24, 20, 72, 76)


def from_the(number):
    """Unwanted from the question of that number on."""
    asked = []
    return lambda: asked.append(1) or len(asked) >= number


@pytest.mark.parametrize("number", [1, 2])
def test_the_portrait_before_stays_and_can_be_relit(relighter, number):
    before = relighter.relight(some_light(), EDIT)
    people = relighter.people
    with stopping_when(from_the(number)), pytest.raises(UnwantedError):
        relighter.set_portrait(some_photo(7))
    assert relighter.people == people
    after = relighter.relight(some_light(), EDIT)
    np.testing.assert_array_equal(after.image, before.image)
    assert {stage.state for stage in after.stages.values()} <= {"reused", "skipped"}


def test_a_search_that_was_stopped_is_none_in_vain(relighter, monkeypatch):
    """Of a photo that was searched in vain it is remembered that it shows nobody."""
    photo, evidence = some_photo(7), 0
    monkeypatch.setattr(choosing_faces, "find_faces", lambda photo, *judge: [])
    monkeypatch.setattr(choosing_faces, "guess_faces", lambda photo: [FOUND, FaceBox(4, 4, 20, 20)])
    monkeypatch.setattr(choosing_faces, "guess_companions", lambda photo, known: [])
    monkeypatch.setattr(face_search, "evidence_of_face", lambda labels, view, crop: evidence)
    monkeypatch.setattr(face_search, "glimpses_of_face", lambda parsing, view, crop: evidence)
    with stopping_when(from_the(2)), pytest.raises(UnwantedError):
        relighter.set_portrait(photo)
    evidence = 3
    relighter.set_portrait(photo)
    assert [(face.x0, face.y0) for face in relighter.people] == [(24, 20)]


def test_companions_of_a_face_are_looked_for_again_where_the_search_for_them_was_stopped(monkeypatch):
    photo, companion = Photo(np.zeros((20, 20, 3), np.float32)), FaceBox(10, 0, 18, 8, doubtful=True)
    hit = SimpleNamespace(box=np.array([0.0, 0.0, 9.0, 9.0]), votes=20, cascades=3, roll_deg=0.0)
    monkeypatch.setattr("relight_core.face.find.frontal_candidates", lambda *_: [hit])
    monkeypatch.setattr("relight_core.face.find._turned_away", lambda grey: [])
    monkeypatch.setattr("relight_core.face.find._LEAST_SIDE_PX", 1)
    monkeypatch.setattr(choosing_faces, "guess_companions", lambda photo, known: [companion])

    def stop(box):
        raise UnwantedError

    eyes = SimpleNamespace(evidence=lambda box: 2, glimpse=lambda box: 0, look_closer=stop)
    with pytest.raises(UnwantedError):
        choose_faces(photo, eyes)
    eyes.look_closer = lambda box: 3
    assert len(choose_faces(photo, eyes)) == 2
    assert len(choose_faces(photo, eyes)) == 2
