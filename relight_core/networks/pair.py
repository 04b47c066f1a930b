"""The two relighting networks as a pair, of which a family may have several widths."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal, Protocol

from torch import nn

from relight_core.networks.composition import CompositionConfig, CompositionNetwork
from relight_core.networks.specular_shadow import SpecularShadowConfig, SpecularShadowNetwork

PairName = Literal["narrow", "wide"]

_NARROW_LEVELS = 3, 4
"""Of composition and SS: the coarsest level of a wide network holds half its weights and a tenth of its time."""


class BothNetworks(Protocol):
    """What has both networks."""

    specular_shadow: SpecularShadowNetwork
    composition: CompositionNetwork


@dataclass(frozen=True)
class PairConfig:
    """Configurations of both."""

    specular_shadow: SpecularShadowConfig = field(default_factory=SpecularShadowConfig)
    composition: CompositionConfig = field(default_factory=CompositionConfig)

    @classmethod
    def from_parts(cls, parts: Mapping[str, Mapping[str, Any]]) -> PairConfig:
        """From dictionaries; raises KeyError or TypeError for anything else."""
        return cls(SpecularShadowConfig(**parts["specular_shadow"]), CompositionConfig(**parts["composition"]))

    def __str__(self) -> str:
        shadow, composition = self.specular_shadow, self.composition
        return (
            f"SS {shadow.width} channels in {shadow.levels} levels, "
            f"composition {composition.width} in {composition.levels}"
        )

    def narrowed(self, width: int) -> PairConfig:
        """The same variant of both with so many channels at the finest level of SS, and fewer levels."""
        composition, shadow = self.composition, self.specular_shadow
        share = width / shadow.width
        return PairConfig(
            replace(shadow, width=width, levels=min(shadow.levels, _NARROW_LEVELS[1])),
            replace(
                composition,
                width=max(round(share * composition.width / 4) * 4, 4),
                levels=min(composition.levels, _NARROW_LEVELS[0]),
            ),
        )


class RelightingPair(nn.Module):
    """SS and composition networks that were trained to work together."""

    def __init__(self, config: PairConfig):
        super().__init__()
        self.config = config
        self.specular_shadow = SpecularShadowNetwork(config.specular_shadow)
        self.composition = CompositionNetwork(config.composition)

    def told_of_light_like(self, other: BothNetworks) -> RelightingPair:
        """Take over what another pair reads from a light, in place.

        LFM's first layer makes features of the light alone, however many channels they then modulate. Levels
        are paired from the finest on, where they have the same resolution.
        """
        for ours, theirs in (
            (self.specular_shadow.modulations, other.specular_shadow.modulations),
            (self.composition.modulations, other.composition.modulations),
        ):
            for mine, given in zip(reversed(ours), reversed(theirs), strict=False):
                mine.fc1.load_state_dict(given.fc1.state_dict())
        return self
