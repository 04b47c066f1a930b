"""Training steps on a batch that stays the same, with a clock that counts steps."""

import itertools
import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
import safetensors.torch
import torch
from small_runs import SIZE, budget, recorded, run, some_batch
from tiny_networks import tiny_bundle_with_person

from relight_core.errors import InputError
from relight_core.imaging.contact_sheet import contact_sheet
from relight_core.networks.bundle import (
    BundleConfig,
    NetworkBundle,
    load_bundle,
    with_foreign_shadow_network,
    with_residual_blocks,
)
from relight_core.networks.foreign_shadow import ForeignShadowConfig, ForeignShadowNetwork
from relight_core.training import loop, sheet
from relight_core.training.curves import draw_curves
from relight_core.training.loop import Budget, TrainingDiverged, train_stage
from relight_core.training.stages import STAGES

pytestmark = pytest.mark.usefixtures("seeded")


@pytest.mark.parametrize(
    "name", [name for name, stage in STAGES.items() if not stage.distilled and stage.samples == "pairs"]
)
def test_ten_steps_on_one_batch_lower_the_loss(name, tmp_path):
    totals = []
    batch = some_batch()
    run(
        recorded(STAGES[name], totals),
        itertools.repeat(batch),
        budget(12),
        tmp_path / "w.safetensors",
    )
    assert len(totals) >= 10
    assert min(totals[-3:]) < totals[0]


@pytest.mark.parametrize("name", ["warm-delight", "tune-relight"])
def test_only_the_stage_s_networks_change(name, tmp_path):
    bundle = NetworkBundle(BundleConfig.tiny())
    before = {key: value.clone() for key, value in bundle.state_dict().items()}
    path = tmp_path / "w.safetensors"
    result = run(STAGES[name], itertools.repeat(some_batch()), budget(9), path, bundle)
    changed = {key.split(".")[0] for key, value in result.state_dict().items() if not torch.equal(value, before[key])}
    assert changed == set(STAGES[name].trains)


def test_the_checkpoint_is_finite_and_is_what_came_back(tmp_path):
    path = tmp_path / "w.safetensors"
    result = run(STAGES["warm-delight"], itertools.repeat(some_batch()), budget(9), path)
    loaded = load_bundle(path)
    for name, value in result.state_dict().items():
        assert torch.isfinite(value).all()
        torch.testing.assert_close(loaded.state_dict()[name], value, rtol=0, atol=0)


def test_losses_that_stay_non_finite_end_the_run_and_nothing_is_saved(tmp_path):
    batch = some_batch() | {"light": torch.full((1, 2, 16, 32, 3), float("nan"))}
    with pytest.raises(TrainingDiverged, match="^20 non-finite"):
        run(
            STAGES["warm-delight"],
            itertools.repeat(batch),
            budget(60),
            tmp_path / "w.safetensors",
        )
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "spoiled"),
    [*(("warm-delight", spoiled) for spoiled in ("light", "photo_srgb", "albedo")), ("tune-delight", "photo_srgb")],
)
def test_one_broken_batch_leaves_no_trace(name, spoiled, tmp_path):
    good = some_batch()
    bad = good | {spoiled: torch.full_like(good[spoiled], float("nan"))}
    batches = itertools.chain([good, good, bad], itertools.repeat(good))
    path = tmp_path / "w.safetensors"
    run(STAGES[name], batches, budget(9), path)
    assert all(torch.isfinite(value).all() for value in load_bundle(path).state_dict().values())


class Killed(Exception):
    pass


def batches_until(broken, at):
    """Batches that differ from each other; the one numbered `at` never comes."""
    for number in itertools.count():
        if number == at and broken:
            raise Killed
        with torch.random.fork_rng():
            torch.random.manual_seed(number)
            batch = some_batch()
        yield batch


@pytest.mark.parametrize("name", ["warm-delight", "warm-relight"])
def test_a_run_that_was_killed_goes_on_as_if_it_had_not_been(name, tmp_path):
    whole, halves = tmp_path / "whole.safetensors", tmp_path / "halves.safetensors"
    start = NetworkBundle(BundleConfig.tiny()).state_dict()

    def train(path, broken):
        bundle = NetworkBundle(BundleConfig.tiny())
        bundle.load_state_dict(start)
        plan = budget(12, checkpoint_seconds=0)
        torch.random.manual_seed(0)
        run(STAGES[name], batches_until(broken, 7), plan, path, bundle)

    train(whole, broken=False)
    with pytest.raises(Killed):
        train(halves, broken=True)
    train(halves, broken=False)
    expected = load_bundle(whole).state_dict()
    for key, value in load_bundle(halves).state_dict().items():
        torch.testing.assert_close(value, expected[key], rtol=0, atol=0)
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "halves.log.json",
        "halves.safetensors",
        "halves.samples.png",
        "whole.log.json",
        "whole.safetensors",
        "whole.samples.png",
    ]


def test_a_run_that_is_killed_at_its_first_checkpoint_is_not_taken_for_one_that_has_ended(tmp_path, monkeypatch):
    def killed(*_):
        raise Killed

    path = tmp_path / "w.safetensors"
    monkeypatch.setattr(loop, "draw_samples", killed)
    with pytest.raises(Killed):
        run(STAGES["warm-delight"], batches_until(False, 0), budget(9, checkpoint_seconds=0), path)
    assert loop.state_path(path).exists()


def test_a_stage_in_which_one_of_its_networks_has_nothing_to_learn_goes_on_too(tmp_path):
    tiny = BundleConfig.tiny()
    config = replace(tiny, composition=replace(tiny.composition, effects=False))
    path, stage = tmp_path / "w.safetensors", STAGES["tune-on-predictions"]
    with pytest.raises(Killed):
        run(stage, batches_until(True, 4), budget(9, checkpoint_seconds=0), path, NetworkBundle(config))
    run(stage, batches_until(False, 0), budget(9), path, NetworkBundle(config))
    assert not loop.state_path(path).exists()


@pytest.mark.parametrize("other", ["warm-relight", "tune-delight"])
def test_a_state_of_something_else_is_refused(other, tmp_path):
    path = tmp_path / "w.safetensors"
    with pytest.raises(Killed):
        run(STAGES["warm-delight"], batches_until(True, 4), budget(9, checkpoint_seconds=0), path)
    with pytest.raises(InputError, match="state"):
        run(STAGES[other], itertools.repeat(some_batch()), budget(9), path)


def test_a_run_goes_on_with_the_batches_that_it_began_with_or_not_at_all(tmp_path):
    path, stage = tmp_path / "w.safetensors", STAGES["warm-delight"]
    with pytest.raises(Killed):
        run(stage, batches_until(True, 4), budget(9, checkpoint_seconds=0), path, drawn_by={"size": 32, "seed": 7})
    kept = loop.state_path(path).read_bytes()
    with pytest.raises(InputError, match="began with seed 7 and not 8"):
        run(stage, batches_until(False, 0), budget(9), path, drawn_by={"size": 32, "seed": 8})
    assert loop.state_path(path).read_bytes() == kept
    run(stage, batches_until(False, 0), budget(9), path, drawn_by={"size": 32, "seed": 7})
    assert not loop.state_path(path).exists()


def test_a_state_of_other_networks_is_refused_in_a_line_that_can_be_read(tmp_path):
    path, stage = tmp_path / "w.safetensors", STAGES["warm-delight"]
    with pytest.raises(Killed):
        run(stage, batches_until(True, 4), budget(9, checkpoint_seconds=0), path)
    more = with_residual_blocks(NetworkBundle(BundleConfig.tiny()), (0, 1, 1), (), settled=False)
    with pytest.raises(InputError, match="began with other networks") as refused:
        run(stage, batches_until(False, 0), budget(9), path, more)
    assert len(str(refused.value)) < 300 + len(str(path))


@pytest.mark.parametrize(
    ("found", "told"), [("relight-training-3", "an earlier version's training run"), ("x", "not the state of a")]
)
def test_a_state_that_is_not_ours_any_more_or_never_was_is_told_apart(found, told, tmp_path):
    path = tmp_path / "w.safetensors"
    safetensors.torch.save_file({"random": torch.zeros(1)}, loop.state_path(path), metadata={"format": found})
    with pytest.raises(InputError, match=told):
        run(STAGES["warm-delight"], itertools.repeat(some_batch()), budget(9), path)


def test_skipped_batches_are_counted(tmp_path):
    good, seen = some_batch(), []
    bad = good | {"light": torch.full_like(good["light"], float("nan"))}
    batches = itertools.chain([bad, good, bad], itertools.repeat(good))
    bundle = NetworkBundle(BundleConfig.tiny())
    train_stage(
        STAGES["warm-delight"],
        bundle,
        lambda first: batches,
        budget(60),
        tmp_path / "w.safetensors",
        lambda elapsed, progress: seen.append(progress.skipped),
    )
    assert seen == [2, 2]


def test_a_budget_is_of_time_or_of_steps():
    for settings in ({}, {"minutes": 1, "steps": 1}):
        with pytest.raises(ValueError, match="either"):
            Budget(1e-3, **settings)
    assert Budget(1e-3, minutes=2).spent(step=7, seconds=30.0) == 0.25
    assert Budget(1e-3, steps=28).spent(step=7, seconds=30.0) == 0.25


def test_a_head_that_fills_nothing_of_the_image_does_no_harm(tmp_path):
    batch = some_batch()
    batch["covered"] = torch.zeros_like(batch["covered"])
    path = tmp_path / "w.safetensors"
    run(STAGES["tune-relight"], itertools.repeat(batch), budget(9), path)
    assert path.exists()


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        (
            "warm-delight",
            "photo, albedo, true albedo, normals, true normals, parsing, true parsing, "
            "specular, true specular, shadow, true shadow, image, true image",
        ),
        ("warm-relight", "specular, true specular, shadow, true shadow, image, true image"),
    ],
)
def test_a_sheet_names_every_channel_and_shows_it_beside_the_truth(name, shown, tmp_path, monkeypatch):
    batch, drawn = some_batch(pairs=2), []
    if not STAGES[name].photographs:
        del batch["photo_srgb"]

    def laid_out(pictures, columns, cell_px):
        drawn.append((pictures, columns))
        return contact_sheet(pictures, columns, cell_px)

    monkeypatch.setattr(sheet, "contact_sheet", laid_out)
    run(STAGES[name], itertools.repeat(batch), budget(2), tmp_path / "w.safetensors")
    ((pictures, columns),) = drawn
    names = shown.split(", ")
    assert [label for label, _ in pictures] == names * 4
    assert columns == len(names)
    true_image = batch["image"].flatten(0, 1).permute(0, 2, 3, 1)[0].numpy()
    encoded = np.where(true_image <= 0.0031308, 12.92 * true_image, 1.055 * true_image ** (1 / 2.4) - 0.055)
    np.testing.assert_allclose(pictures[columns - 1][1], encoded, atol=1.5 / 255)


def test_a_sheet_is_drawn_where_every_name_has_room_and_its_colours_are_the_pictures_own(tmp_path):
    batch = some_batch()
    del batch["photo_srgb"]
    batch["image"][0, 0] = torch.tensor([0.2, 0.5, 0.8])[:, None, None]
    run(STAGES["warm-relight"], itertools.repeat(batch), budget(2), tmp_path / "w.safetensors")
    drawn = cv2.imread(str(tmp_path / "w.samples.png"))
    assert drawn.shape == (2 * (112 + 22 + 8) + 8, 6 * (112 + 8) + 8, 3)
    last = drawn[8 : 8 + 112, -8 - 112 : -8, ::-1]
    np.testing.assert_allclose(last, np.broadcast_to([124, 188, 231], last.shape), atol=1)


def test_rate_rises_then_falls_to_its_final_fraction():
    plan = Budget(1.0, minutes=1, warm_up_steps=10, final_fraction=0.02)
    assert plan.rate(0, 0.0) == pytest.approx(0.1)
    assert plan.rate(100, 0.0) == pytest.approx(1.0)
    assert plan.rate(100, 0.5) == pytest.approx(0.51)
    assert plan.rate(100, 1.0) == pytest.approx(0.02)
    assert plan.rate(100, 1.5) == pytest.approx(0.02)


def test_log_and_curves(tmp_path):
    pytest.importorskip("matplotlib", reason="curves need the training extra")
    path = tmp_path / "w.safetensors"
    run(STAGES["warm-composition"], itertools.repeat(some_batch()), budget(101), path)
    log = json.loads(path.with_suffix(".log.json").read_text())
    assert [row["step"] for row in log] == [50, 100, 101]
    draw_curves(path.with_suffix(".log.json"), tmp_path / "curves.png")
    assert (tmp_path / "curves.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(("steps", "noted"), [(3, [3]), (50, [50])])
def test_a_log_has_a_run_s_end_once_however_short_the_run(steps, noted, tmp_path):
    path = tmp_path / "w.safetensors"
    run(STAGES["warm-composition"], itertools.repeat(some_batch()), budget(steps), path)
    log = json.loads(path.with_suffix(".log.json").read_text())
    assert [row["step"] for row in log] == noted
    assert log[-1]["encoded"] > 0


def test_one_row_of_a_log_is_drawn_as_a_point(tmp_path):
    pytest.importorskip("matplotlib", reason="curves need the training extra")
    log, picture = tmp_path / "w.log.json", tmp_path / "curves.png"
    log.write_text('[{"step": 50, "elapsed": 1.0, "relit": 0.3}]')
    draw_curves(log, picture)
    assert np.ptp(cv2.imread(str(picture)).astype(int), axis=2).max() > 50


def test_curves_of_nothing(tmp_path):
    log = tmp_path / "w.log.json"
    rows = ['{"step": 50, "elapsed": 1.0}', '{"relit": 0.3}', '{"step": 50, "relit": "low"}', '{"step": 50, "x": 1}, 3']
    for content in ("[]", "{", *(f"[{row}]" for row in rows)):
        log.write_text(content)
        with pytest.raises(InputError, match="log"):
            draw_curves(log, tmp_path / "curves.png")
    assert not (tmp_path / "curves.png").exists()


def test_the_person_network_learns_and_the_others_stay(tmp_path):
    bundle = tiny_bundle_with_person()
    person = torch.zeros(2, 1, SIZE, SIZE)
    person[..., 4:12, 4:12] = 1
    batch = {
        "photo_srgb": (person + torch.rand(2, 3, SIZE, SIZE)) / 2,
        "inside": torch.ones(2, 1, SIZE, SIZE),
        "face": torch.nn.functional.pad(torch.ones(2, 1, 4, 4), (6, 6, 6, 6)),
        "person": person,
    }
    before = {name: value.clone() for name, value in bundle.state_dict().items()}
    totals = []
    stage = recorded(STAGES["outline"], totals)
    run(stage, itertools.repeat(batch), budget(40), tmp_path / "w.safetensors", bundle)
    assert totals[-1] < 0.7 * totals[0]
    for name, value in bundle.state_dict().items():
        assert name.startswith("person.") or torch.equal(value.cpu(), before[name])
    assert (tmp_path / "w.samples.png").exists()


def test_the_foreign_shadow_network_learns_and_the_others_stay(tmp_path):
    tiny = NetworkBundle(BundleConfig.tiny())
    bundle = with_foreign_shadow_network(tiny, ForeignShadowNetwork(ForeignShadowConfig(4, 3, 8)))
    shadow = torch.zeros(2, 3, SIZE, SIZE)
    shadow[..., : SIZE // 2] = -1
    batch = {
        "photo_srgb": 0.6 * shadow.exp() + 0.1 * torch.rand(2, 3, SIZE, SIZE),
        "kinds": torch.ones(2, 4, SIZE, SIZE) / 4,
        "foreign_shadow": shadow,
        "person": torch.ones(2, 1, SIZE, SIZE),
    }
    before = {name: value.clone() for name, value in bundle.state_dict().items()}
    totals = []
    run(
        recorded(STAGES["foreign-shadow"], totals),
        itertools.repeat(batch),
        budget(80),
        tmp_path / "w.safetensors",
        bundle,
    )
    assert totals[-1] < 0.7 * totals[0]
    for name, value in bundle.state_dict().items():
        assert name.startswith("foreign_shadow.") or torch.equal(value.cpu(), before[name])
    assert (tmp_path / "w.samples.png").exists()
