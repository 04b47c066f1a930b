"""A search for faces ends as soon as another photo or light is wanted: the newest request wins."""

import threading

import numpy as np
import pytest
from fake_relighter import LONG_S, FakeRelighter, answered

from app.engine import desk
from app.engine.engine import Engine
from app.engine.sources import LightSource, PhotoSource, Request
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.imaging.write import write_image
from relight_core.unwanted import UnwantedError, stop_if_unwanted

SPLIT = LightSource("rig", "split")


def grey_source(value=0.5):
    return PhotoSource(Photo(np.full((24, 32, 3), value, np.float32)))


class Searching(FakeRelighter):
    """Asks in the midst of a search whether it is still wanted; `meanwhile` is done just before, once."""

    def __init__(self):
        super().__init__()
        self.meanwhile, self.searched = None, []

    def set_portrait(self, photo, *how):
        meanwhile, self.meanwhile = self.meanwhile, None
        if meanwhile is not None:
            meanwhile()
        self.searched.append(photo)
        stop_if_unwanted()
        super().set_portrait(photo, *how)

    def taken(self):
        return [photo for photo, *_ in self.portraits]


@pytest.fixture
def relighter():
    return Searching()


def test_of_a_photo_that_another_follows_while_it_is_searched_nothing_is_ever_shown(engine, relighter, published):
    first, passed, newest = grey_source(0.2), grey_source(0.4), grey_source(0.6)
    answered(engine, Request(first, SPLIT))
    relighter.meanwhile = lambda: engine.submit(Request(newest, SPLIT))
    last = answered(engine, Request(passed, SPLIT))
    assert last.picture.opened.source is last.opened.source is newest
    assert {snapshot.opened.source for snapshot in published if snapshot.opened} == {first, newest}
    assert relighter.taken() == [first.place, newest.place]
    assert (last.refused, last.message) == (frozenset(), None)


def test_a_photo_that_was_passed_can_be_come_back_to(engine, relighter):
    passed, newest = grey_source(0.4), grey_source(0.6)
    relighter.meanwhile = lambda: engine.submit(Request(newest, SPLIT))
    assert answered(engine, Request(passed, SPLIT)).opened.source is newest
    assert answered(engine, Request(passed, SPLIT)).picture.opened.source is passed


def test_a_change_of_the_edit_or_of_the_same_photo_s_boxes_lets_a_search_end(engine, relighter, published):
    first = grey_source()
    corrected = PhotoSource(first.place, None, (FaceBox(4, 4, 20, 20),))
    relighter.meanwhile = lambda: engine.submit(Request(corrected, LightSource("rig", "rembrandt")))
    assert answered(engine, Request(first, SPLIT)).opened.source is corrected
    assert relighter.taken() == [first.place, first.place]
    assert first in {snapshot.opened.source for snapshot in published if snapshot.opened}


@pytest.fixture
def friend(tmp_path):
    write_image(tmp_path / "friend.png", np.broadcast_to(np.float32([0.8, 0.2, 0.2]), (20, 20, 3)))
    return LightSource("portrait", str(tmp_path / "friend.png"))


def test_another_light_ends_the_search_for_the_face_that_was_to_lend_its_own(engine, relighter, friend):
    first, rembrandt = grey_source(), LightSource("rig", "rembrandt")
    answered(engine, Request(first, SPLIT))
    relighter.meanwhile = lambda: engine.submit(Request(first, rembrandt))
    last = answered(engine, Request(first, friend))
    assert last.light.source is last.picture.light.source is rembrandt
    assert {id(photo) for photo in relighter.taken()} == {id(first.place)}
    assert (last.refused, last.message) == (frozenset(), None)


def test_another_photo_comes_before_the_light_that_is_being_borrowed(engine, relighter, friend):
    first, newest = grey_source(), grey_source(0.7)
    answered(engine, Request(first, SPLIT))
    relighter.meanwhile = lambda: engine.submit(Request(newest, friend))
    last = answered(engine, Request(first, friend))
    lender, second, *_ = relighter.searched[1:]
    assert lender is not first.place
    assert second is newest.place
    assert last.picture.opened.source is newest
    assert last.picture.light.source is friend


def test_a_window_that_closes_waits_for_no_search(engine, relighter):
    relighter.meanwhile = engine.close
    engine.submit(Request(grey_source(), SPLIT))
    engine.wait_until_idle(LONG_S)
    engine.close()
    assert len(relighter.searched) == 1
    assert relighter.taken() == []


def test_the_search_while_the_networks_load_is_told_too(monkeypatch):
    """The search of the photo that is wanted would wait for its end."""
    passed, newest, told = grey_source(0.4), grey_source(0.6), threading.Event()

    def search(photo):
        if photo is passed.place.above_black.seen:
            engine.submit(Request(newest, SPLIT))
            try:
                stop_if_unwanted()
            except UnwantedError:
                told.set()

    monkeypatch.setattr(desk, "find_faces_beyond_doubt", search)
    engine = Engine(FakeRelighter)
    engine.submit(Request(passed, SPLIT))
    assert told.wait(LONG_S)
    engine.close()
