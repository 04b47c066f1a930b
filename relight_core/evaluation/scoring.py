"""What one relighting got wrong, as figures by name."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.optimize import minimize_scalar

from relight_core.evaluation.metrics import normal_angle_deg, normal_rmse, psnr, rmse, ssim, wlog_l2
from relight_core.imaging.colour import srgb_encode
from relight_core.lighting.panorama import mean_luminance

Figures = dict[str, float]

BEST_PSNR_DB = 100.0
"""Stands for infinity, so that a mean over pictures exists."""

_EXPOSURES_EV = (-4.0, 4.0)
_PIXELS = 4096


def score_surface(
    channels: Mapping[str, np.ndarray], light: np.ndarray, truth: Mapping[str, np.ndarray], mask: np.ndarray
) -> Figures:
    """Errors of de-lighting.

    Args:
        channels: what was found: images "albedo" (linear) and "normal", the network's light "guess" and
            the light "source_light" that was fitted to explain the photo.
        light: (16, 32, 3) the photo's true light; the levels of lights do not count.
        truth: images "albedo" and "normal".
        mask: (S, S) bool, the pixels that count.
    """
    albedo, true_albedo = channels["albedo"], truth["albedo"]
    return {
        "albedo.rmse": _srgb_rmse(albedo, true_albedo, mask),
        "albedo.rmse_aligned": _srgb_rmse(albedo * best_gain(albedo, true_albedo, mask), true_albedo, mask),
        "normal.rmse": normal_rmse(channels["normal"], truth["normal"], mask),
        "normal.angle_deg": normal_angle_deg(channels["normal"], truth["normal"], mask),
        "light.wlog_l2": wlog_l2(levelled(channels["guess"]), levelled(light)),
        "light.wlog_l2_fitted": wlog_l2(levelled(channels["source_light"]), levelled(light)),
    }


def score_effects(effects: Mapping[str, np.ndarray], truth: Mapping[str, np.ndarray], mask: np.ndarray) -> Figures:
    """RMSE of the additive channels, linear, in units of the normalised light; and the mean squares of
    error and truth, from which an error relative to the channel's own size is pooled over pictures."""
    figures = {}
    for name in ("specular", "shadow"):
        error = rmse(effects[name], truth[name], mask)
        figures[f"{name}.rmse"] = error
        figures[f"{name}.error_power"] = error**2
        figures[f"{name}.true_power"] = float(np.mean(truth[name][mask].astype(np.float64) ** 2))
    return figures


def score_relit(relit: np.ndarray, truth: np.ndarray, gain: float, covered: np.ndarray, mask: np.ndarray) -> Figures:
    """Errors of a relit picture in sRGB.

    Args:
        relit, truth: (S, S, 3) linear, in units of the normalised light.
        gain: the exposure at which both are shown, a meter's for the true one.
        covered: (S, S) bool, the head.
        mask: (S, S) bool, the pixels that count.

    Returns:
        "rmse", "psnr" and "ssim"; the same "_aligned", after the one exposure per picture that fits best (a
        photo's own exposure is unknown, and with it the scale of albedo against light); "rmse_as_lit"
        without metering, which leaves pictures dark where the light is.
    """
    shown, expected = (_display(image * gain, covered) for image in (relit, truth))
    aligned = _display(relit * gain * best_gain(relit * gain, truth * gain, mask), covered)
    return {
        "relit.rmse": rmse(shown, expected, mask),
        "relit.psnr": min(psnr(shown, expected, mask), BEST_PSNR_DB),
        "relit.ssim": ssim(shown, expected, mask),
        "relit.rmse_aligned": rmse(aligned, expected, mask),
        "relit.psnr_aligned": min(psnr(aligned, expected, mask), BEST_PSNR_DB),
        "relit.ssim_aligned": ssim(aligned, expected, mask),
        "relit.rmse_as_lit": rmse(_display(relit, covered), _display(truth, covered), mask),
    }


def score_unchanged(
    photo: np.ndarray, truth: np.ndarray, gain: float, covered: np.ndarray, mask: np.ndarray
) -> Figures:
    """The error of leaving the photo as it is, to measure the others by."""
    expected = _display(truth * gain, covered)
    return {"relit.rmse_of_unchanged_photo": rmse(_display(photo, covered), expected, mask)}


def levelled(light: np.ndarray) -> np.ndarray:
    """A light (H, 2H, 3) at a mean luminance of 1, as lights of the library are."""
    return light / max(mean_luminance(light), 1e-6)


def _display(linear: np.ndarray, covered: np.ndarray) -> np.ndarray:
    """sRGB in [0, 1], black outside the head."""
    return srgb_encode(np.clip(linear, 0, 1).astype(np.float32)) * covered[..., None]


def _srgb_rmse(estimate: np.ndarray, truth: np.ndarray, mask: np.ndarray) -> float:
    both = (srgb_encode(np.clip(image, 0, 1).astype(np.float32)) for image in (estimate, truth))
    return rmse(*both, mask)


def best_gain(estimate: np.ndarray, truth: np.ndarray, mask: np.ndarray) -> float:
    """The one exposure at which an estimate looks most like the truth: least squares of what is displayed.

    Searched over four stops either way on some thousand pixels; 1, where the search finds nothing better.
    """
    chosen, true = (_some_rows(image[mask]) for image in (estimate, truth))
    expected = srgb_encode(np.clip(true, 0, 1))

    def error(exposure_ev: float) -> float:
        return float(np.mean((srgb_encode(np.clip(chosen * np.float32(2**exposure_ev), 0, 1)) - expected) ** 2))

    best_ev = float(minimize_scalar(error, bounds=_EXPOSURES_EV, method="bounded", options={"xatol": 1e-3}).x)
    return 2**best_ev if error(best_ev) < error(0.0) else 1.0


def _some_rows(pixels: np.ndarray) -> np.ndarray:
    return pixels[:: max(len(pixels) // _PIXELS, 1)].astype(np.float32)
