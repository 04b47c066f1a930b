"""relight dataset, train and evaluate: bad input in one line, and what they leave behind."""

import json

import cv2
import numpy as np
import pytest
import torch
from PIL import Image
from refusals import refused
from synthetic_heads import write_balls, write_lights

from relight_core.dataset.lighting.lights import load_lights
from relight_core.networks.bundle import BundleConfig, NetworkBundle, load_bundle, save_bundle
from relight_core.pipeline import quality


@pytest.fixture
def data(tmp_path):
    write_lights(tmp_path / "lights.npz", 32)
    for seed in (0, 2_000_000):
        write_balls(tmp_path / "heads", seed, 1, size=32)
    torch.manual_seed(0)
    save_bundle(tmp_path / "tiny.safetensors", NetworkBundle(BundleConfig.tiny()))
    return tmp_path


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("dataset", ("bake", "skins", "lights", "check", "preview", "speed", "effect")),
        ("train", ("--recipe", "warm-delight", "warm-relight", "tune-delight", "distil-relight", "outline", "--join")),
        ("evaluate", ("networks", "breakdown", "ablation", "peers", "--detail")),
    ],
)
def test_help_names_what_there_is(run, command, words):
    code, out, _ = run(command, "--help")
    assert code == 0
    assert [word for word in words if word not in out] == []


def test_an_action_is_needed(run):
    refused(run("dataset"))
    refused(run("dataset", "brew"))


def test_preview_draws_a_sheet(run, data):
    sheet = data / "sheet.png"
    code, out, _ = run(
        "dataset",
        "preview",
        "--shards",
        data / "heads",
        "--lights",
        data / "lights.npz",
        "--count",
        1,
        "-o",
        sheet,
    )
    assert code == 0
    assert "sheet.png" in out
    assert Image.open(sheet).size[0] > 12 * 160


def test_preview_and_training_without_heads_or_lights(run, data):
    (data / "none").mkdir()
    for heads, lights, sheet, word in (
        ("none", "lights.npz", "s.png", "bake"),
        ("heads", "no.npz", "s.png", "no.npz"),
        ("heads", "lights.npz", "s.txt", ".png"),
    ):
        words = ["--shards", data / heads, "--lights", data / lights, "-o", data / sheet]
        refused(run("dataset", "preview", *words), word)
    refused(run("dataset", "preview", "--seed", "-1"), "'-1'")
    words = ["train", "--stage", "warm-delight", "--minutes", 1, "-o", data / "w.safetensors"]
    refused(run(*words, "--heads", data / "gone", "--lights", data / "lights.npz"), "gone")
    refused(run(*words, "--heads", data / "none", "--lights", data / "lights.npz"), "bake")


def train_words(data, **changes):
    words = {
        "--stage": "warm-delight",
        "--heads": data / "heads",
        "--lights": data / "lights.npz",
        "--minutes": 1,
        "--size": 32,
        "-o": data / "w.safetensors",
    } | changes
    return ["train", *(word for pair in words.items() for word in pair)]


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"--stage": "warm-up"}, "warm-delight"),
        ({"--minutes": "0"}, "above 0"),
        ({"--minutes": "nan"}, "above 0"),
        ({"-o": "w.pt"}, ".safetensors"),
        ({"-o": "nowhere/w.safetensors"}, "nowhere"),
        ({"--rate": "-1"}, "above 0"),
        ({"--seed": 2**63}, "below 2**63"),
        ({"--seed": 2**64}, "below 2**63"),
        ({"--size": "24"}, "which warm-delight asks for"),
        ({"--start": "missing.safetensors"}, "missing.safetensors"),
        ({"--stage": "outline", "--uses": "2"}, "used once"),
        ({"--stage": "outline", "--places": "missing"}, "missing: no panoramas"),
        ({"--places": "missing"}, "--places"),
        ({"--window": "64"}, "--uses"),
    ],
)
def test_training_refuses(run, data, changes, word):
    refused(run(*train_words(data, **changes)), word)
    assert not (data / "w.safetensors").exists()


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("--minutes", 5),
        ("--size", 64),
        ("--pairs", 4),
        ("--seed", 0),
        ("--residual", "0,1"),
        ("--decoder-residual", "0,1"),
        ("--uses", 2),
        ("--window", 64),
        ("--rate", 1e-4),
    ],
)
def test_a_recipe_takes_none_of_what_it_says_itself(run, data, option, value):
    words = ["--heads", data / "heads", "--lights", data / "lights.npz", "-o", data / "run"]
    refused(run("train", "--recipe", "shipped", *words, option, value), option, "--stage")
    refused(run("train", "--join", data / "tiny.safetensors", "-o", data / "x.safetensors", option, value), option)
    assert not (data / "run").exists()


def test_training_leaves_weights_and_log(run, data, monkeypatch):
    from relight_core.dataset import stream
    from relight_core.training import run as training

    # One process and a small pool of textures: the command's own path is what is under test.
    loader = training.DataLoader
    asked = []

    def loader_here(samples, **settings):
        asked.append(settings["num_workers"])
        return loader(samples, settings["batch_size"])

    monkeypatch.setattr(training, "DataLoader", loader_here)
    pool = stream.TexturePool
    monkeypatch.setattr(stream, "TexturePool", lambda rng, panoramas=None, **_: pool(rng, None, count=2))
    words = train_words(data, **{"--minutes": 0.001, "--size": 16, "--pairs": 1, "--start": data / "tiny.safetensors"})
    words += ["--workers", 3]
    code, out, err = run(*words)
    assert code == 0, err
    assert "wrote" in out
    assert asked == [3]
    assert load_bundle(data / "w.safetensors").config == BundleConfig.tiny()
    [end] = json.loads((data / "w.log.json").read_text())
    assert end["step"] > 0
    assert end["elapsed"] == 1.0
    assert end["albedo"] > 0


def test_half_a_head_is_told_before_anything_is_learnt_from_the_others(run, data, monkeypatch):
    begun = []
    monkeypatch.setattr("relight_core.training.run.train", lambda *given: begun.append(given))
    monkeypatch.setattr("relight_core.training.recipe.follow", lambda *given, **named: begun.append(given))
    write_balls(data / "heads", 1, 1, size=32)
    half = data / "heads" / "head-0000001.npz"
    half.write_bytes(half.read_bytes()[: half.stat().st_size // 2])
    refused(run(*train_words(data)), half.name, "bake")
    of_recipe = ["--recipe", "shipped", "--heads", data / "heads", "--lights", data / "lights.npz", "-o", data / "run"]
    refused(run("train", *of_recipe), half.name, "bake")
    assert not begun


def test_evaluation_as_json_is_one_object_and_as_text_a_table(run, data):
    write_lights(data / "few.npz", 2)
    words = [
        "evaluate",
        "--heads",
        data / "heads",
        "--lights",
        data / "few.npz",
        "--json",
        "-o",
        data / "report.md",
    ]
    code, out, _ = run(*words, "--weights", data / "tiny.safetensors")
    assert code == 0
    record = json.loads(out)
    assert record["weights"].endswith("tiny.safetensors")
    assert (record["samples"], record["quality"]) == (2, "final")
    assert {"rmse", "psnr", "ssim"} <= set(record["relit"])
    assert "| paper" in (data / "report.md").read_text()


def test_a_breakdown_has_a_row_for_all_that_can_be_told(run, data, monkeypatch):
    from relight_core.evaluation import breakdown

    monkeypatch.setattr(breakdown, "ROWS", {row: breakdown.ROWS[row] for row in ("nothing", "albedo")})
    write_lights(data / "few.npz", 1)
    words = ["evaluate", "breakdown", "--heads", data / "heads", "--lights", data / "few.npz", "--quality", "draft"]
    code, out, _ = run(*words, "--weights", data / "tiny.safetensors", "--json", "-o", data / "breakdown.md")
    assert code == 0
    record = json.loads(out)
    assert list(record["rows"]) == ["nothing", "albedo"]
    assert (record["quality"], record["split"]) == ("draft", "test")
    assert "| nothing |" in (data / "breakdown.md").read_text()
    refused(run(*words, "--weights", data / "none.safetensors"), "none.safetensors")


def test_evaluation_refuses(run, data):
    words = ["evaluate", "--heads", data / "heads", "--lights", data / "lights.npz"]
    refused(run(*words, "--weights", data / "none.safetensors"), "none.safetensors")
    refused(run(*words, "--weights", data / "lights.npz"), "lights.npz")
    refused(run(*words, "--weights", data / "tiny.safetensors", "--split", "validation"), "validation", "bake")
    refused(run(*words, "--weights", data / "tiny.safetensors", "-o", data / "r.pdf"), ".md")
    refused(run(*words, "--split", "train"))
    refused(run(*words, "breakdown", "--detail"), "--detail", "breakdown")
    (data / "heads" / "head-2000000.npz").write_bytes(b"PK\x03\x04")
    refused(run(*words, "--weights", data / "tiny.safetensors"), "head-2000000")


@pytest.mark.parametrize("table", ["ablation", "peers"])
def test_the_paper_s_tables_refuse_before_anything_slow(run, data, table):
    words = ["evaluate", table, "--heads", data / "heads", "--lights", data / "lights.npz", "--size", 32]
    refused(run(*words), "-o")
    refused(run(*words, "-o", data / "tables", "--size", 48), "48", "32")
    refused(run(*words, "-o", data / "tables", "--steps", "0"), "whole number")
    refused(run(*words, "-o", data / "lights.npz"), "lights.npz")
    refused(run(*words[:2], "--heads", data / "none", *words[4:], "-o", data / "tables"), "none")


@pytest.mark.parametrize("table", ["ablation", "peers"])
def test_the_paper_s_tables_look_at_what_they_measure_on_before_they_train(run, data, table):
    write_balls(data / "heads", 2_000_001, 1, size=16)
    words = ["--heads", data / "heads", "--lights", data / "lights.npz", "--size", 32, "-o", data / "tables"]
    refused(run("evaluate", table, *words), "head-2000001.npz", "16 pixels", f"evaluate {table} asks for")
    assert not (data / "tables").exists()


def test_the_paper_s_tables_are_written_whole(run, data, monkeypatch):
    from relight_core.evaluation.ablation import variants
    from relight_core.evaluation.peers import table
    from relight_core.evaluation.peers.sun import Sun, SunConfig, SunModel

    # Trainings have tests of their own: here they are as if done.
    weights = {"DL-RL": data / "tiny.safetensors", "Full": data / "tiny.safetensors"}
    monkeypatch.setattr(variants, "train_variants", lambda *given: weights)
    monkeypatch.setattr(variants, "trained_variants", lambda folder: dict(weights))
    monkeypatch.setattr(table, "trained_sun", lambda *given: Sun(SunModel(SunConfig(4, 3)).eval()))
    write_lights(data / "few.npz", 6)
    words = ["--heads", data / "heads", "--lights", data / "few.npz", "--size", 32, "-o", data / "tables"]
    code, out, _ = run("evaluate", "ablation", *words, "--steps", 7)
    assert code == 0
    assert "7 of warm-delight" in out
    assert "| DL-RL |" in out
    assert (data / "tables" / "ablation.md").read_text() in out
    assert Image.open(data / "tables" / "ablation.png").size == (4 * 32, 32)
    # Pictures as large as the editor's networks see them are relit by the whole editor as well.
    monkeypatch.setitem(quality.TIERS, "final", quality.Tier(32, 32, 32, 8, False))
    code, out, _ = run("evaluate", "peers", *words, "--every", 2, "--json", "--weights", data / "tiny.safetensors")
    assert code == 0
    record = json.loads(out)
    assert record == json.loads((data / "tables" / "peers.json").read_text())
    assert record["training"].endswith(" tiny was trained elsewhere.")
    others, ours = ["Shih et al. 2014", "Shu et al. 2017", "Sun et al. 2019"], ["DL-RL", "Full", "tiny"]
    assert list(record["rows"]) == [*others, *ours, "tiny, in the editor"]
    assert "Shu et al. 2017 (given the truth)" in (data / "tables" / "peers.md").read_text()


def test_others_weights_are_read_before_the_comparison_trains(run, data, monkeypatch):
    from relight_core.evaluation.ablation import variants
    from relight_core.evaluation.peers import table

    trained = []
    monkeypatch.setattr(table, "trained_sun", lambda *given: trained.append(given))
    words = ["evaluate", "peers", "--heads", data / "heads", "--lights", data / "lights.npz", "-o", data / "tables"]
    words += ["--size", 32]
    refused(run(*words, "--dpr", data / "none.t7"), "none.t7", "not shipped")
    refused(run(*words, "--weights", data / "none.safetensors"), "none.safetensors")
    monkeypatch.setattr(variants, "trained_variants", lambda folder: {"Full": data / "gone.safetensors"})
    refused(run(*words), "gone.safetensors")
    assert not trained


def test_a_folder_of_panoramas_becomes_a_library(run, tmp_path):
    places = tmp_path / "places"
    places.mkdir()
    words = ["dataset", "lights", places, "-o", tmp_path / "lights.npz"]
    refused(run(*words), "places", "no .hdr")
    for number in range(2):
        cv2.imwrite(str(places / f"yard_{number}.hdr"), np.ones((4, 8, 3), np.float32))
    code, out, _ = run(*words)
    assert code == 0
    assert out.endswith("2 panoramas of 1 place\n")
    assert load_lights(tmp_path / "lights.npz", "test").names == ("yard_0", "yard_1")
    refused(run("dataset", "lights", tmp_path / "gone", "-o", tmp_path / "l.npz"), "gone")
    refused(run("dataset", "lights", places, "-o", tmp_path / "l.exr"), ".npz")


def test_speed_is_a_table_and_says_when_the_machine_is_busy(run, data, monkeypatch):
    from relight_core.dataset import stream

    pool = stream.TexturePool
    monkeypatch.setattr(stream, "TexturePool", lambda rng, panoramas=None, **_: pool(rng, None, count=2))
    monkeypatch.setattr("os.getloadavg", lambda: (3.0, 1.0, 1.0))
    words = ["dataset", "speed", "--shards", data / "heads", "--lights", data / "lights.npz", "--steps", 0]
    code, out, err = run(*words, "--size", 16)
    assert code == 0, err
    assert "busy" in out
    row = out.strip().splitlines()[-1].split("|")
    assert row[1].strip() == "16"
    assert float(row[3]) > 0
    refused(run(*words, "--size", 16, "--size", 24), "24", "divisor")
    refused(run(*words, "--size", 8), "16 pixels")
    monkeypatch.delattr("os.getloadavg")
    assert "load average" not in run(*words, "--size", 16)[1], "Windows does not tell"


def test_a_recipe_s_last_stage_has_to_suit_the_heads_before_the_first_is_trained(run, data, tmp_path):
    stage = "[[stage]]\nname = 'warm-relight'\nsteps = 1\nsize = "
    (tmp_path / "r.toml").write_text(f"{stage}32\n{stage}64")
    words = ["train", "--recipe", tmp_path / "r.toml", "--heads", data / "heads", "--lights", data / "lights.npz"]
    refused(run(*words, "-o", tmp_path / "out"), "32 pixels", "64", "warm-relight")
    assert not list((tmp_path / "out").iterdir())


def test_a_recipe_s_panoramas_are_looked_for_before_its_first_stage_is_trained(run, data, tmp_path):
    stage = "[[stage]]\nsteps = 1\nsize = 32\nname = "
    (tmp_path / "r.toml").write_text(f"{stage}'warm-relight'\n{stage}'outline'")
    words = ["train", "--recipe", tmp_path / "r.toml", "--heads", data / "heads", "--lights", data / "lights.npz"]
    refused(run(*words, "--places", tmp_path / "missing", "-o", tmp_path / "out"), "missing: no panoramas")
    assert not list((tmp_path / "out").iterdir())


@pytest.mark.parametrize("option", ["--heads", "--lights", "--places"])
def test_joining_reads_no_samples(run, data, option):
    words = ["train", "--join", data / "tiny.safetensors", "--start", data / "tiny.safetensors"]
    refused(run(*words, option, data / "heads", "-o", data / "x.safetensors"), option)


def test_a_recipe_s_result_is_not_written_over_the_weights_it_begins_with(run, data, tmp_path):
    start = tmp_path / "relight.safetensors"
    save_bundle(start, NetworkBundle(BundleConfig.tiny()))
    words = ["train", "--recipe", "person", "--heads", data / "heads", "--lights", data / "lights.npz"]
    refused(run(*words, "--start", start, "-o", tmp_path), "written over")
