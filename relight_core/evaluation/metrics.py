"""Errors of images, normals and lights, as the paper's Tables 2 and 3 count them, and how sure they are.

Images are (H, W) or (H, W, C) arrays of any float type; masks are (H, W) bool and choose the pixels
that count, None counts all. Sums run in float64. Every function raises ValueError where shapes differ
or a mask chooses nothing; NaN in an image comes out as NaN.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.stats import t as student_t


def rmse(estimate: np.ndarray, reference: np.ndarray, mask: np.ndarray | None = None) -> float:
    """Root of the mean squared difference over the chosen pixels and all channels, in the images' unit."""
    chosen, true = _chosen(estimate, reference, mask)
    return float(np.sqrt(np.mean((chosen - true) ** 2)))


def psnr(estimate: np.ndarray, reference: np.ndarray, mask: np.ndarray | None = None) -> float:
    """Peak signal-to-noise ratio in dB for images in [0, 1]; infinity where nothing differs."""
    error = rmse(estimate, reference, mask)
    return math.inf if error == 0.0 else -20.0 * math.log10(error)


def ssim(estimate: np.ndarray, reference: np.ndarray, mask: np.ndarray | None = None) -> float:
    """Structural similarity of images in [0, 1] (Wang et al. 2004: Gaussian of sigma 1.5, 11 x 11).

    The similarity map is scikit-image's, averaged over channels and the chosen pixels. Pixels outside
    the mask take part only through the windows of those inside. Both sides need 11 pixels or more.
    """
    from skimage.metrics import structural_similarity

    _check(estimate, reference, mask)
    _, similarity = structural_similarity(
        np.asarray(estimate, np.float64),
        np.asarray(reference, np.float64),
        data_range=1.0,
        channel_axis=-1 if estimate.ndim == 3 else None,
        gaussian_weights=True,
        sigma=1.5,
        use_sample_covariance=False,
        full=True,
    )
    return float(np.mean(similarity if mask is None else similarity[mask]))


def normal_rmse(estimate: np.ndarray, reference: np.ndarray, mask: np.ndarray | None = None) -> float:
    """RMSE of the components of unit normals in [-1, 1], (H, W, 3); twice that of their images in [0, 1]."""
    _check_vectors(reference)
    return rmse(estimate, reference, mask)


def normal_angle_deg(estimate: np.ndarray, reference: np.ndarray, mask: np.ndarray | None = None) -> float:
    """Mean angle between normals (H, W, 3) in degrees, whatever their lengths; 90 where one has none."""
    _check_vectors(reference)
    chosen, true = _chosen(estimate, reference, mask)
    chosen, true = chosen.reshape(-1, 3), true.reshape(-1, 3)
    across = np.linalg.norm(np.cross(chosen, true), axis=-1)
    along = np.sum(chosen * true, axis=-1)
    angles = np.degrees(np.arctan2(across, along))
    without = ~(chosen.any(axis=-1) & true.any(axis=-1))
    return float(np.mean(np.where(without, 90.0, angles)))


def wlog_l2(estimate: np.ndarray, reference: np.ndarray) -> float:
    """Weighted-log-L2 distance of two lights (paper, Eq. 3, after Weber et al. 2018).

    Exactly || w * (log(1 + estimate) - log(1 + reference)) ||^2: natural logarithm, w the texel's solid
    angle in steradians (they sum to 4 pi), the square summed over texels and channels and divided by
    nothing. So it falls with the number of texels, and figures compare only at one size: 16 x 32 here
    and in the paper.

    Args:
        estimate, reference: (H, 2H, 3) linear radiance >= 0 of lights normalised alike.
    """
    _check(estimate, reference, None)
    height, width = reference.shape[:2]
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    solid_angle = (2 * np.pi / width) * (edges[:-1] - edges[1:])
    difference = np.log1p(np.asarray(estimate, np.float64)) - np.log1p(np.asarray(reference, np.float64))
    weights = solid_angle.reshape((-1,) + (1,) * (reference.ndim - 1))
    return float(np.sum((weights * difference) ** 2))


class Interval(NamedTuple):
    """A mean and the ends of its confidence interval; the ends are NaN where one head is all there is."""

    mean: float
    low: float
    high: float

    def within(self, least: float, most: float) -> Interval:
        """The interval without what the figure can't be, which leaves as many of them holding the truth."""
        return Interval(self.mean, *np.clip([self.low, self.high], least, most).tolist())


def interval_over_heads(values: np.ndarray, heads: np.ndarray, confidence: float = 0.95) -> Interval:
    """Student's interval of a mean over heads.

    Pictures of one head are alike, so it is heads that are counted: the spread of their sums about what the mean
    gives them, as many degrees of freedom as there are heads but one (the ratio estimator of cluster sampling,
    Cochran 1977, section 6.3). Resampling eight heads would give intervals a quarter too short.

    Args:
        values: (N,) one figure per picture, finite.
        heads: (N,) whose picture it is; any labels that numpy can sort.
        confidence: of the interval, in (0, 1).

    Raises:
        ValueError: no values, values that are not finite, or not one head to each.
    """
    values = np.asarray(values, np.float64)
    heads = np.asarray(heads)
    if values.ndim != 1 or values.shape != heads.shape or values.size == 0:
        raise ValueError(f"need one head per value, got {heads.shape} heads for {values.shape} values")
    if not np.isfinite(values).all() or not 0 < confidence < 1:
        raise ValueError("values must be finite and confidence within (0, 1)")
    mean = float(values.mean())
    _, index = np.unique(heads, return_inverse=True)
    off = np.bincount(index, values - mean)
    count = len(off)
    if count == 1:
        return Interval(mean, math.nan, math.nan)
    error = math.sqrt(count / (count - 1) * float(off @ off)) / values.size
    reach = float(student_t.ppf((1 + confidence) / 2, count - 1)) * error
    return Interval(mean, mean - reach, mean + reach)


def _check(estimate: np.ndarray, reference: np.ndarray, mask: np.ndarray | None) -> None:
    if estimate.shape != reference.shape or reference.ndim not in (2, 3) or reference.size == 0:
        raise ValueError(f"images of shapes {estimate.shape} and {reference.shape} do not compare")
    if mask is None:
        return
    if mask.dtype != bool or mask.shape != reference.shape[:2]:
        raise ValueError(f"a mask is bool and {reference.shape[:2]}, not {mask.dtype} and {mask.shape}")
    if not mask.any():
        raise ValueError("the mask chooses no pixel")


def _check_vectors(normals: np.ndarray) -> None:
    if normals.ndim != 3 or normals.shape[2] != 3:
        raise ValueError(f"normals are (H, W, 3), not {normals.shape}")


def _chosen(estimate: np.ndarray, reference: np.ndarray, mask: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Both images' chosen pixels in float64."""
    _check(estimate, reference, mask)
    if mask is not None:
        estimate, reference = estimate[mask], reference[mask]
    return np.asarray(estimate, np.float64), np.asarray(reference, np.float64)
