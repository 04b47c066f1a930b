"""The stages of training (paper, section 4.3): three warm-ups on ground truth, then fine-tuning on pairs.

Each stage names the networks it changes and turns a batch into losses. Fine-tuning lights a portrait that
was de-lit from the pair's first photo with the pair's second light: first the de-lighting network learns
through the fixed relighting networks, then those learn on its predictions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Literal

import torch
import torch.nn.functional as F

from relight_core.imaging.tensor_colour import srgb_decode
from relight_core.imaging.tensor_normals import unit_normals
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import BundleConfig, NetworkBundle
from relight_core.networks.delight import Delit
from relight_core.training.coarser import shrunk
from relight_core.training.delight_step import delight_losses, second_look_losses
from relight_core.training.distillation import distillation_losses
from relight_core.training.foreign_shadow_step import foreign_shadow_losses
from relight_core.training.losses import level_of
from relight_core.training.outline_step import outline_losses
from relight_core.training.predicted import found_hints, on_predicted_surface, surface_size
from relight_core.training.relight_steps import (
    as_smooth_as_predicted,
    composition_losses,
    flatten_pairs,
    specular_shadow_losses,
    with_reflected,
)

_LEVELLED_SHARE = 1 / 2

Losses = dict[str, torch.Tensor]
Batch = dict[str, torch.Tensor]


@dataclass(frozen=True)
class Stage:
    """One stage.

    Attributes:
        name: by which a run that goes on knows it again.
        trains: names of the networks it changes.
        losses: (bundle, reflection table, batch of pairs) -> loss terms.
        photographs, relief_shadow: what its samples need (see `dataset.stream.SampleStream`).
        learning_rate: the peak of its schedule.
        distilled: its batches are what the wide pair of networks says (see `training.distillation`).
        samples: "pairs" of lights, or single photos with "outlines" (see `dataset.cutouts.outlines`) or with shadows
            of "gobos" (see `dataset.gobo_photos`).
        settled: its networks come from another stage with running statistics that hold, and are normalised by those.
        recordable: its losses ask the host for nothing, so that a GPU can play its steps back (`training.step`).
        prepare: (bundle, reflection table, batch of pairs) -> what `losses` gets in the batch's place. It depends on
            nothing that the stage changes and carries no gradient, so it is done ahead of the step.
    """

    name: str
    trains: tuple[str, ...]
    losses: Callable[[NetworkBundle, ReflectionTable, Batch], Losses]
    photographs: bool
    relief_shadow: bool
    learning_rate: float
    distilled: bool = False
    samples: Literal["pairs", "outlines", "gobos"] = "pairs"
    settled: bool = False
    recordable: bool = False
    prepare: Callable[[NetworkBundle, ReflectionTable, Batch], Batch] | None = None

    def learners(self, config: BundleConfig) -> tuple[str, ...]:
        """What of `trains` its losses reach: SS is out where composition learns as well and is told nothing of it."""
        unheard = "composition" in self.trains and not config.composition.effects
        return tuple(name for name in self.trains if not (unheard and name == "specular_shadow"))


def _warm_delight(bundle: NetworkBundle, table: ReflectionTable, batch: Batch) -> Losses:
    return delight_losses(bundle.delight, table, batch)[1]


def _warm_specular_shadow(bundle: NetworkBundle, table: ReflectionTable, batch: Batch) -> Losses:
    return specular_shadow_losses(bundle.specular_shadow, table, _smoothed(flatten_pairs(batch)))[1]


def _smoothed(flat: Batch) -> Batch:
    return flat | {"normal": as_smooth_as_predicted(flat["normal"])}


def _warm_composition(bundle: NetworkBundle, table: ReflectionTable, batch: Batch) -> Losses:
    return composition_losses(bundle.composition, table, flatten_pairs(batch), None)[1]


def _warm_relight(bundle: NetworkBundle, table: ReflectionTable, batch: Batch) -> Losses:
    """SS and composition together: the latter learns on the former's output, which carries no gradient."""
    flat = flatten_pairs(batch)
    effects, losses = specular_shadow_losses(bundle.specular_shadow, table, _smoothed(flat))
    effects.specular, effects.shadow = effects.specular.detach(), effects.shadow.detach()
    return losses | composition_losses(bundle.composition, table, flat, effects)[1]


def _relit_from_photo(
    bundle: NetworkBundle,
    table: ReflectionTable,
    batch: Batch,
    found: Delit,
    *,
    hinted: bool = False,
    levelled_share: float = 0.0,
) -> Losses:
    """Losses of every photo relit with the other light of its pair, on predicted albedo and normal.

    Args:
        hinted: relief, its shadow and the parsing are found ones, too. Else they are the true ones: albedo and
            normals are not to make up for what a relief lacks.
        levelled_share: of the photos, whose albedo is brought to the truth's level first. How bright it is, nobody
            can know, and the error of guessing it drowns that of shading left in half a face.
    """
    size = surface_size(bundle, batch["photo_srgb"])
    lit = {name: value for name, value in batch.items() if name not in ("photo_srgb", "normal")}
    swapped = {n: v.unflatten(0, (-1, 2)).flip(1).flatten(0, 1) for n, v in flatten_pairs(lit, size).items()}
    albedo = shrunk(srgb_decode(found.albedo_srgb), size)
    level = level_of(albedo, swapped["albedo"], swapped["covered"])
    levelled = torch.rand(level.shape, device=level.device) < levelled_share
    swapped["albedo"] = albedo * torch.where(levelled, level, torch.ones_like(level))
    swapped["normal"] = unit_normals(shrunk(found.normal, size))
    if hinted:
        swapped |= found_hints(bundle, found, swapped["light"], size)
    return _relit(bundle, table, swapped)


def _relit(bundle: NetworkBundle, table: ReflectionTable, flat: Batch, *, apart: bool = False) -> Losses:
    """Losses of both relighting networks on what was found.

    Args:
        apart: composition learns on the effects as they are, and SS nothing from the picture.
    """
    flat = with_reflected(table, flat)
    effects, losses = None, {}
    if bundle.config.composition.effects:
        effects, losses = specular_shadow_losses(bundle.specular_shadow, table, flat)
        if apart:
            effects.specular, effects.shadow = effects.specular.detach(), effects.shadow.detach()
    return losses | composition_losses(bundle.composition, table, flat, effects)[1]


def _tune_delight(bundle: NetworkBundle, table: ReflectionTable, batch: Batch, relit_weight: float = 1.0) -> Losses:
    found, losses = delight_losses(bundle.delight, table, batch)
    relit = _relit_from_photo(bundle, table, batch, found, levelled_share=_LEVELLED_SHARE)
    losses["relit"] = relit_weight * (relit["encoded"] + relit["display"])
    return losses | second_look_losses(bundle.delight, batch, found, surface_size(bundle, batch["photo_srgb"]))


def _tune_on_predictions(bundle: NetworkBundle, table: ReflectionTable, batch: Batch) -> Losses:
    """The paper's own fine-tuning: the albedo, too, is de-lighting's, and so is all else that is found."""
    with torch.no_grad():
        found = bundle.delight(batch["photo_srgb"].flatten(0, 1).contiguous(memory_format=torch.channels_last))
        found.normal = F.normalize(found.normal, dim=1, eps=1e-4)
    return _relit_from_photo(bundle, table, batch, found, hinted=True)


def _outline(bundle: NetworkBundle, table: ReflectionTable, batch: Batch) -> Losses:
    return outline_losses(bundle.person, batch)


def _foreign_shadow(bundle: NetworkBundle, table: ReflectionTable, batch: Batch) -> Losses:
    return foreign_shadow_losses(bundle.foreign_shadow, batch)


_STAGES = (
    Stage("warm-delight", ("delight",), _warm_delight, True, False, 1.5e-3, recordable=True),
    Stage("warm-specular-shadow", ("specular_shadow",), _warm_specular_shadow, False, True, 2e-3),
    Stage("warm-composition", ("composition",), _warm_composition, False, False, 2e-3),
    Stage("warm-relight", ("specular_shadow", "composition"), _warm_relight, False, True, 2e-3),
    Stage("tune-delight", ("delight",), _tune_delight, True, True, 2e-4, settled=True, recordable=True),
    Stage(
        "tune-delight-strongly",
        ("delight",),
        partial(_tune_delight, relit_weight=3.0),
        True,
        True,
        4e-4,
        settled=True,
        recordable=True,
    ),
    Stage(
        "tune-relight",
        ("specular_shadow", "composition"),
        partial(_relit, apart=True),
        True,
        False,
        1e-3,
        settled=True,
        prepare=on_predicted_surface,
    ),
    Stage(
        "tune-on-predictions", ("specular_shadow", "composition"), _tune_on_predictions, True, True, 2e-4, settled=True
    ),
    Stage("distil-relight", ("narrow",), distillation_losses, True, False, 1e-3, distilled=True),
    Stage("outline", ("person",), _outline, True, False, 1.5e-3, samples="outlines"),
    Stage("foreign-shadow", ("foreign_shadow",), _foreign_shadow, True, False, 1.5e-3, samples="gobos"),
)

STAGES = {stage.name: stage for stage in _STAGES}
"""By name, in the order they are run. "warm-relight" does the second and third warm-up in one pass over
the data, which is what a CPU has time for; "tune-on-predictions" is the paper's form of "tune-relight", and
"tune-delight" that of "tune-delight-strongly", in which the relit picture counts three times."""
