"""Which sizes of a recipe's stages the baked heads have to suit."""

import pytest
from synthetic_heads import write_balls

from app.cli.train import _check_sizes
from relight_core.errors import InputError
from relight_core.training.recipe import load_recipe


def sizes_of(name):
    return [(plan.name, plan.size) for plan in load_recipe(name).stages]


def test_outlines_are_cut_from_heads_of_any_size(tmp_path):
    write_balls(tmp_path / "heads", 0, 1, size=32)
    _check_sizes(sizes_of("person"), tmp_path / "heads")


def test_the_last_of_the_heads_is_looked_at_too(tmp_path):
    write_balls(tmp_path / "heads", 0, 1, size=32)
    write_balls(tmp_path / "heads", 1, 1, size=16)
    with pytest.raises(InputError, match="head-0000001.npz: a head of 16 pixels has no size of 32, which warm-delight"):
        _check_sizes([("warm-delight", 32), ("warm-delight", 16)], tmp_path / "heads")


def test_samples_too_small_for_the_losses_are_refused_whatever_the_heads(tmp_path):
    write_balls(tmp_path / "heads", 0, 1, size=32)
    _check_sizes([("warm-delight", 16)], tmp_path / "heads")
    with pytest.raises(InputError, match="warm-delight asks for a size of 8: samples are 16 pixels wide or more"):
        _check_sizes([("warm-delight", 8)], tmp_path / "heads")
