"""A search for faces that nobody waits for any more stops, and leaves no trace."""

import cv2
import numpy as np
import pytest
import skimage

from relight_core.face.cascades import every_hit, every_profile_hit
from relight_core.face.find import (
    FaceBox,
    find_faces,
    find_faces_beyond_doubt,
    find_small_faces,
    guess_companions,
    guess_faces,
)
from relight_core.imaging.photo import Photo
from relight_core.unwanted import UnwantedError, stop_if_unwanted, stopping_when

SEARCHES = {
    "faces": find_faces,
    "small faces": find_small_faces,
    "guesses": guess_faces,
    "companions": lambda photo: guess_companions(photo, [FaceBox(20, 20, 30, 30)]),
}


def grainy_photo():
    grain = np.random.default_rng(1).uniform(0.1, 0.9, (150, 120, 1)).astype(np.float32)
    return Photo(np.repeat(np.repeat(np.repeat(grain, 8, 0), 8, 1), 3, 2))


class Cascade:
    """One that sees nothing, or a face that many of its windows hit."""

    def __init__(self):
        self.sees_a_face = False

    def detectMultiScale2(self, *_):
        return (((100, 100, 200, 200),), (40,)) if self.sees_a_face else ((), ())


@pytest.fixture
def cascade(monkeypatch):
    cascade = Cascade()
    monkeypatch.setattr("relight_core.face.cascades._cascade", lambda name: cascade)
    return cascade


class Asked:
    """Answers that the result is unwanted from the question of a number on."""

    def __init__(self, stops_at=None):
        self.count, self.stops_at = 0, stops_at

    def __call__(self):
        self.count += 1
        return self.count == self.stops_at


@pytest.mark.parametrize("name", SEARCHES)
def test_a_search_asks_again_and_again_and_stops_where_it_is_told(name, cascade):
    with stopping_when(asked := Asked()):
        SEARCHES[name](grainy_photo())
    assert asked.count >= 5
    with stopping_when(again := Asked(asked.count)), pytest.raises(UnwantedError):
        SEARCHES[name](grainy_photo())
    assert again.count == asked.count


@pytest.mark.parametrize("stops_at", [1, 4, 8])
def test_what_was_stopped_is_searched_anew(stops_at, cascade):
    photo = grainy_photo()
    with stopping_when(Asked(stops_at)), pytest.raises(UnwantedError):
        find_faces(photo)
    cascade.sees_a_face = True
    assert len(find_faces(photo)) == 1


def test_a_search_ahead_that_is_stopped_says_nothing(cascade):
    photo = grainy_photo()
    with stopping_when(asked := Asked(4)):
        find_faces_beyond_doubt(photo)
    assert asked.count == 4
    cascade.sees_a_face = True
    assert len(find_faces(photo)) == 1


def test_beyond_the_work_that_it_was_laid_around_nobody_is_asked():
    with stopping_when(lambda: True), pytest.raises(UnwantedError):
        stop_if_unwanted()
    stop_if_unwanted()
    with pytest.raises(UnwantedError), stopping_when(lambda: True):
        stop_if_unwanted()
    stop_if_unwanted()


def test_in_a_large_image_each_size_of_heads_is_searched_for_by_itself_and_asked_about(monkeypatch):
    looks = []

    class Noted:
        def getOriginalWindowSize(self):
            return 20, 20

        def detectMultiScale2(self, grey, step, neighbours, flags, smallest, largest):
            looks.append((smallest, largest))
            return (), ()

    monkeypatch.setattr("relight_core.face.cascades._cascade", lambda name: Noted())
    with stopping_when(asked := Asked()):
        assert every_profile_hit(np.zeros((40, 1401), np.uint8)) == []
    sides = [29, 32, 35, 39]
    assert looks == 2 * [((side, side), (side, side)) for side in sides]
    assert asked.count == len(looks)


def test_size_by_size_the_same_hits_are_found(monkeypatch):
    grey = cv2.cvtColor(skimage.data.astronaut()[30:250, 110:330], cv2.COLOR_RGB2GRAY)
    small = cv2.resize(grey, (110, 110), interpolation=cv2.INTER_AREA)
    (at_once,) = every_hit(small)
    monkeypatch.setattr("relight_core.face.cascades._SEARCHED_AT_ONCE_PX", 100)
    (by_size,) = every_hit(small)
    np.testing.assert_array_equal(by_size.box, at_once.box)
    assert by_size.votes == at_once.votes > 8
