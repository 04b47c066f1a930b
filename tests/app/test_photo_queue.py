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
    assert queue.refused(PhotoQueue((A, B, C)), stays=A) == PhotoQueue((A, B, C), 1, is_beside=True)
    assert queue.refused(PhotoQueue(), stays=None) == queue


def test_a_photo_that_is_in_it_twice_stays_where_it_was_reached():
    assert PhotoQueue((A, B, A), 2).showing(A) == PhotoQueue((A, B, A), 2)
    assert PhotoQueue((A, B, A), 2).showing(B) == PhotoQueue((A, B, A), 1)
    assert PhotoQueue((A, B), 1).showing(D) == PhotoQueue((A, B), 1, is_beside=True)
    assert PhotoQueue().showing(A) == PhotoQueue()
