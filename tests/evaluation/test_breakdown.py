"""What the relit picture gains from every part of the truth, with tiny random networks on balls."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
import torch
from synthetic_heads import write_balls, write_lights

from relight_core.evaluation.breakdown import ROWS, Breakdown, as_markdown, as_record, break_down
from relight_core.evaluation.evaluate import Settings, evaluate
from relight_core.evaluation.held_out import HeldOutHead
from relight_core.evaluation.metrics import Interval
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
    true = surface(1, np.full((4, 4), SKIN) if labels is None else labels)
    found = surface(0, np.full((4, 4), CLOTH) if labels is None else labels[::-1])
    found = replace(found, person=0.5 * found.person)
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
        ("the whole surface", {"albedo", "normal", "relief", "parsing", "person"}),
        ("the photo's light", set()),
        ("the whole surface and the photo's light", {"albedo", "normal", "relief", "parsing", "person"}),
    ],
)
def test_a_row_tells_its_own_part_and_no_other(row, parts):
    found, true, changed, (own_light, _) = told(row)
    for name in ("albedo", "normal", "relief", "parsing", "person", "photo"):
        source = true if name in parts else found
        assert torch.equal(getattr(changed, name), getattr(source, name)), name
    assert own_light == (row not in ("the photo's light", "the whole surface and the photo's light"))


@pytest.mark.parametrize(("row", "part"), [("albedo", "albedo"), ("all normals", "normal"), ("relief", "relief")])
def test_beside_the_head_there_is_no_truth_of_its_surface_to_be_told(row, part):
    """What is taken for the person reaches a little beyond the head, and a height of 0 beside it is a wall."""
    labels, light = np.full((4, 4), SKIN), torch.rand(1, 16, 32, 3)
    true, found = surface(1, labels), surface(0, labels)
    true.person[..., 2:] = 0
    changed, _ = ROWS[row](found, light, true, light)
    assert torch.equal(getattr(changed, part)[..., 2:], getattr(found, part)[..., 2:])
    whole, _ = ROWS["the whole surface"](found, light, true, light)
    assert torch.equal(whole.person, true.person)


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
    true = surface(1, np.full((4, 4), SKIN))
    # A pixel that is not all of the head has no say, and what it comes to is an albedo nevertheless.
    true.person[..., 0] = 0.5
    dim = replace(true, albedo=true.albedo / 3)
    dim.albedo[..., 0] = 0.9
    light = torch.rand(1, 16, 32, 3)
    changed, _ = ROWS["level of the albedo"](dim, light, true, light)
    assert torch.allclose(changed.albedo[..., 1:], true.albedo[..., 1:], atol=0.01)
    assert float(changed.albedo.max()) == 1


def test_told_nothing_the_figures_are_those_of_the_evaluation(breakdown, bundle, settings):
    measured = evaluate(bundle, settings).figures
    for group in ("panoramas", "face", "lamps"):
        untold = breakdown.figures["nothing"][group]
        assert untold["relit.psnr"].mean == pytest.approx(measured[group]["relit.psnr"].mean, abs=1e-6)
        assert untold["relit.psnr_gain"].mean == 0


@pytest.mark.parametrize("measured", [break_down, evaluate])
@pytest.mark.parametrize("photos", ["clean", "camera"])
def test_the_photos_are_of_the_kind_that_was_asked_for(bundle, settings, monkeypatch, measured, photos):
    def photo(head, light, kind):
        raise LookupError(kind)

    monkeypatch.setattr(HeldOutHead, "photo", photo)
    with pytest.raises(LookupError, match=photos):
        measured(bundle, replace(settings, photos=photos))


def some_figures(psnr, aligned, gain):
    names = ("relit.psnr", "relit.psnr_gain", "relit.psnr_aligned", "relit.psnr_aligned_gain")
    values = (psnr, gain, aligned, 2 * gain)
    return {name: Interval(value, value - 0.25, value + 0.5) for name, value in zip(names, values, strict=True)}


def test_every_gain_stands_with_its_interval_under_what_it_was_measured_on(settings):
    nothing = {"panoramas": some_figures(20, 22, 0), "lamps": some_figures(10, 11, 0)}
    albedo = {"panoramas": some_figures(21, 24, 1), "lamps": some_figures(9, 9, -1)}
    made = Breakdown({"nothing": nothing, "albedo": albedo}, {"panoramas": 6, "lamps": 8}, 2)
    page = as_markdown(made, "w", replace(settings, split="validation", photos="camera")).splitlines()
    assert page[2].startswith("w; validation split: 2 heads ")
    assert ", camera photos. " in page[2]
    assert page[4] == (
        "| de-lighting is told | panoramas (6), dB | panoramas (6), one exposure | lamps (8), dB | "
        "lamps (8), one exposure |"
    )
    assert page[6] == "| nothing | 20.00 | 22.00 | 10.00 | 11.00 |"
    assert page[7] == (
        "| albedo | +1.00 (+0.75 to +1.50) | +2.00 (+1.75 to +2.50) | -1.00 (-1.25 to -0.50) | -2.00 (-2.25 to -1.50) |"
    )
    recorded = as_record(made)["rows"]["albedo"]["panoramas"]
    assert (recorded["psnr"], recorded["psnr_gain"], recorded["psnr_aligned_gain"]) == (21, 1, 2)
    assert (recorded["gain_interval"], recorded["aligned_gain_interval"]) == ([0.75, 1.5], [1.75, 2.5])


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
