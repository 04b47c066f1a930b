"""`relight evaluate` refuses an option that what it is asked to measure does not read, and asks for no more."""

import pytest
import torch
from synthetic_heads import write_balls, write_lights

from app.cli.main import main
from relight_core.evaluation import breakdown, contest, evaluate
from relight_core.evaluation.ablation import table as ablation
from relight_core.evaluation.ablation import variants
from relight_core.evaluation.peers import table as peers
from relight_core.evaluation.peers.sun import SunConfig, SunModel
from relight_core.networks.bundle import BundleConfig, NetworkBundle, save_bundle
from relight_core.pipeline.quality import quality_of


@pytest.mark.parametrize(
    "words",
    [
        ["networks", "--size", "128"],
        ["networks", "--sun", "sun.safetensors"],
        ["--detail", "--quality", "live"],
        ["--detail", "--weights", "w.safetensors"],
        ["breakdown", "--every", "2"],
        ["ablation", "--photos", "camera"],
        ["ablation", "--weights", "w.safetensors"],
        ["peers", "--quality", "live"],
        ["peers", "--sun", "sun.safetensors", "--steps", "3"],
        ["peers", "--sun", "sun.safetensors", "--pairs", "2"],
    ],
)
def test_an_option_that_would_change_nothing_is_refused(tmp_path, capfd, words):
    data = ["--heads", str(tmp_path), "--lights", str(tmp_path), "-o", str(tmp_path / "out")]
    assert main(["evaluate", *words, *data]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert f"{words[-2]}: changes nothing" in err


def test_a_breakdown_says_nothing_of_detail(tmp_path, capfd):
    assert main(["evaluate", "breakdown", "--detail", "--heads", str(tmp_path), "--lights", str(tmp_path)]) == 2
    assert "--detail does not go with breakdown" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("words", "photos", "quality", "split", "count"),
    [
        ([], "clean", "final", "test", 8),
        (["--photos", "camera", "--quality", "live"], "camera", "live", "test", 8),
        (["--split", "validation", "--count", "3", "--quality", "draft"], "clean", "draft", "validation", 3),
    ],
)
@pytest.mark.parametrize("what", ["networks", "breakdown"])
def test_what_is_measured_is_what_was_asked_for(tmp_path, monkeypatch, what, words, photos, quality, split, count):
    asked = []

    def measured(bundle, settings, report):
        asked.append(settings)
        raise KeyboardInterrupt

    monkeypatch.setattr(*{"networks": (evaluate, "evaluate"), "breakdown": (breakdown, "break_down")}[what], measured)
    first = {"test": 2_000_000, "validation": 1_000_000}[split]
    write_balls(tmp_path / "heads", first, 1, size=32)
    write_lights(tmp_path / "lights.npz", 20)
    save_bundle(tmp_path / "w.safetensors", NetworkBundle(BundleConfig.tiny()))
    data = ["--heads", tmp_path / "heads", "--lights", tmp_path / "lights.npz", "--weights", tmp_path / "w.safetensors"]
    assert main(["evaluate", what, *map(str, data), *words]) == 130
    (settings,) = asked
    assert (settings.photos, quality_of(settings.tier)) == (photos, quality)
    assert (settings.split, settings.count) == (split, count)


@pytest.fixture
def taking_part(monkeypatch):
    """Who would be compared, instead of comparing them."""
    seen = []

    def hold(everybody, *_):
        seen.extend(everybody)
        raise KeyboardInterrupt

    monkeypatch.setattr(contest, "hold", hold)
    return seen


def test_peers_that_learn_nothing_ask_for_no_heads_to_learn_from(tmp_path, taking_part):
    torch.manual_seed(0)
    write_balls(tmp_path / "heads", 2_000_000, 1, size=32)
    write_lights(tmp_path / "lights.npz", 4)
    tables, given = tmp_path / "tables", tmp_path / "ours.safetensors"
    for place in (given, tables / "ours" / "relight.safetensors"):
        place.parent.mkdir(parents=True, exist_ok=True)
        save_bundle(place, NetworkBundle(BundleConfig.tiny()))
    save_bundle(tmp_path / "sun.safetensors", SunModel(SunConfig(width=4, levels=3)), half=False)
    data = ["--heads", str(tmp_path / "heads"), "--lights", str(tmp_path / "lights.npz"), "-o", str(tables)]
    given = ["--weights", str(given), "--sun", str(tmp_path / "sun.safetensors")]
    assert main(["evaluate", "peers", *data, *given, "--size", "32"]) == 130
    assert taking_part[-2:] == ["ours", "ours.safetensors"]


@pytest.mark.parametrize(("what", "has_variants"), [("ablation", False), ("peers", False), ("peers", True)])
def test_a_table_is_trained_and_measured_as_was_asked_for(tmp_path, monkeypatch, what, has_variants):
    for first in (0, 1_000_000):
        write_balls(tmp_path / "heads", first, 1, size=32)
    write_lights(tmp_path / "lights.npz", 20)
    given, budgets, contests = tmp_path / "given.safetensors", [], []
    save_bundle(given, NetworkBundle(BundleConfig.tiny()))

    def trained(heads, lights, folder, *asked):
        budgets.append((heads, lights, *(one for one in asked if not callable(one))))

    def measured(everybody, contest, report):
        contests.append(contest)
        raise KeyboardInterrupt

    monkeypatch.setattr(variants, "train_variants", trained)
    monkeypatch.setattr(variants, "trained_variants", lambda folder: {"Full": given} if has_variants else {})
    monkeypatch.setattr(peers, "trained_sun", trained)
    monkeypatch.setattr(ablation, "score_variants", measured)
    monkeypatch.setattr(contest, "hold", measured)
    data = tmp_path / "heads", tmp_path / "lights.npz"
    words = ["--heads", data[0], "--lights", data[1], "-o", tmp_path / "tables", "--split", "validation", "--count", 3]
    words += ["--size", 32, "--pairs", 2, "--steps", 7, "--every", 5, *(["--weights", given] * (what == "peers"))]
    assert main(["evaluate", what, *map(str, words)]) == 130
    # Beside weights that are given, Sun et al.'s network is as large as theirs; beside the variants as large as those.
    like = [None if has_variants else BundleConfig.tiny().delight] * (what == "peers")
    assert budgets == [(*data, variants.Budget(7, 32, 2), *like)]
    assert contests == [contest.Contest(*data, 32, "validation", 3, 5)]
