"""The whole evaluation with tiny random networks on balls."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
import torch
from synthetic_heads import write_balls, write_lights

from relight_core.errors import InputError
from relight_core.evaluation.evaluate import Settings, evaluate, intervals_over_heads
from relight_core.evaluation.held_out import (
    HeldOutLight,
    cases_of,
    held_out_lights,
    held_out_paths,
    held_out_textures,
    lamp,
    load_head,
)
from relight_core.evaluation.report import as_markdown, as_record
from relight_core.lighting.environment import network_light
from relight_core.networks.bundle import BundleConfig, NetworkBundle
from relight_core.pipeline.quality import Tier


@pytest.fixture(scope="module")
def settings(tmp_path_factory):
    folder = tmp_path_factory.mktemp("evaluation")
    write_balls(folder / "heads", 2_000_000, 2, size=16)
    write_balls(folder / "heads", 0, 1, size=16)
    write_lights(folder / "lights.npz", 3)
    return Settings(folder / "heads", folder / "lights.npz", tier=Tier(16, 16, 16, 8, False))


@pytest.fixture(scope="module")
def bundle():
    torch.manual_seed(0)
    return NetworkBundle(BundleConfig.tiny()).for_inference()


@pytest.fixture(scope="module")
def evaluation(bundle, settings):
    progress = []
    result = evaluate(bundle, settings, lambda done, total: progress.append((done, total)))
    assert progress == [(n, 14) for n in range(1, 15)]
    return result


def some_lights(panoramas, lamps):
    black = np.zeros((16, 32, 3), np.float32)
    return [HeldOutLight(f"p{i}", black, False) for i in range(panoramas)] + [
        HeldOutLight(f"l{i}", black, True) for i in range(lamps)
    ]


@pytest.mark.parametrize("head", range(8))
def test_every_panorama_is_source_once_and_target_once(head):
    cases = cases_of(head, some_lights(20, 4))
    of_panoramas, of_lamps = cases[:20], cases[20:]
    assert sorted(case.source for case in of_panoramas) == list(range(20))
    assert sorted(case.target for case in of_panoramas) == list(range(20))
    assert all(case.source != case.target for case in of_panoramas)
    assert [case.target for case in of_lamps] == [20, 21, 22, 23]
    assert all(case.source < 20 for case in of_lamps)


@pytest.mark.parametrize(("panoramas", "heads"), [(20, 8), (8, 7), (15, 8), (36, 8)])
def test_heads_pair_the_lights_differently(panoramas, heads):
    cases = [case for head in range(heads) for case in cases_of(head, some_lights(panoramas, 4))]
    assert len(set(cases)) == len(cases)


def test_lamps_are_told_from_every_panorama_in_turn():
    """Eight panoramas, four lamps: after two heads all were sources once, and then for other lamps."""
    cases = [case for head in range(8) for case in cases_of(head, some_lights(8, 4)) if case.target >= 8]
    assert len(set(cases)) == 32


def test_one_panorama_is_enough():
    assert [(case.source, case.target) for case in cases_of(3, some_lights(1, 1))] == [(0, 0), (0, 1)]


@pytest.mark.parametrize(("off", "around"), [(50, 0), (60, 145), (70, 180), (60, 35)])
def test_a_lamp_stands_where_it_should_with_unit_level(off, around):
    light = network_light(lamp(off, around))
    theta = np.pi * (np.arange(16) + 0.5) / 16
    phi = 2 * np.pi * ((np.arange(32) + 0.5) / 32 - 0.5)
    x, z = np.outer(np.sin(theta), np.sin(phi)), -np.outer(np.sin(theta), np.cos(phi))
    toward = np.stack([x, np.outer(np.cos(theta), np.ones(32)), z], -1)
    edges = np.cos(np.pi * np.arange(17) / 16)
    weight = np.repeat(((edges[:-1] - edges[1:]) * 2 * np.pi / 32)[:, None], 32, 1)
    assert (light[..., 1] * weight).sum() / (4 * np.pi) == pytest.approx(1, rel=1e-3)
    place = (toward * ((light[..., 1] - light.min()) * weight)[..., None]).sum((0, 1))
    place /= np.linalg.norm(place)
    expected = [
        math.sin(math.radians(off)) * math.cos(math.radians(around)),
        math.sin(math.radians(off)) * math.sin(math.radians(around)),
        math.cos(math.radians(off)),
    ]
    assert math.degrees(math.acos(min(1.0, float(place @ expected)))) < 6


def test_a_lamp_of_five_degrees_has_nearly_all_of_the_light():
    shape = lamp(60, 145).shape[..., 1]
    edges = np.cos(np.pi * np.arange(65) / 64)
    areas = np.repeat(((edges[:-1] - edges[1:]) * 2 * np.pi / 128)[:, None], 128, 1)
    bright = shape > 1
    assert areas[bright].sum() == pytest.approx(2 * math.pi * (1 - math.cos(math.radians(5))), rel=0.2)
    assert (shape * areas)[bright].sum() / (4 * math.pi) == pytest.approx(0.95, abs=0.001)
    np.testing.assert_allclose(shape[~bright], 0.05, rtol=1e-3)


def test_heads_lights_and_photos_are_the_same_every_time(settings):
    lights = [held_out_lights(settings.lights, "test") for _ in range(2)]
    for one, other in zip(*lights, strict=True):
        np.testing.assert_array_equal(one.radiance, other.radiance)
    assert [light.lamp for light in lights[0]] == [False] * 3 + [True] * 4
    path = settings.heads / "head-2000001.npz"
    heads = [load_head(path, lights[0], held_out_textures()) for _ in range(2)]
    for kind in ("clean", "camera"):
        photos = [head.photo(1, kind) for head in heads]
        np.testing.assert_array_equal(*photos)
        assert 0 <= photos[0].min() <= photos[0].max() <= 1
    assert heads[0].photo(1, "clean")[~heads[0].lit.head.covered].max() == 0


def test_photos_through_a_camera_are_linear_as_the_clean_ones_are(settings):
    """Encoded, they would be twice as bright."""
    lights = held_out_lights(settings.lights, "test")
    head, stops = load_head(settings.heads / "head-2000000.npz", lights, held_out_textures()), []
    for light in range(len(lights)):
        clean, shot = (head.photo(light, kind)[head.lit.head.covered].mean() for kind in ("clean", "camera"))
        stops.append(math.log2(shot / clean))
    assert max(stops) - min(stops) > 0.5, "each has an exposure of its own"
    assert abs(sum(stops) / len(stops)) < 0.4


def test_every_panorama_is_turned_by_an_angle_of_its_own_and_its_sun_with_it(tmp_path):
    env64 = np.full((3, 64, 128, 3), 0.1, np.float32)
    env64[:, 21, 60] = 5000
    np.savez(tmp_path / "suns.npz", env64=env64, names=np.array(["a", "b", "c"]), group=np.arange(3))
    suns = [light for light in held_out_lights(tmp_path / "suns.npz", "test") if not light.lamp]
    columns = []
    for sun in suns:
        (rows,) = np.nonzero(sun.radiance.max((1, 2)) > 1)
        assert rows.tolist() == [21 // 4], "as sharp as in training"
        (found,) = sun.small_lamps
        x, _, z = found.toward
        column = 32 * (math.atan2(x, -z) / (2 * math.pi) + 0.5)
        away = np.abs((np.arange(32) + 0.5 - column + 16) % 32 - 16)
        assert away[sun.radiance[21 // 4, :, 1] > 1].max() < 2
        columns.append(column)
    assert min(abs(one - other) for one, other in zip(columns, columns[1:], strict=False)) > 1


def test_heads_have_skins_of_their_own_and_clean_photos_are_metered(settings):
    lights, pool = held_out_lights(settings.lights, "test"), held_out_textures()
    paths = held_out_paths(settings.heads, "test", 5)
    assert held_out_paths(settings.heads, "test", 1) == paths[:1] == [settings.heads / "head-2000000.npz"]
    one, other = (load_head(path, lights, pool) for path in paths)
    assert not np.allclose(one.albedo, other.albedo, atol=0.01)
    brightest = [head.channels(light)["image"].mean() for head in (one, other) for light in range(7)]
    shown = [head.photo(light, "clean").mean() for head in (one, other) for light in range(7)]
    assert max(shown) / min(shown) < 0.5 * max(brightest) / min(brightest)


def test_figures_of_every_group(evaluation):
    assert evaluation.samples == {
        "panoramas": 6,
        "face": 6,
        "lamps": 8,
        "true surface, panoramas": 6,
        "true surface, lamps": 8,
    }
    assert (evaluation.heads, evaluation.lights, evaluation.size) == (2, 3, 16)
    for group in evaluation.figures.values():
        for interval in group.values():
            assert math.isfinite(interval.mean)
            assert interval.low <= interval.mean <= interval.high
    assert set(evaluation.figures["panoramas"]) >= {
        "relit.rmse",
        "relit.psnr",
        "relit.ssim",
        "relit.rmse_aligned",
        "albedo.rmse",
        "albedo.rmse_aligned",
        "normal.rmse",
        "normal.angle_deg",
        "specular.rmse",
        "specular.relative",
        "shadow.rmse",
        "shadow.relative",
        "light.wlog_l2",
    }
    assert "albedo.rmse" not in evaluation.figures["true surface, panoramas"]


def test_alignment_never_hurts_and_true_normals_help(evaluation):
    whole = evaluation.figures["panoramas"]
    assert whole["relit.rmse_aligned"].mean < whole["relit.rmse"].mean
    assert evaluation.figures["true surface, panoramas"]["relit.rmse"].mean < whole["relit.rmse"].mean


def test_the_same_again_gives_the_same(evaluation, bundle, settings):
    again = evaluate(bundle, settings)
    assert again.figures == evaluation.figures


def test_record_has_the_promised_keys_and_is_json(evaluation):
    record = json.loads(json.dumps(as_record(evaluation, "tiny.safetensors"), allow_nan=False))
    assert {"relit", "albedo", "normal", "specular", "shadow", "light", "samples", "weights"} <= set(record)
    assert {"rmse", "psnr", "ssim"} <= set(record["relit"])
    assert all("rmse" in record[name] for name in ("albedo", "normal", "specular", "shadow"))
    assert set(record["light"]) == {"wlog_l2", "wlog_l2_fitted"}
    assert record["samples"] == 6
    assert record["weights"] == "tiny.safetensors"
    low, high = record["intervals"]["relit"]["rmse"]
    assert low <= record["relit"]["rmse"] <= high
    assert record["lamps"]["samples"] == 8


def test_one_head_has_no_interval_but_figures(bundle, settings):
    alone = evaluate(bundle, replace(settings, count=1, photos="camera"))
    record = json.loads(json.dumps(as_record(alone, "w"), allow_nan=False))
    assert record["intervals"]["relit"]["rmse"] == [None, None]
    page = as_markdown(alone, "w")
    assert not re.search(r"\bnan\b", page)
    assert "test split: 1 head, " in page
    assert "In brackets" not in page


def test_the_interval_of_two_heads_holds_nothing_that_a_figure_can_t_be():
    figures = [
        {"relit.rmse": error, "relit.psnr": decibels, "relit.ssim": similarity, "relit.ssim_aligned": similarity}
        for error, decibels, similarity in ((0.05, 10.0, 0.95), (0.15, 40.0, 0.85))
    ]
    intervals = intervals_over_heads(list(zip("ab", figures, strict=True)))
    assert intervals["relit.rmse"].low == 0
    assert intervals["relit.rmse"].high == pytest.approx(0.1 + 12.706205 * 0.05)
    assert intervals["relit.psnr"].low == 0
    for name in ("relit.ssim", "relit.ssim_aligned"):
        assert intervals[name] == pytest.approx((0.9, 0.9 - 12.706205 * 0.05, 1.0))


def test_relative_errors_are_pooled_over_a_head_s_pictures_and_no_power_is_a_figure():
    powers = {"ann": ((1.0, 4.0), (3.0, 4.0)), "bob": ((1.0, 1.0), (0.0, 3.0)), "cy": ((0.0, 0.0),)}
    rows = [
        (head, {"shadow.rmse": error**0.5, "shadow.error_power": error, "shadow.true_power": true})
        for head, pictures in powers.items()
        for error, true in pictures
    ]
    intervals = intervals_over_heads(rows)
    assert set(intervals) == {"shadow.rmse", "shadow.relative"}
    assert intervals["shadow.relative"].mean == pytest.approx((0.5**0.5 + 0.25**0.5 + 0) / 3)


def test_a_similarity_may_be_below_nothing():
    assert intervals_over_heads([("a", {"relit.ssim": -0.2}), ("b", {"relit.ssim": 0.2})])["relit.ssim"].low == -1


def test_page_shows_the_paper_s_row(evaluation):
    page = as_markdown(evaluation, "tiny.safetensors")
    for figure in ("0.0281", "31.8", "0.914", "0.0271", "0.132", "0.00575", "0.00416", "0.0274"):
        assert f"| {figure} |" in page
    assert "2 heads, 3 panoramas, 6 relightings at 16 x 16" in page
    assert "In brackets: 95 % intervals over heads." in page


def test_missing_heads_say_how_to_bake_them(bundle, settings, tmp_path):
    with pytest.raises(InputError, match="--split test"):
        evaluate(bundle, replace(settings, heads=tmp_path))


def test_a_library_or_heads_without_the_split(bundle, settings, tmp_path):
    settings = replace(settings, split="validation")
    with pytest.raises(InputError, match="lights"):
        evaluate(bundle, settings)
    write_lights(tmp_path / "more.npz", 20)
    with pytest.raises(InputError, match="no heads of the validation split"):
        evaluate(bundle, replace(settings, lights=tmp_path / "more.npz"))
