"""Which sizes of a recipe's stages the baked heads have to suit."""

from pathlib import Path
from types import SimpleNamespace

from app.cli.train import _check_sizes
from relight_core.training.recipe import load_recipe


def test_outlines_are_cut_from_heads_of_any_size(monkeypatch):
    monkeypatch.setattr("relight_core.dataset.recipe.load_split", lambda *_: [Path("head-0000000.npz")])
    monkeypatch.setattr("relight_core.dataset.baking.shard.read_shard", lambda _: SimpleNamespace(size=32))
    _check_sizes(load_recipe("person"), Path())
