"""Several ways to relight on the same pictures: balls under random panoramas."""

import json
from dataclasses import replace

import numpy as np
import pytest
import torch
from synthetic_heads import write_balls, write_lights

from relight_core.errors import InputError
from relight_core.evaluation.contest import Contest, OurEditor, OurNetworks, hold
from relight_core.evaluation.contest_report import BORROWED, CHANNELS, RELIT, as_record, heading, table
from relight_core.evaluation.evaluate import Settings, evaluate
from relight_core.evaluation.held_out import held_out_lights, held_out_paths, held_out_textures, load_head
from relight_core.evaluation.metrics import wlog_l2
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import BundleConfig, NetworkBundle
from relight_core.networks.composition import CompositionConfig
from relight_core.networks.delight import DelightConfig
from relight_core.networks.specular_shadow import SpecularShadowConfig
from relight_core.pipeline.quality import Tier

EVEN = np.ones((16, 32, 3), np.float32)


@pytest.fixture(scope="module")
def contest(tmp_path_factory):
    folder = tmp_path_factory.mktemp("contest")
    write_balls(folder / "heads", 2_000_000, 2, size=32)
    write_lights(folder / "lights.npz", 4)
    return Contest(folder / "heads", folder / "lights.npz", 16, count=2)


class Given:
    """Returns the truth, told a light that it did not see."""

    def __init__(self, guess=EVEN, gain=1.0):
        self.guess, self.gain, self.tasks, self.looks = guess, gain, [], []

    def look(self, photo):
        self.looks.append(photo)
        return photo

    def relight(self, seen, task):
        self.tasks.append((seen, task))
        return {"composition": task.reference / task.gain * self.gain}

    def channels(self, seen):
        return {"guess": self.guess} if self.guess is not None else {}


def test_the_truth_has_no_error_and_half_of_it_none_after_alignment(contest):
    outcome = hold({"truth": Given(None), "dim": Given(None, 0.5)}, contest)
    truth, dim = outcome.figures["truth"], outcome.figures["dim"]
    assert truth["relit.rmse"].mean < 2e-3
    assert dim["relit.rmse"].mean > 0.05
    assert dim["relit.rmse_aligned"].mean < 5e-3
    assert dim["relit.psnr_aligned"].mean > dim["relit.psnr"].mean + 10
    assert (outcome.samples, outcome.heads) == (8, 2)
    assert "relit.psnr_gain" not in truth
    assert dim["relit.psnr_gain"].mean == pytest.approx(dim["relit.psnr"].mean - truth["relit.psnr"].mean)
    assert dim["relit.psnr_gain"].high < 0
    assert "light.wlog_l2" not in truth
    assert outcome.sheet.shape == (2 * 16, 4 * 16, 3)
    photo, perfect, dimmed, true = np.hsplit(outcome.sheet, 4)
    np.testing.assert_allclose(perfect, true, atol=1e-5)
    np.testing.assert_allclose(dimmed, true / 2, atol=1e-5)
    assert not np.allclose(photo, true, atol=0.02)


def test_light_is_borrowed_from_the_other_head_in_the_target_light(contest):
    found = Given()
    figures = hold({"even": found}, contest).figures["even"]
    assert len(found.tasks) == 16
    for (_, task), (_, borrowed) in zip(found.tasks[::2], found.tasks[1::2], strict=True):
        assert not np.allclose(task.light, EVEN)
        np.testing.assert_allclose(borrowed.light, EVEN, rtol=1e-5)
        assert borrowed.gain == task.gain
    assert figures["borrowed.wlog_l2"].mean > 0
    assert figures["light.wlog_l2"].mean > 0


class HalfInBorrowedLight(Given):
    def relight(self, seen, task):
        made = super().relight(seen, task)["composition"]
        return {"composition": made / 2 if np.allclose(task.light, EVEN) else made}


def test_what_is_lent_is_the_light_of_the_other_head_s_photo_and_is_measured_apart(contest):
    contest = replace(contest, every=4)
    lights = [light for light in held_out_lights(contest.lights, "test") if not light.lamp]
    heads = [load_head(path, lights, held_out_textures(), 16) for path in held_out_paths(contest.heads, "test", 2)]
    found = HalfInBorrowedLight(3 * EVEN)
    outcome = hold({"even": found, "dim": Given(None, 0.5)}, contest)
    figures, dim = outcome.figures["even"], outcome.figures["dim"]
    cases = [(number, case) for number in (0, 1) for case in contest.cases(number, lights)]
    assert [case.source for _, case in cases] == [0, 1]
    for (number, case), own, lent in zip(cases, found.looks[::2], found.looks[1::2], strict=True):
        np.testing.assert_array_equal(own, heads[number].photo(case.source, "clean"))
        np.testing.assert_array_equal(lent, heads[1 - number].photo(case.target, "clean"))
    of_targets = [wlog_l2(EVEN, lights[case.target].radiance) for _, case in cases]
    of_sources = [wlog_l2(EVEN, lights[case.source].radiance) for _, case in cases]
    assert figures["borrowed.wlog_l2"].mean == pytest.approx(np.mean(of_targets), rel=1e-4)
    assert figures["light.wlog_l2"].mean == pytest.approx(np.mean(of_sources), rel=1e-4)
    assert np.mean(of_sources) != pytest.approx(np.mean(of_targets), rel=1e-2)
    assert figures["relit.rmse"].mean < 2e-3
    assert figures["borrowed.rmse"].mean == pytest.approx(dim["relit.rmse"].mean, rel=1e-5)
    assert figures["borrowed.rmse"].mean > 0.05


def test_fewer_relightings_begin_elsewhere_for_each_head(contest):
    found = Given(None)
    outcome = hold({"truth": found}, replace(contest, every=2))
    assert outcome.samples == 4
    assert hold({"truth": Given(None)}, replace(contest, every=4)).samples == 2
    sources = [task.light for _, task in found.tasks]
    assert not np.allclose(sources[0], sources[2])


def test_a_head_that_no_relighting_is_taken_of_is_not_counted(contest, tmp_path):
    write_lights(tmp_path / "one.npz", 1)
    outcome = hold({"truth": Given(None)}, replace(contest, lights=tmp_path / "one.npz", every=2))
    assert (outcome.samples, outcome.heads) == (1, 1)
    assert "In brackets" not in "\n".join(heading("A title", outcome, "Trained for no time."))


def test_a_gain_is_over_the_contender_in_the_row_above(contest):
    contenders = {"truth": Given(None), "dim": Given(None, 0.5), "truth again": Given(None)}
    figures = hold(contenders, replace(contest, every=4)).figures
    lost = figures["dim"]["relit.psnr_gain"].mean
    assert lost < -10
    assert figures["truth again"]["relit.psnr_gain"].mean == pytest.approx(-lost)


def test_heads_and_lights_are_of_the_split_that_was_asked_for(tmp_path):
    write_balls(tmp_path / "heads", 1_000_000, 1, size=16)
    write_lights(tmp_path / "lights.npz", 20)
    found = Given(None)
    contest = Contest(tmp_path / "heads", tmp_path / "lights.npz", 16, "validation")
    assert hold({"truth": found}, contest).heads == 1
    lights = [light for light in held_out_lights(contest.lights, "validation") if not light.lamp]
    asked = sorted(float(task.light.std()) for _, task in found.tasks)
    assert asked == pytest.approx(sorted(float(light.radiance.std()) for light in lights))


@pytest.mark.parametrize("plain", [False, True])
def test_networks_of_any_variant_take_part(plain, contest):
    torch.manual_seed(0)
    config = BundleConfig.tiny()
    if plain:
        config = BundleConfig(
            DelightConfig(width=4, levels=3, anchored=False, classes=0, relief=False),
            SpecularShadowConfig(4, 3, per_pixel_light=False, relief_shadow=False, additive=True, modulated=False),
            CompositionConfig(4, 2, explicit_sum=False, effects=False, modulated=False),
        )
    networks = OurNetworks(NetworkBundle(config).eval(), ReflectionTable())
    outcome = hold({"networks": networks, "truth": Given(None)}, replace(contest, every=2))
    figures = outcome.figures["networks"]
    assert all(np.isfinite(value.mean) for value in figures.values())
    assert ("shadow.rmse" in figures) is not plain
    assert {"albedo.rmse_aligned", "normal.rmse", "light.wlog_l2", "borrowed.rmse"} <= set(figures)
    record = json.loads(json.dumps(as_record(outcome, "for no time"), allow_nan=False))
    assert record["rows"]["networks"]["relit"]["rmse"] == pytest.approx(figures["relit.rmse"].mean)
    assert record["training"] == "for no time"
    assert len(table(outcome, RELIT)) == 4
    assert len(table(outcome, BORROWED)) == 4
    row = next(line for line in table(outcome, CHANNELS) if line.startswith("| networks"))
    assert row.count("–") == (3 if plain else 0)


def test_the_editor_takes_part_with_the_figures_that_evaluate_gives_it(contest):
    torch.manual_seed(0)
    bundle, tier = NetworkBundle(BundleConfig.tiny()).for_inference(), Tier(32, 32, 32, 8, False)
    contest = replace(contest, size=32)
    outcome = hold({"editor": OurEditor(bundle, ReflectionTable(), tier)}, contest)
    alone = evaluate(bundle, Settings(contest.heads, contest.lights, count=2, tier=tier))
    found, expected = outcome.figures["editor"], alone.figures["panoramas"]
    assert outcome.samples == alone.samples["panoramas"] == 8
    for name in ("relit.psnr", "relit.rmse_aligned", "albedo.rmse", "normal.rmse", "shadow.rmse", "light.wlog_l2"):
        assert found[name].mean == pytest.approx(expected[name].mean, rel=1e-5), name
    assert np.isfinite(found["borrowed.rmse"].mean)


def test_a_size_that_the_heads_have_not_is_refused(contest):
    with pytest.raises(InputError, match="24"):
        hold({"truth": Given()}, replace(contest, size=24))


@pytest.mark.parametrize("heads", [1, 2])
def test_a_page_speaks_of_intervals_where_there_are_any(heads, contest):
    outcome = hold({"truth": Given(None)}, replace(contest, count=heads, every=2))
    page = "\n".join(heading("A title", outcome, "Trained for no time."))
    assert f"test split: {heads} head{'s' * (heads - 1)}, " in page
    assert ("In brackets" in page) == (heads > 1)
    assert any(" to " in line for line in table(outcome, RELIT)[2:]) == (heads > 1)
