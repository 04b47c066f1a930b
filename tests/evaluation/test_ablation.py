"""The variants of Table 2: what each recipe switches, and that all are trained alike."""

import itertools
import json
from dataclasses import asdict

import pytest
import torch

from relight_core.errors import InputError
from relight_core.evaluation.ablation import variants
from relight_core.evaluation.ablation.variants import (
    VARIANTS,
    Budget,
    check_budget,
    in_words,
    train_variants,
    trained_variants,
)
from relight_core.evaluation.peers.table import contenders, trained_sun
from relight_core.networks.bundle import load_bundle
from relight_core.networks.delight import DelightConfig
from relight_core.training import run as run_module
from relight_core.training.recipe import load_recipe

SWITCHES = {
    "DL-RL": {"parsing": False, "effects": False, "modulated": False, "ours": False},
    "DL-RL+SS": {"parsing": False, "effects": True, "modulated": False, "ours": False},
    "DL-RL+SS+LFM": {"parsing": False, "effects": True, "modulated": True, "ours": False},
    "Full": {"parsing": True, "effects": True, "modulated": True, "ours": False},
    "ours": {"parsing": True, "effects": True, "modulated": True, "ours": True},
}
SIZE = 32


def batches():
    """The same pairs again and again, random but for their shapes."""
    generator = torch.Generator().manual_seed(0)

    def some(*shape):
        return torch.rand(1, *shape, SIZE, SIZE, generator=generator)

    names = ("specular", "shadow", "shadow_fraction", "gloss_fraction", "relief_shadow")
    batch = {name: some(2, 1) for name in names} | {name: some(2, 3) for name in ("photo_srgb", "image")}
    batch |= {"light": torch.rand(1, 2, 16, 32, 3, generator=generator), "albedo": some(3), "relief": some(1)}
    batch["normal"] = torch.nn.functional.normalize(some(3) + torch.tensor([0, 0, 1.0])[:, None, None], dim=1)
    batch["label"], batch["covered"] = torch.ones(1, SIZE, SIZE, dtype=torch.long), torch.ones(1, 1, SIZE, SIZE)
    return itertools.repeat(batch)


@pytest.fixture(scope="module")
def data():
    """Batches without heads or lights, and what asked for them."""
    asked = []

    def make(run, *place):
        asked.append(run.stage)
        return batches()

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(run_module, "training_batches", make)
        patched.setattr("relight_core.evaluation.peers.sun.shared_batches", make)
        yield asked


BUDGET = Budget(steps=2, size=SIZE, pairs=1)


@pytest.fixture(scope="module")
def trained(data, tmp_path_factory):
    folder = tmp_path_factory.mktemp("ablation")
    return folder, train_variants(folder, folder, folder, BUDGET), list(data)


@pytest.mark.parametrize("name", list(SWITCHES))
def test_each_recipe_switches_what_its_row_says(name):
    networks, wanted = load_recipe(VARIANTS[name]).networks, SWITCHES[name]
    assert bool(networks.delight.classes) is wanted["parsing"]
    assert networks.composition.effects is wanted["effects"]
    assert networks.composition.modulated is networks.specular_shadow.modulated is wanted["modulated"]
    assert networks.specular_shadow.additive is not wanted["ours"]
    for ours in (
        networks.delight.anchored,
        networks.delight.relief,
        networks.specular_shadow.per_pixel_light,
        networks.specular_shadow.relief_shadow,
        networks.composition.explicit_sum,
    ):
        assert ours is wanted["ours"]


def test_rows_are_trained_alike():
    recipes = [load_recipe(recipe) for recipe in VARIANTS.values()]
    assert len({recipe.seed for recipe in recipes}) == 1
    for plans in zip(*(recipe.stages for recipe in recipes), strict=True):
        assert len({(plan.steps, plan.size, plan.pairs, plan.learning_rate) for plan in plans}) == 1
    sizes = {
        (r.networks.delight.width, r.networks.specular_shadow.width, r.networks.composition.width) for r in recipes
    }
    assert len(sizes) == 1


def test_a_budget_keeps_the_stages_proportions():
    recipe = Budget(steps=30, size=96, pairs=2).of(load_recipe("ablation/full"))
    assert [plan.steps for plan in recipe.stages] == [30, 30, 10, 10]
    assert {(plan.size, plan.pairs) for plan in recipe.stages} == {(96, 2)}
    assert "30 of warm-delight" in in_words(Budget(steps=30))
    assert [plan.steps for plan in Budget(steps=1).of(load_recipe("ablation/full")).stages] == [1, 1, 1, 1]


def test_all_variants_are_trained_and_warm_ups_in_common_once(trained):
    _, weights, asked = trained
    assert list(weights) == list(SWITCHES)
    assert asked.count("warm-delight") == 3
    assert asked.count("warm-composition") == 1
    assert asked.count("warm-relight") == 3
    assert asked.count("tune-delight") == asked.count("tune-on-predictions") == 5
    for name, path in weights.items():
        assert load_bundle(path).config == load_recipe(VARIANTS[name]).networks


def test_what_is_trained_stays(trained, data):
    folder, weights, _ = trained
    data.clear()
    assert train_variants(folder, folder, folder, BUDGET) == weights
    assert data == []


def test_a_warm_up_that_was_stopped_is_no_finished_one_and_goes_on(tmp_path, monkeypatch):
    asked = []

    def stopped(run, report):
        asked.append(run.checkpoint)
        run.checkpoint.touch()
        run.checkpoint.with_suffix(".state.safetensors").touch()
        raise KeyboardInterrupt

    monkeypatch.setattr(variants, "train", stopped)
    for _ in range(2):
        with pytest.raises(KeyboardInterrupt):
            train_variants(tmp_path, tmp_path, tmp_path, BUDGET)
    assert asked[0] == asked[1]


def test_variants_of_one_warm_up_begin_with_the_same_weights(trained):
    folder, *_ = trained
    starts = [load_bundle(folder / name / "00-warm.safetensors") for name in ("dl-rl-ss-lfm", "full", "dl-rl-ss")]
    one, other, third = (start.composition.state_dict() for start in starts)
    assert all(torch.equal(one[name], other[name]) for name in one)
    assert set(one) != set(third)


def test_another_budget_wants_another_folder(trained):
    folder, *_ = trained
    with pytest.raises(InputError, match="budget|training with"):
        train_variants(folder, folder, folder, Budget(steps=3, size=SIZE, pairs=1))


def test_other_heads_or_lights_want_another_folder(tmp_path):
    heads, lights, folder = tmp_path / "heads", tmp_path / "lights.npz", tmp_path / "tables"
    heads.mkdir()
    folder.mkdir()
    (heads / "head-7.npz").write_bytes(b"one")
    lights.write_bytes(b"sky")
    for _ in range(2):
        check_budget(folder, BUDGET, heads, lights)
    (folder / "batch.safetensors").touch()
    (heads / "head-8.npz").write_bytes(b"two")
    with pytest.raises(InputError, match="another folder"):
        check_budget(folder, BUDGET, heads, lights)
    (heads / "head-8.npz").unlink()
    lights.write_bytes(b"other sky")
    with pytest.raises(InputError, match="another folder"):
        check_budget(folder, BUDGET, heads, lights)


def test_a_folder_from_before_data_was_noted_goes_on(tmp_path):
    lights = tmp_path / "lights.npz"
    lights.write_bytes(b"sky")
    (tmp_path / "budget.json").write_text(json.dumps(asdict(BUDGET)))
    (tmp_path / "batch.safetensors").touch()
    check_budget(tmp_path, BUDGET, tmp_path, lights)
    lights.write_bytes(b"other sky")
    with pytest.raises(InputError, match="another folder"):
        check_budget(tmp_path, BUDGET, tmp_path, lights)


def test_a_training_that_was_refused_keeps_no_other_from_its_folder(tmp_path):
    lights, smaller = tmp_path / "lights.npz", Budget(steps=3, size=SIZE, pairs=1)
    lights.write_bytes(b"sky")
    for budget in (BUDGET, smaller):
        check_budget(tmp_path, budget, tmp_path, lights)
    (tmp_path / "batch.safetensors").touch()
    check_budget(tmp_path, smaller, tmp_path, lights)
    with pytest.raises(InputError, match="another folder"):
        check_budget(tmp_path, BUDGET, tmp_path, lights)


def test_what_is_not_finished_does_not_count(tmp_path):
    assert trained_variants(tmp_path) == {}


def test_sun_s_network_is_trained_as_long_and_then_read(trained, data, monkeypatch):
    folder, weights, _ = trained
    steps = []
    monkeypatch.setattr(
        "relight_core.evaluation.peers.table.train_sun",
        lambda run, *given: steps.append(given[:2]) or original(run, *given),
    )
    from relight_core.evaluation.peers.sun import train_sun as original

    for _ in range(2):
        sun = trained_sun(folder, folder, folder, BUDGET, lambda done, note: None)
    assert steps == [(2 + 2 + 1 + 1, 2)]
    with pytest.raises(InputError, match=r"sun\.safetensors: is 8 wide and 5 deep, .* 4 and 3; choose another folder"):
        trained_sun(folder, folder, folder, BUDGET, lambda done, note: None, like=DelightConfig(width=4, levels=3))
    everybody = contenders({name: load_bundle(path) for name, path in weights.items()}, sun, None)
    assert list(everybody) == ["Shih et al. 2014", "Shu et al. 2017", "Sun et al. 2019", *SWITCHES]
