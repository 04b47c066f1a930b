"""What one step teaches the SS and the composition networks (paper, section 4.2)."""

from __future__ import annotations

import torch
import torch.nn.functional as F

from relight_core.face.parsing import CLASSES
from relight_core.imaging.tensor_colour import grey, srgb_encode
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.composition import CompositionNetwork, encode_radiance
from relight_core.networks.specular_shadow import SpecularShadowNetwork
from relight_core.pipeline.per_light.bare_skin import bare_skin
from relight_core.pipeline.per_light.hints import (
    Effects,
    doubtful_shadow,
    estimated_effects,
    explicit_sum,
    specular_shadow_hints,
    with_dull_parts,
)
from relight_core.training.coarser import label_shares, shrunk_heads
from relight_core.training.losses import fraction_loss, masked_l1, masked_l2


def flatten_pairs(batch: dict[str, torch.Tensor], size: int | None = None) -> dict[str, torch.Tensor]:
    """Both lights of every pair as one batch; what the lights share is repeated, labels become a parsing.

    Args:
        size: the side to which all images are shrunk, whatever the labels' own is; as they are for None.
    """
    label = batch["label"].repeat_interleave(2, 0)
    images = {name: value for name, value in batch.items() if name != "label"}
    whole = {
        name: value.flatten(0, 1) if value.ndim == 5 else value.repeat_interleave(2, 0)
        for name, value in images.items()
    }
    flat = shrunk_heads(whole, size)
    side = size or label.shape[-1]
    return flat | {"label": label, "parsing": label_shares(label, len(CLASSES), (side, side))}


def as_smooth_as_predicted(normal: torch.Tensor) -> torch.Tensor:
    """Normals (B, 3, H, W) smoothed by a random amount for the batch, as de-lighting's are."""
    reach = int(torch.randint(0, 3, ()))
    for _ in range(2 if reach else 0):
        normal = F.avg_pool2d(normal, 2 * reach + 1, 1, reach, count_include_pad=False)
    return F.normalize(normal, dim=1, eps=1e-4)


def specular_shadow_losses(
    network: SpecularShadowNetwork, table: ReflectionTable, flat: dict[str, torch.Tensor]
) -> tuple[Effects, dict[str, torch.Tensor]]:
    """Eq. 6 on the additive channels, and beside it what keeps sparse shadow alive: the cross-entropy of the fractions.

    A network that gives the additive maps themselves has no fractions, and a squared error in their place: under
    Eq. 6 alone, 0 everywhere is the best that it finds for long.
    """
    normal, albedo, covered = flat["normal"], flat["albedo"], flat["covered"]
    reflected = _reflected(table, flat)
    seen = (flat.get("relief_shadow"), flat.get("relief"), flat.get("parsing"))
    hints = specular_shadow_hints(network.config, reflected, *seen)
    occlusion = network(normal.contiguous(memory_format=torch.channels_last), flat["light"], hints)
    effects = estimated_effects(network.config, occlusion, reflected, albedo)
    if network.config.reads_relief:
        # Who is told nothing of a relief has none when it relights, whatever the samples hold.
        effects.by_relief = flat.get("relief_shadow")
    losses = {
        "specular": 10 * masked_l1(effects.specular, flat["specular"], covered),
        "shadow": 5 * masked_l1(effects.shadow, flat["shadow"], covered),
    }
    if network.config.additive:
        losses["specular_squared"] = 100 * masked_l2(effects.specular, flat["specular"], covered)
        losses["shadow_squared"] = 60 * masked_l2(effects.shadow, flat["shadow"], covered)
    else:
        irradiance, gloss = (grey(part) * covered for part in (reflected[:, :3], reflected[:, 3:]))
        losses["shadow_fraction"] = 0.5 * fraction_loss(occlusion.shadow, flat["shadow_fraction"], irradiance)
        losses["gloss_fraction"] = 0.25 * fraction_loss(occlusion.gloss, flat["gloss_fraction"], 8 * gloss)
    return effects, losses


def with_reflected(table: ReflectionTable, flat: dict[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    """A batch with the unoccluded irradiance and gloss of its surfaces, for all losses that ask for them."""
    return flat | {"reflected": _reflected(table, flat)}


def _reflected(table: ReflectionTable, flat: dict[str, torch.Tensor]) -> torch.Tensor:
    """Unoccluded irradiance and gloss: the batch's own, or what a surface of such normals and parts reflects."""
    if "reflected" in flat:
        return flat["reflected"]
    return with_dull_parts(table(flat["light"], flat["normal"]), flat["parsing"])


def composition_losses(
    network: CompositionNetwork,
    table: ReflectionTable,
    flat: dict[str, torch.Tensor],
    effects: Effects | None,
) -> tuple[torch.Tensor, dict[str, torch.Tensor]]:
    """Eq. 8 in the invertible encoding, on estimated effects or, for None, on the true ones (warm-up).

    Of a shadow that the relief casts too, the network is shown what the editor shows it (`hints.doubtful_shadow`).
    """
    normal, albedo, covered = flat["normal"], flat["albedo"], flat["covered"]
    reflected = _reflected(table, flat)
    if effects is None:
        effects = Effects(flat["specular"], flat["shadow"])
    explicit = explicit_sum(albedo, reflected, effects)
    diffuse, gloss = grey(albedo * reflected[:, :3]), grey(reflected[:, 3:])
    shown = doubtful_shadow(effects, diffuse, gloss, bare_skin(flat["parsing"]))
    image = network(albedo, normal, effects.specular, shown, explicit, flat["light"])
    truth = flat["image"]
    losses = {
        "encoded": masked_l1(encode_radiance(image), encode_radiance(truth), covered),
        "display": masked_l1(srgb_encode(image.clamp(0, 1)), srgb_encode(truth.clamp(0, 1)), covered),
    }
    return image, losses
