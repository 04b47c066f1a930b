"""What a narrow pair of relighting networks learns: to answer as the wide one does where the editor asks.

Knowledge distillation (Hinton et al. 2015). The examples are surfaces that the shipped de-lighting network finds
in photos, under lights, with all that the wide pair says of them; made as the editor makes them, once, and learnt
from many times: finding a surface takes longer than a step on it.
"""

from __future__ import annotations

import copy
import hashlib

import torch

from relight_core.imaging.tensor_colour import srgb_decode
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import NetworkBundle
from relight_core.pipeline import stages
from relight_core.pipeline.per_light.hints import estimated_effects, specular_shadow_hints
from relight_core.training.predicted import relief_shadows, surface_size
from relight_core.training.relight_steps import composition_losses, specular_shadow_losses

Batch = dict[str, torch.Tensor]

LIGHTS_PER_SURFACE = 4
_LIGHTS_PER_STEP = 1


class Teacher:
    """De-lighting and the wide pair of a bundle, as the editor runs them.

    Attributes:
        name: of its weights; other ones have another.
    """

    def __init__(self, bundle: NetworkBundle, table: ReflectionTable, device: str = "cpu"):
        """Copy the networks; what the bundle learns from now on changes nothing here."""
        self.name = _name_of(bundle)
        self._bundle = copy.deepcopy(bundle).for_inference().to(device)
        self._table = table
        self._device = device

    @torch.inference_mode()
    def examples(self, batch: Batch) -> Batch:
        """Every photo of a batch of pairs taken apart, and put together under its own light and the next ones.

        Returns:
            By surface: "albedo", "normal", "relief", "parsing", "covered" (2 * pairs, C, S, S). By surface and
            light: "light", what the light does to the surface ("reflected", "relief_shadow"), and the wide pair's
            answers under the names that the truth has elsewhere (2 * pairs, lights, ...).
        """
        lights = batch["light"].flatten(0, 1).to(self._device)
        photos = srgb_decode(batch["photo_srgb"].flatten(0, 1).float())
        found = [self._example(photo, _some_from(lights, first)) for first, photo in enumerate(photos)]
        return {name: torch.stack([example[name] for example in found]) for name in found[0]}

    def _example(self, photo: torch.Tensor, lights: torch.Tensor) -> Batch:
        view = photo.permute(1, 2, 0).cpu().numpy()
        surface = stages.delight(self._bundle, view, surface_size(self._bundle, photo), self._device)
        size = surface.normal.shape[-1]
        shadow = relief_shadows(surface.relief, surface.normal, surface.person, lights[None], size)
        reflector = stages.reflector(self._table, surface)
        answers = [
            self._answer(surface, stages.reflect(reflector, light[None]), hint[None], light[None])
            for light, hint in zip(lights, shadow, strict=True)
        ]
        lit = {name: torch.cat([answer[name] for answer in answers]) for name in answers[0]}
        seen = {name: getattr(surface, name)[0] for name in ("albedo", "normal", "relief", "parsing")}
        return seen | {"covered": surface.person[0], "light": lights, "relief_shadow": shadow} | lit

    def _answer(self, surface: stages.Surface, reflected: torch.Tensor, hint: torch.Tensor, light) -> Batch:
        networks = stages.in_precision(self._bundle, self._device)
        network = networks.specular_shadow
        hints = specular_shadow_hints(network.config, reflected, hint, surface.relief, surface.parsing)
        occlusion = network(surface.normal, light, hints)
        effects = estimated_effects(network.config, occlusion, reflected, surface.albedo)
        effects.by_relief = hint
        image = stages.compose(networks, surface, reflected, effects, light).image
        return {
            "reflected": reflected,
            "specular": effects.specular,
            "shadow": effects.shadow,
            "shadow_fraction": torch.sigmoid(occlusion.shadow),
            "gloss_fraction": torch.sigmoid(occlusion.gloss),
            "image": image,
        }


def _name_of(bundle: NetworkBundle) -> str:
    """The same for the same weights, whatever narrow pair lies beside them."""
    digest = hashlib.sha256()
    for key, value in sorted(bundle.state_dict().items()):
        if not key.startswith("narrow."):
            unsigned_zeros = value.cpu() + 0  # Averaged weights have no -0.
            digest.update(unsigned_zeros.contiguous().reshape(-1).view(torch.uint8).numpy())
    return digest.hexdigest()[:16]


def _some_from(lights: torch.Tensor, first: int) -> torch.Tensor:
    """Some of all lights, from the one at a place on; the last is followed by the first."""
    return lights.roll(-first, 0)[:LIGHTS_PER_SURFACE]


def distillation_losses(bundle: NetworkBundle, table: ReflectionTable, batch: Batch) -> dict[str, torch.Tensor]:
    """Losses of the narrow pair on some of the lights of every example; the wide pair's answers are the truth.

    What the narrow SS network says goes on into the narrow composition, and learns from the picture, too.
    """
    flat = under_some_lights(batch)
    effects, losses = specular_shadow_losses(bundle.narrow.specular_shadow, table, flat)
    return losses | composition_losses(bundle.narrow.composition, table, flat, effects)[1]


def under_some_lights(batch: Batch) -> Batch:
    """Surfaces repeated for each of some lights drawn at random: (surfaces * lights, ...)."""
    count = batch["light"].shape[1]
    drawn = torch.randperm(count)[:_LIGHTS_PER_STEP]
    return {
        name: value[:, drawn.to(value.device)].flatten(0, 1)
        if value.ndim == 5
        else value.repeat_interleave(len(drawn), 0)
        for name, value in batch.items()
    }
