"""What the relit picture gains from every part of the truth, with tiny random networks on balls."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
import torch
from synthetic_heads import write_balls, write_lights

from relight_core.evaluation.breakdown import ROWS, as_markdown, as_record, break_down
from relight_core.evaluation.evaluate import Settings, evaluate
from relight_core.networks.bundle import BundleConfig, NetworkBundle
from relight_core.pipeline.quality import Tier, tier_of
from relight_core.pipeline.stages import Surface

SKIN, LIPS, NECK, HAIR, HAT, GLASSES, CLOTH = 1, 8, 9, 10, 11, 12, 13


@pytest.fixture(scope="module")
def settings(tmp_path_factory):
    folder = tmp_path_factory.mktemp("breakdown")
    write_balls(folder / "heads", 2_000_000, 1, size=16)
    write_lights(folder / "lights.npz", 3)
    by_the_sum = {"shadow_network": False, "correction": False}
    return Settings(folder / "heads", folder / "lights.npz", tier=Tier(16, 16, 16, 8, False, **by_the_sum))


@pytest.fixture(scope="module")
def bundle():
    torch.manual_seed(0)
    return NetworkBundle(BundleConfig.tiny()).for_inference()


@pytest.fixture(scope="module")
def breakdown(bundle, settings):
    progress = []
    result = break_down(bundle, settings, lambda done, total: progress.append((done, total)))
    assert progress == [(n, 7) for n in range(1, 8)]
    return result


def surface(seed, labels):
    rng = np.random.default_rng(seed)
    size = labels.shape[0]
    image = lambda channels: torch.from_numpy(rng.random((1, channels, size, size), np.float32))  # noqa: E731
    parsing = torch.from_numpy(np.eye(14, dtype=np.float32)[labels]).permute(2, 0, 1)[None]
    normal = torch.nn.functional.normalize(image(3) - 0.5, dim=1)
    return Surface(
        image(3), image(3), normal, image(1), parsing, torch.ones(1, 1, size, size), torch.rand(1, 16, 32, 3)
    )


def told(row, labels=None):
    labels = np.full((4, 4), SKIN) if labels is None else labels
    found, true = surface(0, labels), surface(1, labels)
    light, true_light = torch.rand(1, 16, 32, 3), torch.rand(1, 16, 32, 3)
    changed, lit_by = ROWS[row](found, light, true, true_light)
    return found, true, changed, (lit_by is light, lit_by is true_light)


@pytest.mark.parametrize(
    ("row", "parts"),
    [
        ("albedo", {"albedo"}),
        ("all normals", {"normal"}),
        ("relief", {"relief"}),
        ("normals and relief", {"normal", "relief"}),
        ("the whole surface", {"albedo", "normal", "relief"}),
        ("the photo's light", set()),
        ("the whole surface and the photo's light", {"albedo", "normal", "relief"}),
    ],
)
def test_a_row_tells_its_own_part_and_no_other(row, parts):
    found, true, changed, (own_light, _) = told(row)
    for name in ("albedo", "normal", "relief", "photo"):
        source = true if name in parts else found
        assert torch.equal(getattr(changed, name), getattr(source, name)), name
    assert own_light == (row not in ("the photo's light", "the whole surface and the photo's light"))


@pytest.mark.parametrize(
    ("row", "label"),
    [
        ("normals of neck, arms and clothes", NECK),
        ("normals of neck, arms and clothes", CLOTH),
        ("normals of hair, headwear and glasses", HAIR),
        ("normals of hair, headwear and glasses", HAT),
        ("normals of hair, headwear and glasses", GLASSES),
        ("normals of the face", SKIN),
        ("normals of the face", LIPS),
    ],
)
def test_normals_of_a_region_end_where_it_does(row, label):
    labels = np.full((4, 4), HAIR if row == "normals of the face" else SKIN)
    labels[2:] = label
    found, true, changed, _ = told(row, labels)
    assert torch.equal(changed.normal[:, :, 2:], true.normal[:, :, 2:])
    assert torch.equal(changed.normal[:, :, :2], found.normal[:, :, :2])


def test_told_the_level_an_albedo_is_as_bright_as_the_true_one_and_no_nearer_otherwise():
    labels = np.full((4, 4), SKIN)
    true = surface(1, labels)
    dim = Surface(**{**true.__dict__, "albedo": true.albedo / 3})
    light = torch.rand(1, 16, 32, 3)
    changed, _ = ROWS["level of the albedo"](dim, light, true, light)
    assert torch.allclose(changed.albedo, true.albedo, atol=0.01)


def test_told_nothing_the_figures_are_those_of_the_evaluation(breakdown, bundle, settings):
    measured = evaluate(bundle, settings).figures
    for group in ("panoramas", "face", "lamps"):
        untold = breakdown.figures["nothing"][group]
        assert untold["relit.psnr"].mean == pytest.approx(measured[group]["relit.psnr"].mean, abs=1e-6)
        assert untold["relit.psnr_gain"].mean == 0


def test_the_sum_of_true_channels_is_nearly_the_true_picture(breakdown):
    """Without networks after de-lighting: what is left is what a relief can't know of a ball."""
    truth = breakdown.figures["the whole surface and the photo's light"]["panoramas"]
    assert truth["relit.psnr_gain"].mean > 10
    assert truth["relit.psnr"].mean > 30


def test_record_and_table_say_the_same(breakdown, settings):
    """One head gives no interval, which JSON has no number for."""
    record = json.loads(json.dumps(as_record(breakdown), allow_nan=False))
    assert record["samples"] == {"panoramas": 3, "face": 3, "lamps": 4}
    table = as_markdown(breakdown, "tiny.safetensors", replace(settings, tier=tier_of("draft")))
    gain = record["rows"]["all normals"]["lamps"]["psnr_gain"]
    line = next(line for line in table.splitlines() if line.startswith("| all normals"))
    assert math.isclose(float(re.findall(r"[+-]\d+\.\d\d", line)[4]), gain, abs_tol=0.006)
    what, rows = table.splitlines()[2], [line for line in table.splitlines() if line.startswith("|")]
    assert what.startswith("tiny.safetensors; test split: 1 head (draft, networks at 128), clean photos.")
    assert "One head alone gives no intervals." in what
    assert len(rows) == 2 + len(record["rows"])
