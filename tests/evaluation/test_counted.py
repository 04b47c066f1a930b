"""Counts in words."""

import pytest

from relight_core.evaluation.ablation.variants import Budget, in_words
from relight_core.evaluation.counted import counted


@pytest.mark.parametrize(("count", "words"), [(0, "0 relightings"), (1, "1 relighting"), (20, "20 relightings")])
def test_one_of_a_thing_has_no_s(count, words):
    assert counted(count, "relighting") == words


def test_a_budget_of_one_pair_is_told_as_one():
    assert "2 photos (1 pair of lights) at 32 pixels" in in_words(Budget(3, 32, 1))
