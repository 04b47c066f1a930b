"""One held-out head through the editor's stages, every result beside the true one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
import torch

from relight_core.evaluation.held_out import Case, HeldOutHead, HeldOutLight, Photos
from relight_core.evaluation.scoring import (
    Figures,
    score_effects,
    score_relit,
    score_surface,
    score_unchanged,
)
from relight_core.evaluation.true_surface import true_surface
from relight_core.face.parsing import FACE_LABELS
from relight_core.imaging.resampling import resize_area
from relight_core.imaging.tensor_images import as_image
from relight_core.imaging.view_of_photo import ViewOfPhoto
from relight_core.lighting.lamps import Lamp
from relight_core.lighting.panorama import normalise_light
from relight_core.lighting.reflection import ReflectionTable
from relight_core.lighting.relief import ReliefTransport
from relight_core.networks.bundle import NetworkBundle
from relight_core.pipeline import stages
from relight_core.pipeline.model import ReadySurface, light_surface
from relight_core.pipeline.per_light.fine_edges import draw_finely
from relight_core.pipeline.per_light.hard_shadow import ready_for_lamps
from relight_core.pipeline.per_light.residual import Residual, add_residual, find_residual
from relight_core.pipeline.per_photo.albedo import flatten_albedo
from relight_core.pipeline.per_photo.second_look import take_apart
from relight_core.pipeline.per_photo.source_light import explain_source_light
from relight_core.pipeline.prepared import Lit
from relight_core.pipeline.quality import Tier
from relight_core.pipeline.results.channels import (
    effect_channels,
    enlarge_change,
    fit_view,
    light_channels,
    surface_channels,
    upsampler_for,
    view_as_seen,
)

_WHOLE_PIXEL = 0.99


@dataclass(frozen=True)
class DelitPhoto:
    """A photo and what de-lighting found in it, or is told about it.

    Attributes:
        photo: (S, S, 3) linear, [0, 1].
        small: the same at the networks' size.
        surface: at the networks' size.
        light: (1, 16, 32, 3) the photo's own, at the photo's exposure.
    """

    photo: np.ndarray
    small: np.ndarray
    surface: stages.Surface
    light: torch.Tensor
    reflector: stages.Reflector
    relief: ReliefTransport


@dataclass(frozen=True)
class ReadyPhoto:
    """What was seen, made ready for any light."""

    seen: DelitPhoto
    surface: ReadySurface
    residual: Residual

    @cached_property
    def view(self) -> ViewOfPhoto:
        """The photo's view at the networks' size."""
        return view_as_seen(self.seen.small, self.seen.surface)

    @cached_property
    def channels(self) -> Mapping[str, np.ndarray]:
        """The surface's channels at the photo's size; the network's light and the explained one."""
        seen = self.seen
        lights = {"guess": seen.surface.source_light, "source_light": seen.light}
        return surface_channels(seen.surface, seen.photo, seen.small) | {
            name: light[0].cpu().numpy() for name, light in lights.items()
        }


@dataclass(frozen=True)
class Editor:
    """The stages as the Relighter ties them, for a photo that is all view."""

    bundle: NetworkBundle
    table: ReflectionTable
    tier: Tier
    device: str

    def take_apart(self, photo: np.ndarray) -> ReadyPhoto:
        """De-light a photo (S, S, 3), linear, and make it ready."""
        return self.ready(self.look(photo))

    def look(self, photo: np.ndarray) -> DelitPhoto:
        """De-light a photo and explain its light."""
        small = resize_area(photo, (self.tier.network_size, self.tier.network_size))
        found = take_apart(self.bundle, photo, self.tier, self.device)
        relief, reflector = stages.march(found, self.tier.relief_size), stages.reflector(self.table, found)
        light = explain_source_light(found, reflector, relief)
        # The editor asks for the albedo in a light of mean luminance 1, whatever the photo's exposure.
        served = torch.from_numpy(normalise_light(light[0].cpu().numpy()))[None].to(self.device)
        surface = flatten_albedo(found, relief, served, stages.reflect(reflector, served))
        return DelitPhoto(photo, small, surface, light, reflector, relief)

    def told(self, seen: DelitPhoto, surface: stages.Surface, light: torch.Tensor) -> DelitPhoto:
        """The same photo with another surface, or its own, and another light."""
        if surface is seen.surface:
            return replace(seen, light=light)
        relief, reflector = stages.march(surface, self.tier.relief_size), stages.reflector(self.table, surface)
        return replace(seen, surface=surface, light=light, reflector=reflector, relief=relief)

    def ready(self, seen: DelitPhoto) -> ReadyPhoto:
        """What is left to do before any light can be asked for."""
        surface, light = seen.surface, seen.light
        ready = ReadySurface(surface, seen.reflector, seen.relief)
        residual = find_residual(surface, surface.photo, light, lambda own: self.light(ready, own).composed)
        lamps_view = ready_for_lamps(surface, seen.relief, partial(stages.reflect, seen.reflector))
        return ReadyPhoto(seen, replace(ready, lamps_view=lamps_view), residual)

    def light(self, surface: ReadySurface, light: torch.Tensor, lamps: Sequence[Lamp] = ()) -> Lit:
        """`light_surface` by the networks that the tier runs."""
        networks = stages.pair_of(self.bundle, self.tier, self.device)
        occluding = networks if self.tier.shadow_network else None
        composing = networks if self.tier.correction else None
        return light_surface(surface, light, occluding, composing, lamps)

    def relight(self, found: ReadyPhoto, target: HeldOutLight) -> dict[str, np.ndarray]:
        """The channels "specular", "shadow" and "composition" at the photo's size."""
        light, seen = torch.from_numpy(target.radiance)[None].to(self.device), found.seen
        lit = self.light(found.surface, light, target.small_lamps)
        effects = lit.effects
        image, shown = add_residual(found.residual, lit.composed, effects, light)
        fit = fit_view(found.view, lit.reflected, shown, image)
        upsample = upsampler_for(seen.photo, seen.small, seen.surface)
        fine = None if effects.edges is None else draw_finely(effects.edges, upsample, found.view.evened)
        change = enlarge_change(fit, None, upsample, 1.0, None if fine is None else fine.gain(1.0, 0.0))
        return light_channels(effect_channels(effects, len(seen.photo), fine), change, seen.photo)


def masks_of(head: HeldOutHead, target: HeldOutLight) -> dict[str, np.ndarray]:
    """The pixels (S, S) that count, by the group of figures that a relighting of a head adds to."""
    covered = head.lit.head.covered
    if target.lamp:
        return {"lamps": covered}
    face = covered & np.isin(head.surface()["label"], FACE_LABELS)
    return {"panoramas": covered} | ({"face": face} if face.any() else {})


class Bench:
    """One head under test; a photo is taken apart once, however many lights it is relit with."""

    def __init__(self, editor: Editor, head: HeldOutHead, lights: list[HeldOutLight], photos: Photos):
        self._editor, self._head, self._lights, self._photos = editor, head, lights, photos
        self._truth, self._covered = head.surface(), head.lit.head.covered
        self._found: dict[int, ReadyPhoto] = {}
        perfect = true_surface(head, lights[0], editor.tier.network_size, editor.device)
        relief, reflector = stages.march(perfect, editor.tier.relief_size), stages.reflector(editor.table, perfect)
        self._perfect = ReadySurface(perfect, reflector, relief)

    def score(self, case: Case) -> dict[str, Figures]:
        """Figures of one relighting, by group (see `Evaluation.figures`)."""
        if case.source not in self._found:
            photo = self._head.photo(case.source, self._photos)
            self._found[case.source] = self._editor.take_apart(photo)
        found, target = self._found[case.source], self._lights[case.target]
        truth, exposure = self._head.channels(case.target), self._head.exposure(case.target)
        relit = self._editor.relight(found, target)
        light = self._lights[case.source].radiance
        figures = {
            name: score_surface(found.channels, light, self._truth, mask)
            | score_effects(relit, truth, mask)
            | score_relit(relit["composition"], truth["image"], exposure, self._covered, mask)
            | score_unchanged(found.seen.photo, truth["image"], exposure, self._covered, mask)
            for name, mask in masks_of(self._head, target).items()
        }
        group = "lamps" if target.lamp else "panoramas"
        return figures | {f"true surface, {group}": self._score_from_truth(target.radiance, truth, exposure)}

    def _score_from_truth(self, radiance: np.ndarray, truth: dict[str, np.ndarray], exposure: float) -> Figures:
        """SS and composition alone, from the true surface, at the networks' size."""
        light = torch.from_numpy(radiance)[None].to(self._editor.device)
        lit = self._editor.light(self._perfect, light)
        image = as_image(lit.composed.image)
        small = {name: self._shrunk(truth[name]) for name in ("image", "specular", "shadow")}
        covered = self._shrunk(self._covered.astype(np.float32)) > _WHOLE_PIXEL
        estimated = {"specular": as_image(lit.effects.specular), "shadow": as_image(lit.effects.shadow)}
        return score_effects(estimated, small, covered) | score_relit(image, small["image"], exposure, covered, covered)

    def _shrunk(self, image: np.ndarray) -> np.ndarray:
        return resize_area(image, (self._editor.tier.network_size,) * 2)
