"""The quality tiers: how large a portrait is seen, how often, and by which networks."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from relight_core.errors import InputError

if TYPE_CHECKING:  # PyTorch takes a second, and the command line knows the tiers by name
    from relight_core.networks.pair import PairName


_OF_SURFACE = ("delight_size", "network_size", "mirrored", "looks_twice", "precision", "takes_foreign_shadow_off")
"""What of a tier decides about the surface, beside the side of the view that is taken apart."""


@dataclass(frozen=True)
class Tier:
    """One setting of the accuracy dial.

    Attributes:
        size: side of the view of the portrait, in pixels; channels have it.
        delight_size: side at which the de-lighting network sees that view, a multiple of 64.
        network_size: side at which the others see it, a multiple of 32. They were trained on images of 128
            pixels, and a face much larger than there confuses them.
        relief_size: side of the relief that is marched for cast shadow. It divides `network_size`: else its
            lattice shows where the light grazes the surface.
        mirrored: de-light the mirrored view too, and average.
        looks_twice: de-light it once more, with most of its shading taken out (see `pipeline.per_photo.second_look`).
        takes_foreign_shadow_off: see `pipeline.per_photo.foreign_shadow`.
        apart_from: side of the view that is taken apart; None for `size`.
        level_of: the tier whose model says how bright the photo's own light is; None for this one's. Each tier's
            model is off by a few percent of its own, and a picture must not change its level with the tier.
        shadow_network: what the surface hides from the light is seen by the SS network; else the relief's
            horizons alone say it, and a new light costs a matrix product.
        correction: the composition network corrects the sum of the channels; else the sum is the picture.
        precision: of the networks, "bf16" where the processor has it, or "fp32".
        lights_nearer: where a face is small in its view, it is also lit in a nearer one (see
            `pipeline.per_photo.nearer_look`).
        pair: which width of the SS and composition networks; "wide" serves where a file has no other.
    """

    size: int
    delight_size: int
    network_size: int
    relief_size: int
    mirrored: bool
    shadow_network: bool = True
    correction: bool = True
    precision: str = "bf16"
    pair: PairName = "wide"
    lights_nearer: bool = False
    looks_twice: bool = False
    takes_foreign_shadow_off: bool = True
    apart_from: int | None = None
    level_of: Tier | None = None

    @property
    def size_apart(self) -> int:
        """Side of the view that is taken apart, in pixels."""
        return self.apart_from or self.size

    @property
    def surface_key(self) -> tuple:
        """What de-lighting depends on; tiers that agree in it share its result."""
        return self.size_apart, *(getattr(self, name) for name in _OF_SURFACE)

    def on_surface_of(self, other: Tier) -> Tier:
        """This tier with the surface that another one finds; the tier itself, where that is its own."""
        if self.surface_key == other.surface_key:
            return self
        of_surface = {name: getattr(other, name) for name in _OF_SURFACE}
        return replace(self, apart_from=other.size_apart, level_of=other, **of_surface)

    @property
    def begun_key(self) -> tuple:
        """What the light-independent part of the SS network's work depends on."""
        return self.surface_key, self.pair

    @property
    def relief_key(self) -> tuple:
        """What the relief's horizons depend on."""
        return self.surface_key, self.relief_size


TIERS = {
    # The same surface as "live", so that changing over between the two while dragging costs nothing.
    "draft": Tier(256, 256, 128, 64, False, shadow_network=False, correction=False, pair="narrow"),
    "live": Tier(256, 256, 128, 64, False, pair="narrow"),
    "final": Tier(512, 256, 128, 64, True, lights_nearer=True, looks_twice=True),
}


def tier_of(quality: str | Tier) -> Tier:
    """The tier of a name, or the tier itself; raises InputError naming the known ones."""
    if isinstance(quality, Tier):
        return quality
    if quality not in TIERS:
        raise InputError(f"unknown quality {quality!r}: choose one of {', '.join(TIERS)}")
    return TIERS[quality]


def quality_of(tier: Tier) -> str:
    """The name of a tier, "custom" where it has none."""
    return next((name for name, known in TIERS.items() if known == tier), "custom")
