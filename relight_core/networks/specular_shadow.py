"""The specular and shadow (SS) network (paper, section 4.2.1): normals and a light in, both effects out."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import nn

from relight_core.networks.lit import LitNetwork

_SMALL_LOGIT = -3.0
"""Where additive maps begin: near zero after softplus, which is what most of their pixels are."""


@dataclass(frozen=True)
class SpecularShadowConfig:
    """Size and variant.

    Attributes:
        width, levels: as in DelightConfig.
        per_pixel_light: also see the unoccluded irradiance and gloss at each normal.
        relief_shadow: also see the shadow that the predicted relief casts.
        parsing_classes: also see the relief itself and the parsing, of so many classes: a chin and the neck
            behind it may face the same way, and a brim shades what is under it. 0 for neither.
        additive: the maps themselves come out, as in the paper, instead of occluded fractions.
        modulated: the light acts through LFM; when false it enters at the bottleneck alone.
    """

    width: int = 16
    levels: int = 5
    per_pixel_light: bool = True
    relief_shadow: bool = True
    parsing_classes: int = 0
    additive: bool = False
    modulated: bool = True

    @property
    def inputs(self) -> int:
        """Input channels."""
        return 3 + self.hints

    @property
    def reads_relief(self) -> bool:
        """Whether it is told anything of the relief."""
        return self.relief_shadow or self.parsing_classes > 0

    @property
    def hints(self) -> int:
        """Those beside the normal."""
        shape = 1 + self.parsing_classes if self.parsing_classes else 0
        return shape + 2 * self.per_pixel_light + self.relief_shadow


@dataclass
class Occlusion:
    """What keeps light from a surface, as logits of fractions in [0, 1], each (B, 1, H, W).

    `shadow` is the fraction of the unoccluded irradiance that self-occlusion takes, `gloss` that of the
    unoccluded specular reflection. Fractions are trained instead of the additive maps themselves: shadow
    is sparse, and a plain L1 on it collapses to no shadow anywhere. Of an additive network (see
    `SpecularShadowConfig`) they are the shadow and specular maps before `pipeline.per_light.hints` makes them positive.
    """

    shadow: torch.Tensor
    gloss: torch.Tensor


class SpecularShadowNetwork(LitNetwork):
    """Encoder on what the surface is, decoder modulated by the light after every upsampling (LFM)."""

    def __init__(self, config: SpecularShadowConfig | None = None):
        super().__init__(config or SpecularShadowConfig(), outputs=2)
        if self.config.additive:
            nn.init.constant_(self.head.bias, _SMALL_LOGIT)

    def begin(self, normal: torch.Tensor, hints: torch.Tensor | None = None) -> torch.Tensor:
        """What no light changes, once per surface: normal, and hints up to the parsing. For `forward`'s `begun`."""
        return self.encoder.begin(normal if hints is None else torch.cat([normal, hints], 1))

    def forward(
        self,
        normal: torch.Tensor,
        light: torch.Tensor,
        hints: torch.Tensor | None = None,
        begun: torch.Tensor | None = None,
    ) -> Occlusion:
        """Estimate occlusion.

        Args:
            normal: (B, 3, H, W) unit vectors.
            light: (B, 16, 32, 3) normalised radiance.
            hints: (B, hints, H, W): relief, parsing, log(1 + irradiance), log(1 + gloss), shadow fraction from
                relief, as far as the configuration asks for them.
            begun: of `begin`; `hints` are then only those that it has not seen, and `normal` is not read.
        """
        x = normal if hints is None else hints if begun is not None else torch.cat([normal, hints], 1)
        shadow, gloss = self.lit(self.encoder(x, begun), light).split(1, 1)
        if self.config.relief_shadow and hints is not None:
            shadow = shadow + torch.logit(hints[:, -1:].float().clamp(0.02, 0.98))
        return Occlusion(shadow, gloss)
