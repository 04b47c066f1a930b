"""Preparing batches ahead of the step: order, one in flight, and errors where they belong."""

import itertools
import threading

import pytest

from relight_core.training.ahead import one_ahead

PATIENCE_S = 20


def test_batches_come_in_order_with_what_was_made_of_them():
    assert list(one_ahead(str, iter(range(4)))) == [(0, "0"), (1, "1"), (2, "2"), (3, "3")]
    assert list(one_ahead(str, iter(()))) == []


def test_the_next_batch_is_prepared_while_the_caller_is_busy_with_this_one():
    started = [threading.Event() for _ in range(2)]

    def prepare(number):
        started[number].set()
        return number

    for batch, _ in one_ahead(prepare, iter(range(2))):
        assert started[min(batch + 1, 1)].wait(PATIENCE_S)


def test_of_endless_batches_only_one_more_is_taken():
    taken = []
    endless = (taken.append(number) or number for number in itertools.count())
    prepared = one_ahead(str, endless)
    next(prepared)
    assert taken == [0, 1]


def test_a_failure_comes_with_the_batch_that_it_is_about():
    def prepare(number):
        if number == 1:
            raise ValueError("the second")
        return number

    prepared = one_ahead(prepare, iter(range(3)))
    assert next(prepared) == (0, 0)
    with pytest.raises(ValueError, match="second"):
        next(prepared)
