"""The engine and the faces of a photo: none found, boxes by hand, and what stays in sight meanwhile."""

import threading

import fake_relighter
import numpy as np
import pytest

from app.engine import desk
from app.engine.sources import LightSource, PhotoSource, Request
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.imaging.write import write_image
from relight_core.pipeline.edit import Edit

SPLIT = LightSource("rig", "split")
BOX, OTHER = FaceBox(4, 4, 20, 20), FaceBox(10, 2, 22, 14)


def a_photo():
    return Photo(np.full((24, 32, 3), 0.5, np.float32))


def answered(engine, photo, light=SPLIT, edit=None):
    return fake_relighter.answered(engine, Request(photo, light, edit or Edit()))


def test_a_photo_in_which_nobody_is_found_is_shown_without_a_picture(engine, relighter):
    answered(engine, PhotoSource(a_photo()))
    relighter.blind = True
    nobody = PhotoSource(a_photo())
    snapshot = answered(engine, nobody)
    assert snapshot.opened.source is nobody
    assert snapshot.opened.screen.shape == (24, 32, 3)
    assert (snapshot.faces, snapshot.picture, snapshot.own_light) == ((), None, None)
    assert nobody not in snapshot.refused
    calls = len(relighter.relights)
    assert answered(engine, nobody, edit=Edit(shadow=0.1)).picture is None
    assert len(relighter.relights) == calls


def test_faces_are_looked_for_while_networks_load_in_the_photo_that_is_searched_for_them_later(engine, monkeypatch):
    """Without what lies over all of it: another would be searched in vain, and the search for faces wait for that."""
    looked, done = [], threading.Event()
    monkeypatch.setattr(desk, "find_faces_beyond_doubt", lambda photo: looked.append(photo) or done.set())
    lifted = Photo(np.linspace(0.02, 0.9, 24 * 32 * 3, dtype=np.float32).reshape(24, 32, 3))
    answered(engine, PhotoSource(lifted))
    assert done.wait(fake_relighter.LONG_S)
    assert lifted.above_black is not lifted
    assert looked == [lifted.above_black.seen]


def test_a_box_by_hand_makes_its_picture(engine, relighter):
    relighter.blind = True
    nobody = PhotoSource(a_photo())
    screen = answered(engine, nobody).opened.screen
    snapshot = answered(engine, PhotoSource(nobody.place, None, (BOX,)))
    assert relighter.portraits == [(nobody.place, None, (BOX,))]
    assert snapshot.faces == (BOX,)
    assert snapshot.picture.opened is snapshot.opened
    assert snapshot.opened.screen is screen, "the photo is the same, and not uploaded again"


def test_the_picture_before_stays_in_sight_until_the_faces_are_relit_anew(engine, relighter, published):
    first = PhotoSource(a_photo())
    before = answered(engine, first).picture
    published.clear()
    moved = PhotoSource(first.place, None, (BOX, OTHER))
    after = answered(engine, moved).picture
    assert after.relit is not before.relit
    assert not after.is_stale
    between = [snapshot for snapshot in published if snapshot.picture is not after]
    assert {snapshot.picture.relit for snapshot in between} == {before.relit}
    assert all(snapshot.picture.opened is snapshot.opened for snapshot in between)


def answered_with_another_wish_meanwhile(engine, relighter, monkeypatch, photo, next_photo):
    """As `answered`, where the next photo is wished for just as the engine has taken up the first."""
    take = relighter.set_portrait

    def set_portrait(place, face_index=None, boxes=None, strokes=()):
        if (place, boxes) == (photo.place, photo.boxes):
            engine.submit(Request(next_photo, SPLIT, Edit()))
        take(place, face_index, boxes, strokes)

    monkeypatch.setattr(relighter, "set_portrait", set_portrait)
    return answered(engine, photo)


def test_the_picture_before_stays_in_sight_where_the_faces_change_once_more(engine, relighter, published, monkeypatch):
    first = PhotoSource(a_photo())
    answered(engine, first)
    published.clear()
    moved, again = PhotoSource(first.place, None, (BOX,)), PhotoSource(first.place, None, (BOX, OTHER))
    after = answered_with_another_wish_meanwhile(engine, relighter, monkeypatch, moved, again)
    assert after.picture.opened.source is again
    assert {snapshot.opened.source for snapshot in published} == {first, moved, again}
    assert all(snapshot.picture.opened is snapshot.opened for snapshot in published)


def test_no_picture_of_another_photo_is_left_where_nobody_is_found_and_the_next_photo_fails(
    engine, relighter, monkeypatch
):
    answered(engine, PhotoSource(a_photo()))
    nobody, bad = PhotoSource(a_photo(), None, ()), PhotoSource(a_photo(), None, (FaceBox(-40, 0, -8, 30),))
    after = answered_with_another_wish_meanwhile(engine, relighter, monkeypatch, nobody, bad)
    assert bad in after.refused
    assert after.opened.source is nobody
    assert after.picture is None


def test_where_the_faces_can_not_be_relit_their_former_picture_goes(engine, relighter):
    first = PhotoSource(a_photo())
    answered(engine, first)
    relighter.fail_with = MemoryError("no room")
    snapshot = answered(engine, PhotoSource(first.place, None, (BOX,)))
    assert snapshot.picture is None
    assert snapshot.message.is_error


def test_where_another_photo_can_not_be_relit_the_picture_of_the_one_before_goes(engine, relighter):
    answered(engine, PhotoSource(a_photo()))
    relighter.fail_with = MemoryError("no room")
    second = PhotoSource(a_photo())
    snapshot = answered(engine, second)
    assert snapshot.opened.source is second
    assert snapshot.picture is None


def test_without_a_face_there_is_no_own_light_but_the_one_in_force_stays(engine, relighter):
    own = LightSource("own")
    relighter.blind = True
    nobody = PhotoSource(a_photo())
    refused = answered(engine, nobody, own)
    assert own in refused.refused
    assert "draw a box" in refused.message.text
    own = LightSource("own")
    light = answered(engine, PhotoSource(nobody.place, None, (BOX,)), own).light
    assert light.source is own
    none_left = answered(engine, PhotoSource(nobody.place, None, ()), own)
    assert none_left.light is light
    assert none_left.picture is None
    again = answered(engine, PhotoSource(nobody.place, None, (OTHER,)), own)
    assert again.light is not light
    assert again.picture.light is again.light


def test_borrowing_a_light_needs_no_face_in_the_photo_that_is_open(engine, relighter, tmp_path):
    path = tmp_path / "friend.png"
    write_image(path, np.broadcast_to(np.float32([0.8, 0.2, 0.2]), (20, 20, 3)))
    relighter.blind = True
    nobody = PhotoSource(a_photo())
    answered(engine, nobody)
    relighter.blind = False
    borrowed = LightSource("portrait", str(path))
    snapshot = answered(engine, nobody, borrowed)
    assert snapshot.light.source is borrowed
    assert snapshot.opened.source is nobody
    drawn = answered(engine, PhotoSource(nobody.place, None, (BOX,)), borrowed)
    assert relighter.portraits[-1] == (nobody.place, None, (BOX,))
    assert drawn.picture.light is drawn.light


def test_own_light_waits_through_a_photo_without_a_face(engine, relighter):
    own = LightSource("own")
    answered(engine, PhotoSource(a_photo()), own)
    for _ in range(2):
        relighter.blind = True
        nobody = answered(engine, PhotoSource(a_photo()), own)
        assert (nobody.faces, nobody.light) == ((), None)
        assert own not in nobody.refused
        assert nobody.awaited is own
    relighter.blind = False
    after = answered(engine, PhotoSource(a_photo()), own)
    assert after.light.source is own
    assert after.picture.light is after.light


def test_of_a_picture_whose_light_can_t_be_borrowed_nobody_is_asked_where_its_face_is(engine, tmp_path):
    write_image(tmp_path / "wall.png", np.zeros((20, 20, 3), np.float32))
    told = answered(engine, PhotoSource(a_photo()), LightSource("portrait", str(tmp_path / "wall.png"))).message.text
    assert "wall.png: no face found to borrow light from" in told
    assert "where" not in told


def test_a_correction_that_was_refused_lets_go_of_its_photo_once_another_is_open(engine):
    first = PhotoSource(a_photo())
    answered(engine, first)
    snapshot = answered(engine, PhotoSource(first.place, None, (FaceBox(-20, 0, -4, 16),)))
    assert len(snapshot.refused) == 1
    # What is still refused would keep it.
    assert answered(engine, PhotoSource(a_photo())).refused == frozenset()


@pytest.mark.parametrize(("face_index", "words"), [(None, "Relighting 2 faces"), (1, "Relighting")])
def test_of_a_group_it_is_told_how_many_faces_are_relit(engine, relighter, face_index, words):
    relighter.gate.clear()
    engine.submit(Request(PhotoSource(a_photo(), face_index, (BOX, OTHER)), SPLIT, Edit()))
    assert relighter.entered.acquire(timeout=fake_relighter.LONG_S)
    assert engine.snapshot().activity == words
