"""The stages of training (paper, section 4.3): three warm-ups on ground truth, then fine-tuning on pairs.

Each stage names the networks it changes and turns a batch into losses. Fine-tuning lights a portrait that
was de-lit from the pair's first photo with the pair's second light: first the de-lighting network learns
through the fixed relighting networks, then those learn on its predictions.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import partial
from typing import Literal

import torch
import torch.nn.functional as F

from relight_core.errors import InputError
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
        name: as in recipes, and in the state of a run that is resumed.
        trains: names of the networks whose weights it changes.
        through: those that it takes as earlier stages have trained them, to learn from what they say.
        losses: (bundle, reflection table, batch of pairs) -> loss terms.
        photographs, relief_shadow: what its samples need (see `dataset.stream.SampleStream`).
        learning_rate: the peak of its schedule.
        distilled: its ground truth is the wide pair's output (see `training.distillation`).
        samples: "pairs" of lights, or single photos with "outlines" (see `dataset.cutouts.outlines`) or with shadows
            of "gobos" (see `dataset.gobo_photos`).
        settled: batch normalisation uses the running statistics, which earlier stages have made reliable.
        recordable: its losses never synchronise with the host, so that a step can be replayed as CUDA graphs
            (`training.step`).
        prepare: (bundle, reflection table, batch of pairs) -> what `losses` gets instead of the batch. It depends on
            nothing that the stage changes and carries no gradient, so it runs ahead of the step.
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
    through: tuple[str, ...] = ()
    prepare: Callable[[NetworkBundle, ReflectionTable, Batch], Batch] | None = None

    def learners(self, config: BundleConfig) -> tuple[str, ...]:
        """The networks of `trains` that its losses depend on: without SS if composition is trained and ignores SS."""
        ignores_effects = "composition" in self.trains and not config.composition.effects
        return tuple(name for name in self.trains if not (ignores_effects and name == "specular_shadow"))

    def check_trained(self, trained: Collection[str], config: BundleConfig) -> None:
        """Refuse to learn through networks that nothing has trained: what random ones say teaches nothing.

        Raises:
            InputError: one of `through` that has a say is none of those that are trained.
        """
        unheard = () if config.composition.effects else ("specular_shadow",)
        if set(self.through) - {*trained, *unheard}:
            mend = "give their weights to start from, after --start, or let a recipe train them first"
            raise InputError(f"{self.name} learns from trained networks: {mend}")


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
        hinted: relief, its shadow and the parsing are the predicted ones, too. Otherwise they are the true ones, so
            that albedo and normals don't learn to compensate for errors of the relief.
        levelled_share: share of the photos whose albedo is brought to the truth's level first. The level can't be
            known, and its error drowns that of shading left in half a face.
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
    """Losses of both relighting networks on a predicted surface.

    Args:
        apart: no gradient flows from the picture through the effects into SS.
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
    """The paper's fine-tuning: everything is predicted by de-lighting, including the albedo."""
    with torch.no_grad():
        found = bundle.delight(batch["photo_srgb"].flatten(0, 1).contiguous(memory_format=torch.channels_last))
        found.normal = F.normalize(found.normal, dim=1, eps=1e-4)
    return _relit_from_photo(bundle, table, batch, found, hinted=True)


def _outline(bundle: NetworkBundle, table: ReflectionTable, batch: Batch) -> Losses:
    return outline_losses(bundle.person, batch)


def _foreign_shadow(bundle: NetworkBundle, table: ReflectionTable, batch: Batch) -> Losses:
    return foreign_shadow_losses(bundle.foreign_shadow, batch)


_RELIGHTING = ("specular_shadow", "composition")

_STAGES = (
    Stage(
        "warm-delight",
        ("delight",),
        _warm_delight,
        photographs=True,
        relief_shadow=False,
        learning_rate=1.5e-3,
        recordable=True,
    ),
    Stage(
        "warm-specular-shadow",
        ("specular_shadow",),
        _warm_specular_shadow,
        photographs=False,
        relief_shadow=True,
        learning_rate=2e-3,
    ),
    Stage(
        "warm-composition",
        ("composition",),
        _warm_composition,
        photographs=False,
        relief_shadow=False,
        learning_rate=2e-3,
    ),
    Stage("warm-relight", _RELIGHTING, _warm_relight, photographs=False, relief_shadow=True, learning_rate=2e-3),
    Stage(
        "tune-delight",
        ("delight",),
        _tune_delight,
        photographs=True,
        relief_shadow=True,
        learning_rate=2e-4,
        settled=True,
        recordable=True,
        through=_RELIGHTING,
    ),
    Stage(
        "tune-delight-strongly",
        ("delight",),
        partial(_tune_delight, relit_weight=3.0),
        photographs=True,
        relief_shadow=True,
        learning_rate=4e-4,
        settled=True,
        recordable=True,
        through=_RELIGHTING,
    ),
    Stage(
        "tune-relight",
        _RELIGHTING,
        partial(_relit, apart=True),
        photographs=True,
        relief_shadow=False,
        learning_rate=1e-3,
        settled=True,
        through=("delight",),
        prepare=on_predicted_surface,
    ),
    Stage(
        "tune-on-predictions",
        _RELIGHTING,
        _tune_on_predictions,
        photographs=True,
        relief_shadow=True,
        learning_rate=2e-4,
        settled=True,
        through=("delight",),
    ),
    Stage(
        "distil-relight",
        ("narrow",),
        distillation_losses,
        photographs=True,
        relief_shadow=False,
        learning_rate=1e-3,
        distilled=True,
        through=("delight", *_RELIGHTING),
    ),
    Stage(
        "outline",
        ("person",),
        _outline,
        photographs=True,
        relief_shadow=False,
        learning_rate=1.5e-3,
        samples="outlines",
    ),
    Stage(
        "foreign-shadow",
        ("foreign_shadow",),
        _foreign_shadow,
        photographs=True,
        relief_shadow=False,
        learning_rate=1.5e-3,
        samples="gobos",
    ),
)

STAGES = {stage.name: stage for stage in _STAGES}
"""By name, in the order they are run. "warm-relight" does the second and third warm-up in one pass over the data, to
save time on a CPU; "tune-on-predictions" is the paper's form of "tune-relight", and "tune-delight" that of
"tune-delight-strongly", in which the relit picture has three times the weight."""
