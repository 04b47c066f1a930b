"""What one step teaches the de-lighting network (paper, section 4.1)."""

from __future__ import annotations

import torch

from relight_core.face.parsing import FACE_LABELS
from relight_core.imaging.tensor_colour import srgb_decode, srgb_encode
from relight_core.imaging.tensor_constants import constant
from relight_core.imaging.tensor_normals import unit_normals
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.delight import DelightNetwork, Delit
from relight_core.pipeline.per_photo.second_look import evened_out
from relight_core.training.coarser import shrunk
from relight_core.training.losses import (
    edges_l1,
    focal_parsing,
    horizon_l1,
    irradiance_l1,
    levelled_l1,
    masked_l1,
    relief_l1,
    wlog_l2,
)

_PARSING_WEIGHT = 0.2
"""At first the focal loss is ten times any other term, and steps of one size for all weights would follow it alone."""

_LIGHT_WEIGHT = 0.4
"""Of the light and of what it does to a white ball. With all of it, the encoder's gradient is mostly theirs and ten
times that of the normals; and the editor fits the light anew to albedo and normals."""

_HORIZON_WEIGHT, _HORIZON_AZIMUTHS = 1.0, 6
"""With four times the weight horizons count as much as heights, and cost light and albedo more than they bring; of
the azimuths every step draws others."""

_SECOND_LOOK_SHARE = 1 / 3
"""Of the pairs; a second look costs as much as half of a pair's first ones."""


def delight_losses(
    network: DelightNetwork, table: ReflectionTable, batch: dict[str, torch.Tensor]
) -> tuple[Delit, dict[str, torch.Tensor]]:
    """Losses of both photos of every pair, each term by name; their sum is Eq. 5, plus the relief's.

    The weights bring terms of different units to the same order: the paper sums them as they are, on its
    own units. What the network is configured not to find is not asked for.
    """
    photo = batch["photo_srgb"].flatten(0, 1)
    found = network(photo.contiguous(memory_format=torch.channels_last))
    twice = {name: batch[name].repeat_interleave(2, 0) for name in ("albedo", "normal", "relief", "label", "covered")}
    covered, light = _face_first(twice["covered"], twice["label"]), batch["light"].flatten(0, 1)
    half_width = photo.shape[-1] / 128  # in de-lighting's unit of relief, 64 pixels
    losses = _albedo_losses(found.albedo_srgb, srgb_encode(twice["albedo"]), covered) | {
        "normal": 2.0 * masked_l1(found.normal, twice["normal"], covered),
        "normal_edges": edges_l1(found.normal, twice["normal"], covered),
        "light": _LIGHT_WEIGHT * wlog_l2(found.light, light),
        "irradiance": _LIGHT_WEIGHT * irradiance_l1(found.light, light, table),
    }
    if network.config.classes:
        losses["parsing"] = _PARSING_WEIGHT * focal_parsing(found.coarse_logits, twice["label"])
    if network.config.relief:
        losses["relief"] = relief_l1(found.relief, twice["relief"] * half_width, covered)
        horizon = horizon_l1(found.relief / half_width, twice["relief"], twice["covered"], _azimuths(photo.device))
        losses["horizon"] = _HORIZON_WEIGHT * horizon
    return found, losses


def _albedo_losses(found: torch.Tensor, truth: torch.Tensor, covered: torch.Tensor) -> dict[str, torch.Tensor]:
    return {
        "albedo": masked_l1(found, truth, covered),
        "albedo_levelled": 2.0 * levelled_l1(found, truth, covered),
        "albedo_edges": edges_l1(found, truth, covered),
    }


def second_look_losses(
    network: DelightNetwork, batch: dict[str, torch.Tensor], found: Delit, size: int
) -> dict[str, torch.Tensor]:
    """The albedo of a second look (`pipeline.per_photo.second_look`) at one photo of every third pair, by term.

    Args:
        found: in both photos of every pair.
        size: of the surface that the editor evens out the photo with.

    Returns:
        Losses that weigh what one pair in three does, of however many pairs there are.
    """
    pairs = max(1, round(_SECOND_LOOK_SHARE * len(batch["photo_srgb"])))
    batch = {name: batch[name][:pairs] for name in ("photo_srgb", "albedo", "covered", "label")}
    device = batch["photo_srgb"].device
    one = 2 * torch.arange(pairs, device=device) + torch.randint(0, 2, (pairs,), device=device)
    linear = srgb_decode(batch["photo_srgb"].flatten(0, 1)[one])
    albedo, normal = (part.detach()[one].float() for part in (found.albedo_srgb, found.normal))
    evened = evened_out(
        linear,
        albedo=shrunk(srgb_decode(albedo), size),
        normal=unit_normals(shrunk(normal, size)),
        photo=shrunk(linear, size),
        person=shrunk(batch["covered"], size),
    )
    again = network(srgb_encode(evened).contiguous(memory_format=torch.channels_last))
    covered = _face_first(batch["covered"], batch["label"])
    losses = _albedo_losses(again.albedo_srgb, srgb_encode(batch["albedo"]), covered)
    return {f"second_{name}": _SECOND_LOOK_SHARE * value for name, value in losses.items()}


def _azimuths(device: torch.device) -> torch.Tensor:
    """Evenly around, from a random one on."""
    turned = torch.rand((), device=device) + torch.arange(_HORIZON_AZIMUTHS, device=device)
    return turned * (2 * torch.pi / _HORIZON_AZIMUTHS)


def _face_first(covered: torch.Tensor, label: torch.Tensor) -> torch.Tensor:
    """Weights of the pixels: a face, which everyone looks at, counts twice as much as hair and cloth."""
    face = torch.isin(label, constant(FACE_LABELS, label.device, label.dtype))
    return covered * (1 + face.float()[:, None])
