"""Figures of one relighting: perfect, scaled, broken."""

import numpy as np
import pytest

from relight_core.evaluation.scoring import (
    score_effects,
    score_relit,
    score_surface,
    score_unchanged,
)

SIZE = 24


@pytest.fixture
def covered():
    covered = np.zeros((SIZE, SIZE), bool)
    covered[3:21, 3:21] = True
    return covered


@pytest.fixture
def truth(covered):
    rng = np.random.default_rng(0)
    normal = rng.standard_normal((SIZE, SIZE, 3)) + [0, 0, 2]
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    images = {
        "albedo": rng.uniform(0.1, 0.7, (SIZE, SIZE, 3)),
        "normal": normal,
        "relief": rng.random((SIZE, SIZE)),
        "image": rng.uniform(0.05, 0.6, (SIZE, SIZE, 3)),
        "specular": rng.random((SIZE, SIZE)) * 0.1,
        "shadow": rng.random((SIZE, SIZE)) * 0.2,
    }
    images = {
        name: np.float32(image * (covered[..., None] if image.ndim == 3 else covered)) for name, image in images.items()
    }
    return images | {"covered": covered.astype(np.float32)}


def light():
    return np.ones((16, 32, 3), np.float32)


def found(truth, **changed):
    """Channels of a perfect de-lighting, but for what is given."""
    return {
        "albedo": truth["albedo"],
        "normal": truth["normal"],
        "guess": light(),
        "source_light": light(),
    } | changed


def test_the_true_surface_has_no_error(truth, covered):
    figures = score_surface(found(truth), light(), truth, covered)
    assert all(value == pytest.approx(0, abs=1e-4) for value in figures.values())
    assert set(figures) == {
        "albedo.rmse",
        "albedo.rmse_aligned",
        "normal.rmse",
        "normal.angle_deg",
        "light.wlog_l2",
        "light.wlog_l2_fitted",
    }


def test_of_a_surface_nothing_beside_the_pixels_that_count_does(truth, covered):
    part = covered & (np.arange(SIZE) < 12)
    spoiled = {name: np.where(part[..., None], truth[name], np.float32(0.9)) for name in ("albedo", "normal")}
    figures = score_surface(found(truth, **spoiled), light(), truth, part)
    assert all(value == pytest.approx(0, abs=1e-4) for value in figures.values())


@pytest.mark.parametrize("factor", [0.7, 1 / 14, 14.0])
def test_a_scaled_albedo_is_wrong_but_aligned(factor, truth, covered):
    figures = score_surface(found(truth, albedo=truth["albedo"] * factor), light(), truth, covered)
    assert figures["albedo.rmse"] > 0.05
    assert figures["albedo.rmse_aligned"] < 1e-4


def test_an_albedo_is_compared_as_it_is_shown(truth, covered):
    half, quarter = (np.full((SIZE, SIZE, 3), value, np.float32) for value in (0.5, 0.25))
    figures = score_surface(found(truth, albedo=half), light(), truth | {"albedo": quarter}, covered)
    # sRGB 0.735 and 0.537.
    assert figures["albedo.rmse"] == pytest.approx(0.1983, abs=1e-3)


def test_the_light_s_level_does_not_count(truth, covered):
    figures = score_surface(found(truth, guess=light() * 5, source_light=light() * 7), light() * 3, truth, covered)
    assert figures["light.wlog_l2"] == pytest.approx(0, abs=1e-6)
    assert figures["light.wlog_l2_fitted"] == pytest.approx(0, abs=1e-6)


def test_both_lights_are_measured(truth, covered):
    side = light()
    side[:, 16:] = 3
    figures = score_surface(found(truth, guess=side), light(), truth, covered)
    assert figures["light.wlog_l2"] > 1e-3
    assert figures["light.wlog_l2_fitted"] == pytest.approx(0, abs=1e-6)


def test_turned_normals_show_in_the_angle(truth, covered):
    facing = np.broadcast_to(np.float32([0, 0, 1]), (SIZE, SIZE, 3))
    tilted = np.broadcast_to(np.float32([np.sin(0.5), 0, np.cos(0.5)]), (SIZE, SIZE, 3))
    figures = score_surface(found(truth, normal=tilted), light(), truth | {"normal": facing}, covered)
    assert figures["normal.angle_deg"] == pytest.approx(np.degrees(0.5), rel=1e-4)


def test_effects_and_their_powers(truth, covered):
    half = {"specular": truth["specular"], "shadow": truth["shadow"] * 0.5}
    figures = score_effects(half, truth, covered)
    assert figures["specular.rmse"] == pytest.approx(0, abs=1e-6)
    root_mean_square = float(np.sqrt(np.mean(truth["shadow"][covered] ** 2)))
    assert figures["shadow.rmse"] == pytest.approx(root_mean_square / 2, rel=1e-4)
    assert figures["shadow.error_power"] / figures["shadow.true_power"] == pytest.approx(0.25, rel=1e-4)


def test_a_perfect_picture(truth, covered):
    figures = score_relit(truth["image"], truth["image"], 2.0, covered, covered)
    assert figures["relit.rmse"] == figures["relit.rmse_as_lit"] == 0
    assert figures["relit.psnr"] == 100
    assert figures["relit.ssim"] == pytest.approx(1)


def test_what_lies_outside_the_head_does_not_count(truth, covered):
    spoiled = truth["image"].copy()
    spoiled[~covered] = 7
    assert score_relit(spoiled, truth["image"], 2.0, covered, covered)["relit.rmse"] == 0
    assert score_relit(spoiled, truth["image"], 2.0, covered, covered)["relit.ssim"] == pytest.approx(1)


def test_of_a_part_of_the_head_nothing_beside_it_counts(truth, covered):
    part = covered & (np.arange(SIZE) < 12)
    spoiled = truth["image"].copy()
    spoiled[~part] = 0.3
    figures = score_relit(spoiled, truth["image"], 2.0, covered, part)
    figures |= score_unchanged(spoiled * 2, truth["image"], 2.0, covered, part)
    for name in ("relit.rmse", "relit.rmse_aligned", "relit.rmse_as_lit", "relit.rmse_of_unchanged_photo"):
        assert figures[name] == pytest.approx(0, abs=1e-6), name
    assert figures["relit.psnr"] == 100
    # A pixel's window reaches five pixels far.
    small = covered & (np.arange(SIZE) < 7)
    figures = score_relit(spoiled, truth["image"], 2.0, covered, small)
    assert figures["relit.ssim"] == pytest.approx(1)
    assert figures["relit.ssim_aligned"] == pytest.approx(1, abs=1e-4)


def test_a_darker_picture_is_worse_but_aligned(truth, covered):
    figures = score_relit(truth["image"] * 0.8, truth["image"], 2.0, covered, covered)
    assert figures["relit.rmse"] > 0.03
    assert figures["relit.rmse_aligned"] < 1e-3
    assert figures["relit.psnr_aligned"] > figures["relit.psnr"] + 20
    assert figures["relit.ssim_aligned"] > figures["relit.ssim"]


def test_one_exposure_mends_no_tint(truth, covered):
    figures = score_relit(truth["image"] * np.float32([1.3, 1, 0.7]), truth["image"], 2.0, covered, covered)
    assert figures["relit.rmse_aligned"] > 0.03


def test_the_best_exposure_is_of_what_is_seen(truth, covered):
    """A glint that both show as white weighs nothing, however wrong its radiance is."""
    estimate, true = truth["image"] * 0.5, truth["image"].copy()
    estimate[10, 10], true[10, 10] = 900, 50
    figures = score_relit(estimate, true, 1.0, covered, covered)
    assert figures["relit.rmse_aligned"] < 1e-2


def test_the_best_exposure_is_of_what_is_seen_of_a_metered_picture(truth, covered):
    """A third of the head is white in both at the meter's exposure, and in neither without it."""
    estimate, true = truth["image"] * 0.25, truth["image"] * 0.5
    estimate[8:14], true[8:14] = 0.3, 0.4
    figures = score_relit(estimate, true, 4.0, covered, covered)
    assert figures["relit.rmse_aligned"] < 1e-2


def test_alignment_never_makes_a_picture_worse(truth, covered):
    estimate = truth["image"][::-1].copy()
    figures = score_relit(estimate, truth["image"], 1.5, covered, covered)
    assert figures["relit.rmse_aligned"] <= figures["relit.rmse"] + 1e-6


def test_the_exposure_brings_out_errors_in_dim_pictures(truth, covered):
    estimate, true = truth["image"] * 0.009, truth["image"] * 0.01
    figures = score_relit(estimate, true, 100.0, covered, covered)
    bright = score_relit(estimate * 100, true * 100, 1.0, covered, covered)
    assert figures["relit.rmse"] == pytest.approx(bright["relit.rmse"], rel=1e-3)
    assert figures["relit.rmse_as_lit"] < 0.5 * figures["relit.rmse"]


def test_the_unchanged_photo(truth, covered):
    photo = truth["image"] * 2.0
    assert score_unchanged(photo, truth["image"], 2.0, covered, covered)["relit.rmse_of_unchanged_photo"] == 0
    assert score_unchanged(photo * 0.2, truth["image"], 2.0, covered, covered)["relit.rmse_of_unchanged_photo"] > 0.1


def test_black_estimates_give_figures(truth, covered):
    figures = score_relit(truth["image"] * 0, truth["image"], 2.0, covered, covered)
    figures |= score_surface(found(truth, guess=light() * 0), light(), truth, covered)
    assert all(np.isfinite(value) for value in figures.values())
