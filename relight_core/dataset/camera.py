"""A simulated camera: exposure, white balance, lens blur, noise, clipping, tone curve, JPEG."""

from __future__ import annotations

import cv2
import numpy as np

from relight_core.dataset.painting.texture import TexturePool
from relight_core.dataset.surroundings import Neighbour, with_neighbour
from relight_core.lighting.panorama import mean_radiance

_METERED_SUBJECT, _METERED_WHITE = 0.28, 0.8
"""Linear values at which a meter exposes the subject, and a white surface."""


def photograph(
    radiance: np.ndarray,
    coverage: np.ndarray,
    light: np.ndarray,
    white_level: float,
    pool: TexturePool,
    rng: np.random.Generator,
    hidden: np.ndarray | None = None,
    neighbour: Neighbour | None = None,
) -> np.ndarray:
    """A photo of a lit head on a random background.

    Args:
        radiance: (S, S, 3) float32 linear, premultiplied: 0 outside the head.
        coverage: (S, S) in [0, 1], how much of each pixel is the head; or bool.
        light: (16, 32, 3) linear radiance of the light on the head, which decides the white balance.
        white_level: mean radiance that a white head would have in its place, which decides the exposure.
        hidden: (S, S) bool, where something stands between the camera and the head.
        neighbour: another person in front of the background, under a light of their own.

    Returns:
        (S, S, 3) float32 sRGB in [0, 1].
    """
    gain = camera_gain(radiance, coverage > 0.5, light, white_level, rng)
    background = with_neighbour(sample_background(len(radiance), pool, rng), neighbour, gain)
    image = radiance * gain + background * (1 - coverage.astype(np.float32)[..., None])
    if hidden is not None:
        image = np.where(hidden[..., None], sample_background(len(image), pool, rng) * 0.5, image)
    return through_camera(image, rng)


def camera_gain(
    radiance: np.ndarray, covered: np.ndarray, light: np.ndarray, white_level: float, rng: np.random.Generator
) -> np.ndarray:
    """White balance times exposure, (3,) float: what a camera multiplies linear radiance by.

    Args:
        covered: (S, S) bool, the head; the other arguments are those of `photograph`.
    """
    return _white_balance(light, rng) * _exposure_gain(radiance, covered, white_level, rng)


def through_camera(image: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Lens, sensor and development of an exposed picture: linear (S, S, 3) to float32 sRGB in [0, 1]."""
    return _develop(_sensor(_lens(image, rng), rng), rng)


def _white_balance(light: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Gains (3,) of mean 1 that neutralise a random fraction of the light's colour, as cameras do."""
    colour = mean_radiance(light) + 1e-4
    balance = (colour.mean() / colour) ** rng.uniform(0.0, 1.0) * np.exp(rng.normal(0, 0.04, 3))
    return (balance / balance.mean()).astype(np.float32)


def metered_gain(radiance: np.ndarray, covered: np.ndarray, white_level: float, subject_share: float) -> float:
    """The gain of a metered exposure, between metering the light and metering the subject.

    Metering the subject alone would expose dark and pale skin to the same brightness, so that no network could tell
    them apart; metering the light alone would reveal the albedo, which no camera does.

    Args:
        radiance: (S, S, 3) linear.
        covered: (S, S) bool, the head.
        white_level: mean radiance that a white head would have in its place.
        subject_share: 0 exposes white to 0.8. 1 exposes the subject to 0.28, taken as half the mean and half the 80th
            percentile of its pixels' mean over the channels. Between them the gains are mixed by their logarithms.
    """
    channel_mean = radiance[covered].mean(-1) if covered.any() else np.ones(1)
    subject = 0.5 * float(np.mean(channel_mean)) + 0.5 * float(np.percentile(channel_mean, 80))
    by_subject = _METERED_SUBJECT / max(subject, 1e-3)
    by_light = _METERED_WHITE / max(white_level, 1e-3)
    return by_subject**subject_share * by_light ** (1 - subject_share)


def _exposure_gain(radiance: np.ndarray, covered: np.ndarray, white_level: float, rng: np.random.Generator) -> float:
    """A random metering, over- or under-exposed by 0.4 stops of standard deviation; within [0.05, 20]."""
    gain = metered_gain(radiance, covered, white_level, rng.uniform(0.0, 0.6)) * 2 ** rng.normal(0, 0.4)
    return float(np.clip(gain, 0.05, 20))


def sample_background(size: int, pool: TexturePool, rng: np.random.Generator) -> np.ndarray:
    """A random background: black, one colour, or a picture, mostly blurred.

    Returns:
        (S, S, 3) float32 linear, already exposed.
    """
    chance = rng.random()
    if chance < 0.15:
        return np.zeros((size, size, 3), np.float32)
    if chance < 0.35:
        shade = 1 + 0.2 * cv2.resize(pool.noise(rng), (size, size))[..., None] * rng.uniform(0, 1)
        return (rng.beta(0.8, 0.8, 3) * shade).clip(0, 1.5).astype(np.float32)
    picture = cv2.resize(pool.picture(rng), (size, size))
    if rng.random() < 0.6:
        picture = cv2.GaussianBlur(picture, (0, 0), size * 10 ** rng.uniform(-2.5, -1))
    return picture * np.float32(2 ** rng.normal(0, 0.6))


def _lens(image: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    image = cv2.GaussianBlur(image, (0, 0), rng.uniform(0.35, 0.6) if rng.random() < 0.75 else rng.uniform(0.6, 1.6))
    if rng.random() < 0.3:
        size = len(image)
        axis = (np.arange(size) + 0.5) / size * 2 - 1
        falloff = 1 - rng.uniform(0, 0.35) * (axis[:, None] ** 2 + axis[None] ** 2) / 2
        image = image * falloff[..., None].astype(np.float32)
    return image


def _sensor(image: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    if rng.random() < 0.7:
        deviation = 10 ** rng.uniform(-3.2, -1.6) * np.sqrt(np.clip(image, 0, 1) + 0.02)
        image = image + rng.standard_normal(image.shape, np.float32) * deviation
    return np.clip(image, 0, 1)


def _develop(image: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Linear (S, S, 3) to float32 sRGB, at random with a contrast curve and saturation, and with JPEG's artefacts."""
    encoded = np.where(image <= 0.0031308, 12.92 * image, 1.055 * np.maximum(image, 1e-8) ** (1 / 2.4) - 0.055)
    if rng.random() < 0.6:
        contrast = rng.uniform(-0.15, 0.35)
        encoded = encoded + contrast * (encoded * encoded * (3 - 2 * encoded) - encoded)
        channel_mean = encoded.mean(-1, keepdims=True)
        encoded = np.clip(channel_mean + (encoded - channel_mean) * rng.uniform(0.75, 1.25), 0, 1)
    if rng.random() < 0.5:
        bytes_bgr = np.round(encoded[..., ::-1] * 255).astype(np.uint8)
        _, packed = cv2.imencode(".jpg", bytes_bgr, [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(45, 98))])
        encoded = cv2.imdecode(packed, cv2.IMREAD_COLOR)[..., ::-1].astype(np.float32) / 255
    return np.ascontiguousarray(encoded, np.float32)
