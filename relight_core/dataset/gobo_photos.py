"""The samples of the foreign-shadow network: a photo with a gobo's shadow, and how much light the shadow blocks."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import torch

from relight_core.dataset.camera import camera_gain, sample_background, through_camera
from relight_core.dataset.lighting.appearance import appear
from relight_core.dataset.lighting.gobos import sample_gobo
from relight_core.dataset.lighting.lights import sample_network_lights
from relight_core.dataset.lighting.sun import in_sun, sample_sun
from relight_core.dataset.painting.skin import paint
from relight_core.dataset.painting.texture import TexturePool
from relight_core.dataset.samples import light_head, mirrored
from relight_core.dataset.stream import Ingredients, SampleStream, sample_gloss, textured
from relight_core.dataset.warp import sample_warp, warped
from relight_core.face.parsing import INDEX, KINDS
from relight_core.imaging.tensor_logs import log_ratios

_LIGHTS_PER_HEAD, _SUNS_PER_HEAD, _PAINTS_PER_HEAD, _SAMPLES_PER_PAINT = 4, 2, 3, 64
_SHADOWED_SHARE, _WILD_SHARE, _BEHIND_SHARE = 0.65, 0.1, 0.5
_DEEPEST, _FAINTEST = 0.05, 0.6
"""Smallest and largest share of the light that is left in a shadow."""
_BLUER = np.array([-1.0, 0.0, 1.0], np.float32)
"""Direction of the tint in logarithms of RGB: shadows outdoors are lit by the sky."""
_LIT_QUANTILE = 0.95
_PARSING_BLUR = (-2.8, -1.9)
"""Standard deviation of the labels' blur over the view's side, as powers of ten."""
_TINT, _BLUENESS = 0.1, 0.15


@dataclass(frozen=True)
class PaintedHead:
    """One head in several paints and lights.

    Attributes:
        radiance: (paints, lights, S, S, 3) float16 linear, scaled so that a white head has mean 1 under each light.
        lights: (lights, 16, 32, 3) linear radiance, suns first.
        channels: those channels of `dataset.samples` that do not depend on the light and are needed here.
    """

    radiance: np.ndarray
    lights: np.ndarray
    channels: dict[str, np.ndarray]


class GoboStream(SampleStream):
    """Single photos of heads under two lights, two in three with a gobo between one of the lights and the head.

    Each item is a dict of tensors:

    - "photo_srgb" (3, S, S);
    - "kinds" (4, S, S): the true `face.parsing.KINDS`, blurred like a predicted parsing;
    - "foreign_shadow" (3, S, S): natural logarithm of the exposed picture over the same without the shadow, both
      clipped as the camera clips them; 0 for fully lit pixels and outside the head;
    - "person" (1, S, S): 1 on the head.

    A head's own shadows, as sharp as a sun makes them, are not foreign: de-lighting handles those.
    """

    def __init__(self, folder: Path, lights: Path, split: str, size: int, seed: int, **where: int):
        often = {"lights_per_head": _LIGHTS_PER_HEAD, "paints_per_head": _PAINTS_PER_HEAD * _SAMPLES_PER_PAINT}
        super().__init__(folder, lights, split, size, seed, **often, **where)

    def _light(self, path: Path, ingredients: Ingredients, rng: np.random.Generator) -> PaintedHead:
        pool, library = ingredients.pool, ingredients.library
        head = self._read(path, rng)
        normal = textured(head, pool, rng)
        suns = np.stack([sample_sun(rng) for _ in range(_SUNS_PER_HEAD)])
        lights = np.concatenate([suns, sample_network_lights(library, rng, self.lights_per_head)])
        lit = light_head(head, normal, lights)
        gloss = sample_gloss(rng)
        appearance = appear(head, normal, lights, lit.illumination, gloss, None, rng.uniform(0, 2.0) * self.size / 128)
        for k in range(_SUNS_PER_HEAD):
            appearance = in_sun(appearance, head, lights[k], lit.illumination, k, rng)
        white = appearance.irradiance.mean((1, 2))
        radiance = np.empty((_PAINTS_PER_HEAD, len(lights), self.size, self.size, 3), np.float16)
        for number in range(_PAINTS_PER_HEAD):
            albedo = paint(head, pool, rng, wild=bool(rng.random() < _WILD_SHARE))
            for k in range(len(lights)):
                seen = appearance.radiance(head, albedo, lit.own, k) / max(float(white[k]), 1e-6)
                radiance[number, k] = head.scatter(np.minimum(seen, 1e4))
        shape = {
            name: head.scatter(image)
            for name, image in (("normal", head.normal), ("relief", head.depth), ("label", head.label))
        }
        return PaintedHead(radiance, lights, shape | {"covered": head.covered.astype(np.float32)})

    def _sample(
        self, heads: dict[int, PaintedHead], turn: int, pool: TexturePool, rng: np.random.Generator
    ) -> dict[str, torch.Tensor]:
        head = heads[turn]
        paint_number = rng.integers(len(head.radiance))
        sky, lamp = rng.integers(_SUNS_PER_HEAD, len(head.lights)), rng.integers(len(head.lights) - 1)
        lamp += lamp >= sky
        key, fill = (head.radiance[paint_number, k].astype(np.float32) for k in (lamp, sky))
        left = np.exp(rng.uniform(np.log(_DEEPEST), np.log(_FAINTEST)))
        # Part of the lamp's light is reflected by the surroundings into the shadow.
        stray = rng.uniform(0, 0.7)
        tint = np.exp(rng.normal(0, _TINT, 3) + rng.uniform(0, _BLUENESS) * _BLUER).astype(np.float32)
        always = left * tint * ((1 - stray) * fill + stray * key)
        channels = head.channels | {"always": always, "lamp": (1 - left) * key, "light": head.lights[lamp]}
        channels["silhouette"] = channels["covered"]
        channels = mirrored(channels) if rng.random() < 0.5 else channels
        return _photographed(warped(channels, sample_warp(rng)), pool, rng)


def _photographed(
    channels: dict[str, np.ndarray], pool: TexturePool, rng: np.random.Generator
) -> dict[str, torch.Tensor]:
    """A photo of a head with or without a foreign shadow, as an item of `GoboStream`."""
    always, lamp, coverage = (channels[name] for name in ("always", "lamp", "silhouette"))
    size = len(coverage)
    shadowed = rng.random() < _SHADOWED_SHARE
    passes = sample_gobo(channels["relief"], pool, rng)[..., None] if shadowed else np.ones((size, size, 1), np.float32)
    open_, shaded = always + lamp, always + lamp * passes
    gain = camera_gain(shaded, coverage > 0.5, channels["light"], 1.0, rng)
    behind = sample_background(size, pool, rng)
    if shadowed and rng.random() < _BEHIND_SHARE:
        behind = behind * (passes + (1 - passes) * np.float32(rng.uniform(_DEEPEST, _FAINTEST)))
    outside = behind * (1 - coverage[..., None])
    photo = through_camera((shaded * gain + outside).astype(np.float32), rng)
    recorded = [torch.from_numpy(np.clip(image * gain + outside, 0, 1)).float() for image in (shaded, open_)]
    covered = torch.from_numpy(channels["covered"])[..., None]
    foreign = log_ratios(*recorded)
    if covered.any():
        # Relative to the lit part of the head: a head that is all in shadow can't be told from a darker exposure.
        foreign = (foreign - foreign[covered[..., 0] > 0].quantile(_LIT_QUANTILE, 0)).clamp_max(0)
    return {
        "photo_srgb": torch.from_numpy(photo).permute(2, 0, 1).contiguous(),
        "foreign_shadow": (foreign * covered).permute(2, 0, 1).contiguous(),
        "kinds": torch.from_numpy(_kinds(channels["label"], rng)),
        "person": covered.permute(2, 0, 1).contiguous(),
    }


def _kinds(label: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Masks (4, S, S) float32 in [0, 1] of KINDS in labels (S, S), blurred like a predicted parsing."""
    softness_px = len(label) * 10 ** rng.uniform(*_PARSING_BLUR)
    kinds = [np.isin(label, [INDEX[name] for name in names]).astype(np.float32) for names in KINDS]
    return np.stack([cv2.GaussianBlur(kind, (0, 0), softness_px) for kind in kinds])
