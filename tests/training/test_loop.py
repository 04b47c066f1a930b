"""Training steps on a batch that stays the same, with a clock that counts steps."""

import itertools
import json
from dataclasses import replace
from types import SimpleNamespace

import pytest
import torch

from relight_core.errors import InputError
from relight_core.networks.bundle import BundleConfig, NetworkBundle, load_bundle
from relight_core.training import loop
from relight_core.training.curves import draw_curves
from relight_core.training.loop import Budget, TrainingDiverged, train_stage
from relight_core.training.stages import STAGES

SIZE = 16


@pytest.fixture(autouse=True)
def _seeded():
    torch.manual_seed(0)


def some_batch(pairs=1):
    """A ramp of an albedo on tilted planes under random light; everything consistent in shape and range."""
    image = (pairs, 2, 3, SIZE, SIZE)
    albedo = torch.rand(pairs, 3, SIZE, SIZE) * 0.8 + 0.1
    toward_camera = torch.tensor([0, 0, 1.0])[:, None, None]
    normal = torch.nn.functional.normalize(torch.rand(pairs, 3, SIZE, SIZE) + toward_camera, dim=1)
    covered = torch.ones(pairs, 1, SIZE, SIZE)
    covered[..., :3] = 0
    one = (pairs, 2, 1, SIZE, SIZE)
    return {
        "photo_srgb": torch.rand(image),
        "image": torch.rand(image),
        "specular": torch.rand(one) * 0.1,
        "shadow": torch.rand(one) * 0.2,
        "shadow_fraction": torch.rand(one),
        "gloss_fraction": torch.rand(one),
        "relief_shadow": torch.rand(one),
        "light": torch.rand(pairs, 2, 16, 32, 3) * 2,
        "albedo": albedo,
        "normal": normal,
        "relief": torch.rand(pairs, 1, SIZE, SIZE),
        "label": torch.randint(14, (pairs, SIZE, SIZE)),
        "covered": covered,
    }


def budget(monkeypatch, steps, **settings):
    """A budget of exactly so many steps: the loop asks the time twice a step."""
    clock = itertools.count()
    monkeypatch.setattr(loop, "time", SimpleNamespace(monotonic=lambda: next(clock)))
    return Budget(minutes=(2 * steps - 1) / 60 + 1e-6, learning_rate=5e-3, warm_up_steps=1, **settings)


def recorded(stage, totals):
    def losses(bundle, table, batch):
        terms = stage.losses(bundle, table, batch)
        totals.append(float(sum(term.detach().float() for term in terms.values())))
        return terms

    return replace(stage, losses=losses)


def run(stage, batches, plan, path, bundle=None):
    bundle = bundle or NetworkBundle(BundleConfig.tiny())
    return train_stage(stage, bundle, iter(batches), plan, path, lambda *progress: None)


@pytest.mark.parametrize("name", list(STAGES))
def test_ten_steps_on_one_batch_lower_the_loss(name, monkeypatch, tmp_path):
    totals = []
    batch = some_batch()
    run(
        recorded(STAGES[name], totals),
        itertools.repeat(batch),
        budget(monkeypatch, 12),
        tmp_path / "w.safetensors",
    )
    assert len(totals) >= 10
    assert min(totals[-3:]) < totals[0]


@pytest.mark.parametrize("name", ["warm-delight", "tune-relight"])
def test_only_the_stage_s_networks_change(name, monkeypatch, tmp_path):
    bundle = NetworkBundle(BundleConfig.tiny())
    before = {key: value.clone() for key, value in bundle.state_dict().items()}
    path = tmp_path / "w.safetensors"
    result = run(STAGES[name], itertools.repeat(some_batch()), budget(monkeypatch, 9), path, bundle)
    changed = {
        key.split(".")[0] for key, value in result.state_dict().items() if not torch.equal(value, before[key])
    }
    assert changed == set(STAGES[name].trains)


def test_the_checkpoint_is_finite_and_is_what_came_back(monkeypatch, tmp_path):
    path = tmp_path / "w.safetensors"
    result = run(STAGES["warm-delight"], itertools.repeat(some_batch()), budget(monkeypatch, 9), path)
    loaded = load_bundle(path)
    for name, value in result.state_dict().items():
        assert torch.isfinite(value).all()
        torch.testing.assert_close(loaded.state_dict()[name], value, rtol=0, atol=0)


def test_losses_that_stay_non_finite_end_the_run_and_nothing_is_saved(monkeypatch, tmp_path):
    batch = some_batch() | {"light": torch.full((1, 2, 16, 32, 3), float("nan"))}
    with pytest.raises(TrainingDiverged):
        run(
            STAGES["warm-delight"],
            itertools.repeat(batch),
            budget(monkeypatch, 60),
            tmp_path / "w.safetensors",
        )
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("spoiled", ["light", "photo_srgb", "albedo"])
def test_one_broken_batch_leaves_no_trace(spoiled, monkeypatch, tmp_path):
    good = some_batch()
    bad = good | {spoiled: torch.full_like(good[spoiled], float("nan"))}
    batches = itertools.chain([good, good, bad], itertools.repeat(good))
    path = tmp_path / "w.safetensors"
    run(STAGES["warm-delight"], batches, budget(monkeypatch, 9), path)
    assert all(torch.isfinite(value).all() for value in load_bundle(path).state_dict().values())


def test_a_head_that_fills_nothing_of_the_image_does_no_harm(monkeypatch, tmp_path):
    batch = some_batch()
    batch["covered"] = torch.zeros_like(batch["covered"])
    path = tmp_path / "w.safetensors"
    run(STAGES["tune-relight"], itertools.repeat(batch), budget(monkeypatch, 9), path)
    assert path.exists()


def test_rate_rises_then_falls_to_its_final_fraction():
    plan = Budget(minutes=1, learning_rate=1.0, warm_up_steps=10, final_fraction=0.02)
    assert plan.rate(0, 0.0) == pytest.approx(0.1)
    assert plan.rate(100, 0.0) == pytest.approx(1.0)
    assert plan.rate(100, 0.5) == pytest.approx(0.51)
    assert plan.rate(100, 1.0) == pytest.approx(0.02)
    assert plan.rate(100, 7.0) == pytest.approx(0.02)


def test_log_and_curves(monkeypatch, tmp_path):
    pytest.importorskip("matplotlib", reason="curves need the training extra")
    path = tmp_path / "w.safetensors"
    run(STAGES["warm-composition"], itertools.repeat(some_batch()), budget(monkeypatch, 101), path)
    log = json.loads(path.with_suffix(".log.json").read_text())
    assert [row["step"] for row in log] == [50, 100]
    draw_curves(path.with_suffix(".log.json"), tmp_path / "curves.png")
    assert (tmp_path / "curves.png").read_bytes().startswith(b"\x89PNG")


def test_curves_of_nothing(tmp_path):
    log = tmp_path / "w.log.json"
    for content in ("[]", "{", '[{"step": 50, "elapsed": 1.0}]'):
        log.write_text(content)
        with pytest.raises(InputError, match="log"):
            draw_curves(log, tmp_path / "curves.png")
    assert not (tmp_path / "curves.png").exists()
