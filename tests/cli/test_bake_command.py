"""relight dataset bake: whom it bakes, what it refuses and what it leaves as it is."""

from types import SimpleNamespace

import numpy as np
import pytest
from refusals import refused


@pytest.mark.parametrize("count", ["0", "-3", "many", "1.5"])
def test_bake_wants_a_count(run, tmp_path, count):
    refused(run("dataset", "bake", "--heads", "m.npz", "--out", tmp_path, "--count", count), "whole number")


@pytest.mark.parametrize("words", [("--headwear", "1.2"), ("--arms", "nan"), ("--hair-mass", "few"), ("--skip", "-1")])
def test_bake_wants_a_share_and_a_place_to_start(run, tmp_path, words):
    refused(run("dataset", "bake", "--heads", "m.npz", "--out", tmp_path, "--count", 1, *words), words[1])


@pytest.mark.parametrize("size", ["0", "-32", "16", "100", "64.0"])
def test_bake_wants_a_size_that_networks_see(run, tmp_path, size):
    words = ["--heads", "m.npz", "--out", tmp_path / "o", "--count", 1, "--size", size]
    refused(run("dataset", "bake", *words), "multiple of 32")


@pytest.mark.parametrize(("skip", "count"), [(1_000_000, 1), (999_999, 2), (0, 1_000_001)])
def test_bake_stays_within_its_split(run, tmp_path, skip, count):
    """The next seed is a person of the next split, which training must not see."""
    words = ["--heads", "m.npz", "--out", tmp_path / "o", "--skip", skip, "--count", count]
    refused(run("dataset", "bake", *words), "split")
    assert not (tmp_path / "o").exists()


def test_bake_takes_the_people_after_those_left_out(run, tmp_path, monkeypatch):
    from relight_core.dataset import recipe

    asked = {}
    monkeypatch.setattr(recipe, "load_casting", lambda *words: asked.update(casting=words))
    monkeypatch.setattr(recipe, "bake_missing", lambda casting, folder, seeds, size: asked.update(seeds=seeds) or [])
    (tmp_path / "m.npz").write_bytes(b"")
    words = ["--heads", tmp_path / "m.npz", "--wardrobe", tmp_path, "--out", tmp_path / "o"]
    shares = ["--headwear", 1, "--arms", 0]
    code, _, _ = run("dataset", "bake", *words, "--split", "test", "--count", 3, "--skip", 20, *shares)
    assert code == 0
    assert list(asked["seeds"]) == [2_000_020, 2_000_021, 2_000_022]
    shares = asked["casting"][2]
    assert (shares.headwear, shares.arms) == (1, 0)
    assert 0 < shares.hair_mass < 0.3


@pytest.mark.parametrize(
    ("split", "names", "expected"), [("train", ("one",), [True]), ("train", (), [True, True]), ("test", ("one",), [])]
)
def test_the_wardrobe_s_skins_are_carried_over_once_and_for_training_alone(
    run, tmp_path, monkeypatch, split, names, expected
):
    from relight_core.dataset import recipe
    from relight_core.dataset.painting import skin_transfer
    from relight_core.dataset.painting.skin_textures import SkinTextures, load_skins

    tiles, asked = np.zeros((len(names), 2, 4, 4, 3), np.uint8), []
    found = SkinTextures(names, tiles, tiles)
    monkeypatch.setattr(skin_transfer, "transfer_skins", lambda *_: asked.append(True) or found)
    monkeypatch.setattr(recipe, "load_casting", lambda *_: SimpleNamespace(model=None))
    monkeypatch.setattr(recipe, "bake_missing", lambda *_: [])
    (tmp_path / "m.npz").write_bytes(b"")
    words = ["--heads", tmp_path / "m.npz", "--wardrobe", tmp_path, "--out", tmp_path / "o", "--split", split]
    for _ in range(2):
        assert run("dataset", "bake", *words, "--count", 1).code == 0
    assert asked == expected
    assert (load_skins(tmp_path / "o") is not None) == (split == "train" and names != ())


@pytest.mark.parametrize("option", ["--headwear", "--hair-mass"])
def test_what_is_worn_needs_a_wardrobe(run, tmp_path, option):
    (tmp_path / "m.npz").write_bytes(b"")
    words = ["--heads", tmp_path / "m.npz", "--out", tmp_path, "--count", 1, option, 0.5]
    refused(run("dataset", "bake", *words), f"{option} needs --wardrobe")


def test_bake_says_which_heads_were_there_and_are_not_made_anew(run, tmp_path, monkeypatch):
    from relight_core.dataset import recipe

    def bake_missing(casting, folder, seeds, size):
        for seed in seeds:
            path = recipe.shard_path(folder, seed)
            path.touch()
            yield path

    monkeypatch.setattr(recipe, "load_casting", lambda *_: None)
    monkeypatch.setattr(recipe, "bake_missing", bake_missing)
    (tmp_path / "model.npz").touch()
    words = ["dataset", "bake", "--heads", tmp_path / "model.npz", "--out", tmp_path / "heads", "--count"]
    assert "heads: 1 train head, 0.0 MB\n" in run(*words, 1)[1]
    assert "2 train heads, 0.0 MB; 1 of them" in run(*words, 2)[1]
    assert "3 train heads, 0.0 MB; 2 of them were there and stay as they were baked" in run(*words, 3)[1]


def test_bake_without_its_model_or_wardrobe(run, tmp_path):
    refused(run("dataset", "bake", "--heads", tmp_path / "no.npz", "--out", tmp_path, "--count", 1), "no.npz")
    (tmp_path / "m.npz").write_bytes(b"")
    refused(
        run(
            "dataset",
            "bake",
            "--heads",
            tmp_path / "m.npz",
            "--wardrobe",
            tmp_path / "none",
            "--out",
            tmp_path,
            "--count",
            1,
        ),
        "none",
    )


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", b"words" * 50])
def test_bake_with_a_broken_model(run, tmp_path, content):
    (tmp_path / "m.npz").write_bytes(content)
    refused(run("dataset", "bake", "--heads", tmp_path / "m.npz", "--out", tmp_path / "o", "--count", 1), "m.npz")


def test_baking_scans_refuses(run, tmp_path):
    scans = tmp_path / "scans"
    scans.mkdir()
    words = ["dataset", "bake", "--heads", scans, "--out", tmp_path / "heads", "--count", 1]
    refused(run(*words), "no scans")
    refused(run(*words, "--wardrobe", tmp_path), "wardrobe")
    refused(run("dataset", "skins", "--heads", scans, "--wardrobe", tmp_path, "--out", tmp_path), "head model")


def test_a_head_model_is_not_written_over_by_the_skins_that_are_carried_onto_it(run, tmp_path):
    model = tmp_path / "skins.npz"
    model.write_bytes(b"a model")
    words = ["--wardrobe", tmp_path, "--out", tmp_path]
    refused(run("dataset", "skins", "--heads", model, *words), f"{model}: that is the input")
    assert model.read_bytes() == b"a model"
