"""The parts of training samples: a lit head, its channels under one light, mirroring."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
import torch

from relight_core.dataset.baking.bake import BakedHead
from relight_core.dataset.lighting.appearance import Appearance
from relight_core.dataset.lighting.illumination import Illumination, illuminate
from relight_core.dataset.lighting.interreflection import OwnView, bounced, own_view
from relight_core.face.gloss import gloss_of
from relight_core.face.parsing import MIRRORED
from relight_core.imaging.colour import REC709_LUMINANCE
from relight_core.lighting.relief import march_relief

RELIEF_SIZE = 64
"""Side in pixels at which reliefs are marched; it keeps shadows wider than a few pixels, and SS sharpens them."""

ON_THE_HEAD = ("albedo", "relief", "image", "specular", "shadow", "shadow_fraction", "gloss_fraction")
"""Channels that are 0 outside the head; averages over a pixel at its outline count only the head's part."""

_GREY = REC709_LUMINANCE.astype(np.float32)
_MIRRORED_LABELS = np.array(MIRRORED, np.uint8)


@dataclass(frozen=True)
class LitHead:
    """A head under K lights, before it is painted and photographed; several samples share it.

    Attributes:
        normal: (P, 3) of the covered pixels, with pores and threads.
        lights: (K, 16, 32, 3) linear radiance.
        own: what its pixels see of the head itself instead of the light.
        fine_lights: (K, 64, 128, 3) the lights before they were downsampled, for samples that are rotated.
        appearance: what photos show of it; None where no photos are taken.
        relief_shadow: (K, S, S) shadow fractions, the hint to SS; None where it is not needed.
    """

    head: BakedHead
    normal: np.ndarray
    lights: np.ndarray
    illumination: Illumination
    own: OwnView
    appearance: Appearance | None = None
    relief_shadow: np.ndarray | None = None
    fine_lights: np.ndarray | None = None


def subsample(head: BakedHead, step: int, rng: np.random.Generator) -> BakedHead:
    """Every `step`-th pixel in both directions, from a random first one: a smaller image of the same head."""
    if step == 1:
        return head
    y, x = rng.integers(0, step, 2)
    index = np.full(head.covered.shape, -1, np.int64)
    index[head.covered] = np.arange(len(head.normal))
    kept = index[y::step, x::step]
    chosen = kept[kept >= 0]
    return BakedHead(
        covered=kept >= 0,
        normal=head.normal[chosen],
        depth=head.depth[chosen],
        uv=head.uv[chosen],
        material=head.material[chosen],
        label=head.label[chosen],
        visibility=np.packbits(head.visible()[:, chosen], axis=1),
        albedo=None if head.albedo is None else head.albedo[chosen],
    )


def light_head(head: BakedHead, normal: np.ndarray, lights: np.ndarray, *, dull: bool = True) -> LitHead:
    """Light a head with the reference gloss.

    Args:
        dull: hair and cloth have less gloss (see `face.gloss`); otherwise all of the head has the gloss of skin.
    """
    light = illuminate(head, normal, lights)
    if dull:
        share = gloss_of(head.label)
        light = replace(light, specular=light.specular * share, specular_open=light.specular_open * share)
    return LitHead(head, normal, lights, light, own_view(head, normal))


def channels_of(lit: LitHead, albedo: np.ndarray, k: int) -> dict[str, np.ndarray]:
    """The paper's channels (section 3.2) under light `k`: linear images (S, S, ...), 0 outside the head, and the light.

    "specular" and "shadow" are Rec.709 luminance, and "shadow_fraction" and "gloss_fraction" the occluded share of the
    irradiance and of the gloss, in [0, 1].
    """
    light = lit.illumination
    irradiance = light.irradiance[k] + bounced(lit.head, lit.own, albedo, light.irradiance[k])
    image = albedo * irradiance + light.specular[k]
    unshadowed = albedo * light.irradiance_open[k] + light.specular_open[k]
    shadow_fraction = 1 - (irradiance @ _GREY) / np.maximum(light.irradiance_open[k] @ _GREY, 1e-6)
    gloss_fraction = 1 - (light.specular[k] @ _GREY) / np.maximum(light.specular_open[k] @ _GREY, 1e-6)
    scatter = lit.head.scatter
    return {
        "image": scatter(image),
        "specular": scatter(light.specular[k] @ _GREY),
        "shadow": scatter(np.maximum((unshadowed - image) @ _GREY, 0)),
        "shadow_fraction": scatter(np.clip(shadow_fraction, 0, 1)),
        "gloss_fraction": scatter(np.clip(gloss_fraction, 0, 1)),
        "light": lit.lights[k],
    }


def surface_of(lit: LitHead, albedo: np.ndarray) -> dict[str, np.ndarray]:
    """The channels that do not depend on the light: images (S, S, ...) of linear albedo, normals, relief and labels."""
    scatter = lit.head.scatter
    return {
        "albedo": scatter(albedo),
        "normal": scatter(lit.normal),
        "relief": scatter(lit.head.depth),
        "label": scatter(lit.head.label),
        "covered": lit.head.covered.astype(np.float32),
    }


def without_hidden(channels: dict[str, np.ndarray], hidden: np.ndarray | None) -> dict[str, np.ndarray]:
    """Coverage and labels where an object in front hides the head: background, from which nothing is learnt."""
    if hidden is None:
        return {}
    return {name: np.where(hidden, 0, channels[name]).astype(channels[name].dtype) for name in ("covered", "label")}


def mirrored(sample: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The same sample in a mirror: images and light flipped, normals and sides exchanged."""
    flipped = {name: np.ascontiguousarray(value[:, ::-1]) for name, value in sample.items()}
    flipped["normal"] = flipped["normal"] * np.array([-1, 1, 1], np.float32)
    flipped["label"] = _MIRRORED_LABELS[flipped["label"]]
    return flipped


def relief_shadows(lit: LitHead, rng: np.random.Generator) -> np.ndarray:
    """Shadow fractions (K, S, S) of a relief that is degraded to the quality of a predicted one.

    The true relief is flattened, smoothed and bent as much as predicted ones are (they have 0.4 to 0.8 of the true
    height, and no edges), so that the SS network learns to correct the hint instead of copying it.
    """
    size = lit.head.size
    covered = lit.head.covered.astype(np.float32)
    weight = cv2.GaussianBlur(covered, (0, 0), deviation := size / 128 * rng.uniform(0.5, 4.0))
    smooth = cv2.GaussianBlur(lit.head.scatter(lit.head.depth), (0, 0), deviation) / np.maximum(weight, 1e-3)
    bend = cv2.resize(rng.standard_normal((5, 5)).astype(np.float32), (size, size), interpolation=cv2.INTER_CUBIC)
    rough = smooth * rng.uniform(0.4, 1.15) + 0.03 * bend

    def shrunk(image: np.ndarray) -> torch.Tensor:
        return torch.from_numpy(cv2.resize(image, (RELIEF_SIZE, RELIEF_SIZE), interpolation=cv2.INTER_AREA))

    normal = shrunk(cv2.GaussianBlur(lit.head.scatter(lit.normal), (0, 0), deviation / 2)).permute(2, 0, 1)
    normal = torch.nn.functional.normalize(normal, dim=0, eps=1e-3)
    transport = march_relief(shrunk(rough), normal, shrunk(covered))
    fraction = transport.shadow_fraction(torch.from_numpy(lit.lights))[:, 0].numpy()
    return np.stack([cv2.resize(f, (size, size), interpolation=cv2.INTER_LINEAR) for f in fraction])


def as_tensors(pair: list[dict[str, np.ndarray]], shared: set[str]) -> dict[str, torch.Tensor]:
    """Two samples of one head as one item of tensors, channels first.

    Args:
        shared: names of the channels that do not depend on the light; the others get a leading axis of two lights.
    """
    item = {}
    for name, value in pair[0].items():
        arrays = [value] if name in shared else [channels[name] for channels in pair]
        stacked = torch.from_numpy(np.stack([np.ascontiguousarray(array) for array in arrays]))
        if name == "light":
            item[name] = stacked.float()
        elif name == "label":
            item[name] = stacked[0].long()
        else:
            stacked = stacked.float().unsqueeze(1) if stacked.ndim == 3 else stacked.float().permute(0, 3, 1, 2)
            item[name] = stacked[0] if name in shared else stacked
    return item
