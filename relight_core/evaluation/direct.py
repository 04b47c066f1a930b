"""The networks alone, without what the editor does before and after them.

This is what variants are compared by: no mirrored second look, no flattening of the albedo, no residual, no
enlarging.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import torch
import torch.nn.functional as F

from relight_core.face.parsing import INDEX
from relight_core.imaging.tensor_colour import grey, srgb_decode, srgb_encode
from relight_core.imaging.tensor_images import as_image, as_tensor
from relight_core.lighting.reflection import ReflectionTable
from relight_core.lighting.relief import ReliefTransport, march_relief
from relight_core.networks.bundle import NetworkBundle
from relight_core.pipeline import stages
from relight_core.pipeline.per_light.bare_skin import bare_skin
from relight_core.pipeline.per_light.hints import (
    Effects,
    doubtful_shadow,
    estimated_effects,
    explicit_sum,
    specular_shadow_hints,
    with_dull_parts,
)


@dataclass(frozen=True)
class FoundSurface:
    """What de-lighting found in one photo, (1, C, S, S); the last three only where SS asks for them."""

    albedo: torch.Tensor
    normal: torch.Tensor
    light: torch.Tensor
    transport: ReliefTransport | None = None
    relief: torch.Tensor | None = None
    parsing: torch.Tensor | None = None


class DirectRelighter:
    """De-light, estimate effects, compose: three forward passes in fp32."""

    def __init__(self, bundle: NetworkBundle, table: ReflectionTable):
        """Take networks in evaluation mode and the table, both on one device."""
        self._bundle, self._table = bundle, table
        self._device = table.transport.device

    @torch.inference_mode()
    def take_apart(self, photo: np.ndarray) -> FoundSurface:
        """De-light a photo (S, S, 3), linear, [0, 1]; S a multiple of what the network wants."""
        linear = as_tensor(photo, self._device).float()
        found = self._bundle.delight(srgb_encode(linear).contiguous(memory_format=torch.channels_last))
        normal = F.normalize(found.normal.float(), dim=1, eps=1e-4)
        parts = (srgb_decode(found.albedo_srgb.float()), normal, found.light.float())
        if not self._bundle.config.specular_shadow.reads_relief:
            return FoundSurface(*parts)
        parsing = torch.softmax(found.parsing_logits.float(), 1)
        person = 1 - parsing[:, INDEX["background"], None]
        relief = stages.height_of(found.relief.float(), photo.shape[0])
        transport = march_relief(relief[0, 0].cpu(), normal[0].cpu(), person[0, 0].cpu())
        return FoundSurface(*parts, transport, relief, parsing)

    @torch.inference_mode()
    def relight(self, found: FoundSurface, radiance: np.ndarray) -> dict[str, np.ndarray]:
        """Relight by a normalised light (16, 32, 3).

        Returns:
            images: "composition" (S, S, 3) linear; "specular" and "shadow" (S, S) where the networks have them.
        """
        light = torch.from_numpy(np.ascontiguousarray(radiance))[None].float().to(self._device)
        reflected, config = self._table(light, found.normal), self._bundle.config
        if found.parsing is not None:
            reflected = with_dull_parts(reflected, found.parsing)
        effects, channels = None, {}
        if config.composition.effects:
            effects = self._effects(found, reflected, light)
            channels = {"specular": as_image(effects.specular), "shadow": as_image(effects.shadow)}
        shown = effects or Effects(*[torch.zeros_like(found.albedo[:, :1])] * 2)
        explicit = explicit_sum(found.albedo, reflected, shown)
        image = self._bundle.composition(
            found.albedo, found.normal, shown.specular, _shown_shadow(found, reflected, shown), explicit, light
        )
        return channels | {"composition": as_image(image)}

    def _effects(self, found: FoundSurface, reflected: torch.Tensor, light: torch.Tensor) -> Effects:
        config, fraction = self._bundle.config.specular_shadow, None
        if found.transport is not None:
            fraction = found.transport.shadow_fraction(light.cpu()).to(self._device)
        hints = specular_shadow_hints(config, reflected, fraction, found.relief, found.parsing)
        estimate = self._bundle.specular_shadow(found.normal, light, hints)
        return replace(estimated_effects(config, estimate, reflected, found.albedo), by_relief=fraction)


def _shown_shadow(found: FoundSurface, reflected: torch.Tensor, effects: Effects) -> torch.Tensor:
    """Of the shadow what composition is shown, in training as in the editor (`hints.doubtful_shadow`)."""
    if found.parsing is None:
        return effects.shadow
    diffuse, gloss = grey(found.albedo * reflected[:, :3]), grey(reflected[:, 3:])
    return doubtful_shadow(effects, diffuse, gloss, bare_skin(found.parsing))


def found_channels(found: FoundSurface) -> dict[str, np.ndarray]:
    """What `scoring.score_surface` compares; these networks' one light stands for both it asks for."""
    light = found.light[0].cpu().numpy()
    return {"albedo": as_image(found.albedo), "normal": as_image(found.normal), "guess": light, "source_light": light}
