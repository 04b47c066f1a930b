"""What one relighting got wrong, as figures by name."""

from __future__ import annotations

import math

import numpy as np
import torch

from relight_core.evaluation.metrics import normal_angle_deg, normal_rmse, psnr, rmse, ssim, wlog_l2
from relight_core.imaging.colour import srgb_encode
from relight_core.lighting.environment import mean_luminance
from relight_core.pipeline.hints import Effects
from relight_core.pipeline.stages import Surface

Figures = dict[str, float]

BEST_PSNR_DB = 100.0
"""Stands for infinity, so that a mean over pictures exists."""


def score_surface(
    found: Surface, truth: dict[str, np.ndarray], light: np.ndarray, mask: np.ndarray
) -> Figures:
    """Errors of de-lighting.

    Args:
        found: what was estimated.
        truth: images "albedo" (linear) and "normal".
        light: (16, 32, 3) the photo's true light, mean luminance 1.
        mask: (S, S) bool, the pixels that count.
    """
    albedo, normal = as_image(found.albedo), as_image(found.normal)
    estimated_light = found.source_light[0].cpu().numpy()
    level = max(mean_luminance(estimated_light), 1e-6)
    return {
        "albedo.rmse": _srgb_rmse(albedo, truth["albedo"], mask),
        "albedo.rmse_aligned": _srgb_rmse(
            albedo * _best_gain(albedo, truth["albedo"], mask), truth["albedo"], mask
        ),
        "normal.rmse": normal_rmse(normal, truth["normal"], mask),
        "normal.angle_deg": normal_angle_deg(normal, truth["normal"], mask),
        "light.wlog_l2": wlog_l2(estimated_light / level, light),
    }


def score_effects(effects: Effects, truth: dict[str, np.ndarray], mask: np.ndarray) -> Figures:
    """RMSE of the additive channels, linear, in units of the normalised light; and the mean squares of
    error and truth, from which an error relative to the channel's own size is pooled over pictures."""
    figures = {}
    for name in ("specular", "shadow"):
        error = rmse(as_image(getattr(effects, name)), truth[name], mask)
        figures[f"{name}.rmse"] = error
        figures[f"{name}.error_power"] = error**2
        figures[f"{name}.true_power"] = float(np.mean(truth[name][mask].astype(np.float64) ** 2))
    return figures


def score_relit(
    relit: np.ndarray, truth: np.ndarray, gain: float, covered: np.ndarray, mask: np.ndarray
) -> Figures:
    """Errors of a relit picture in sRGB.

    Args:
        relit, truth: (S, S, 3) linear, in units of the normalised light.
        gain: the exposure at which both are shown, a meter's for the true one.
        covered: (S, S) bool, the head.
        mask: (S, S) bool, the pixels that count.

    Returns:
        "rmse", "psnr" and "ssim"; "rmse_aligned" after the one gain per picture that fits best (the scale
        of albedo against light that no photo tells); "rmse_as_lit" without metering, which leaves
        pictures dark where the light is.
    """
    shown, expected = (_display(image * gain, covered) for image in (relit, truth))
    best = _best_gain(relit, truth, mask)
    return {
        "relit.rmse": rmse(shown, expected, mask),
        "relit.psnr": min(psnr(shown, expected, mask), BEST_PSNR_DB),
        "relit.ssim": ssim(shown, expected, mask),
        "relit.rmse_aligned": rmse(_display(relit * gain * best, covered), expected, mask),
        "relit.rmse_as_lit": rmse(_display(relit, covered), _display(truth, covered), mask),
    }


def score_unchanged(
    photo: np.ndarray, truth: np.ndarray, gain: float, covered: np.ndarray, mask: np.ndarray
) -> Figures:
    """The error of leaving the photo as it is, to measure the others by."""
    expected = _display(truth * gain, covered)
    return {"relit.rmse_of_unchanged_photo": rmse(_display(photo, covered), expected, mask)}


def true_surface(truth: dict[str, np.ndarray], photo: np.ndarray, light: np.ndarray) -> Surface:
    """The surface that a perfect de-lighting network would find."""
    covered = _as_tensor(truth["covered"])
    parsing = torch.zeros(1, 14, *covered.shape[-2:])
    parsing[:, 0], parsing[:, 1] = 1 - covered[:, 0], covered[:, 0]
    return Surface(
        photo=_as_tensor(photo),
        albedo=_as_tensor(truth["albedo"]),
        normal=_as_tensor(truth["normal"]),
        relief=_as_tensor(truth["relief"]),
        parsing=parsing,
        person=covered,
        source_light=torch.from_numpy(light)[None],
    )


def as_image(tensor: torch.Tensor) -> np.ndarray:
    """(1, C, S, S) to (S, S, C), or (S, S) for one channel."""
    array = tensor[0].permute(1, 2, 0).float().cpu().numpy()
    return array[..., 0] if array.shape[-1] == 1 else array


def _as_tensor(image: np.ndarray) -> torch.Tensor:
    image = image[..., None] if image.ndim == 2 else image
    return torch.from_numpy(np.ascontiguousarray(image, np.float32)).permute(2, 0, 1)[None]


def _display(linear: np.ndarray, covered: np.ndarray) -> np.ndarray:
    """sRGB in [0, 1], black outside the head."""
    return srgb_encode(np.clip(linear, 0, 1).astype(np.float32)) * covered[..., None]


def _srgb_rmse(estimate: np.ndarray, truth: np.ndarray, mask: np.ndarray) -> float:
    both = (srgb_encode(np.clip(image, 0, 1).astype(np.float32)) for image in (estimate, truth))
    return rmse(*both, mask)


def _best_gain(estimate: np.ndarray, truth: np.ndarray, mask: np.ndarray) -> float:
    """The one factor that brings an estimate nearest to the truth, least squares in linear light."""
    chosen, true = estimate[mask].astype(np.float64), truth[mask].astype(np.float64)
    power = float((chosen**2).sum())
    gain = float((chosen * true).sum()) / power if power > 0 else 1.0
    return gain if math.isfinite(gain) and gain > 0 else 1.0
