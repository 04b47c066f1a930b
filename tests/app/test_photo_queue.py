"""The queue of photos: which one is open, and what becomes of a queue whose photo can't be opened."""

from pathlib import Path

import pytest

from app.ui.photo_queue import PhotoQueue

A, B, C, D = (Path(f"/photos/{name}.jpg") for name in "abcd")


@pytest.mark.parametrize(
    ("before", "refused", "comes_back"),
    [((), (C,), True), ((A,), (C,), True), ((A,), (C, D), False), ((A, B), (C,), True), ((A, B), (C, D), True)],
)
def test_the_queue_before_comes_back_unless_only_the_new_one_has_other_photos(before, refused, comes_back):
    before, refused = PhotoQueue(before), PhotoQueue(refused)
    then = refused.refused(before, stays=A)
    assert then == (before if comes_back else PhotoQueue(refused.paths, is_beside=True))


def test_a_queue_goes_on_from_where_a_photo_of_its_own_is_refused():
    queue = PhotoQueue((A, B, C), 1)
    assert queue.refused(PhotoQueue((A, B, C)), stays=D) == PhotoQueue((A, B, C), 1, is_beside=True)
    assert queue.refused(PhotoQueue(), stays=None) == queue


def test_photos_that_were_refused_are_passed_by_from_the_one_that_stays_until_another_opens():
    stays = queue = PhotoQueue((A, B, C, D), 0)
    for led_to in (B, C):
        queue = queue.step(1)
        assert queue.current == led_to
        queue = queue.refused(stays, stays=A)
        assert (queue.label, queue.step(-1)) == ("1 of 4", None)
    queue = queue.step(1)
    assert (queue.label, queue.refused(stays, stays=A).step(1)) == ("4 of 4", None)
    assert queue.showing(D).step(-1) == PhotoQueue((A, B, C, D), 2)


def test_the_photo_that_stays_has_the_place_at_which_it_was_reached_though_the_queue_is_new():
    twice = PhotoQueue((A, B, A, C), 2)
    assert twice.step(-1).refused(twice, stays=A).label == "3 of 4"
    new = PhotoQueue((C, A, D)).refused(PhotoQueue((A,)), stays=A)
    assert (new.label, new.step(-1), new.step(1).current) == ("2 of 3", None, D)


def test_a_step_leads_to_the_next_photo_and_never_beyond_the_ends():
    queue = PhotoQueue((A, B, C), 1, is_beside=True)
    assert (queue.step(1), queue.step(-1)) == (PhotoQueue((A, B, C), 2), PhotoQueue((A, B, C), 0))
    assert (queue.step(2), queue.step(-2), PhotoQueue().step(1)) == (None, None, None)


def test_its_label_counts_from_one_and_has_no_number_beside_another_photo():
    assert [PhotoQueue((A, B), at).label for at in (0, 1)] == ["1 of 2", "2 of 2"]
    assert PhotoQueue((A, B), 1, is_beside=True).label == "\N{EN DASH} of 2"


def test_whatever_is_opened_the_queue_knows_whether_it_is_its_own(monkeypatch):
    monkeypatch.chdir("/")
    beside = PhotoQueue((A, B), 1, is_beside=True)
    assert beside.showing(None) == beside
    assert beside.showing(Path("photos/a.jpg")) == PhotoQueue((A, B), 0)
    assert beside.showing(Path("photos/b.jpg")) == PhotoQueue((A, B), 1)
    again = PhotoQueue((A, B), 1).refused(PhotoQueue((A, B)), stays=Path("photos/b.jpg"))
    assert again == PhotoQueue((A, B), 1), "the photo that stays is the one that was read again in vain"


def test_a_photo_that_is_in_it_twice_stays_where_it_was_reached():
    assert PhotoQueue((A, B, A), 2).showing(A) == PhotoQueue((A, B, A), 2)
    assert PhotoQueue((A, B, A), 2).showing(B) == PhotoQueue((A, B, A), 1)
    assert PhotoQueue((A, B), 1).showing(D) == PhotoQueue((A, B), 1, is_beside=True)
    assert PhotoQueue().showing(A) == PhotoQueue()
