"""One face of a photo in the light the photo was taken in, which the photo's other faces stand in as well."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch

from relight_core.imaging.half_floats import within_halves
from relight_core.imaging.tensor_images import as_tensor, resized
from relight_core.lighting.panorama import normalise_light
from relight_core.lighting.roll import roll_light
from relight_core.pipeline import stages
from relight_core.pipeline.company import Company
from relight_core.pipeline.face_taken_apart import FaceTakenApart
from relight_core.pipeline.model import ReadySurface, light_surface
from relight_core.pipeline.per_light.residual import Residual, at_light_level, find_residual
from relight_core.pipeline.per_photo.albedo import flatten_albedo
from relight_core.pipeline.per_photo.foreign_shadow import without_shadow
from relight_core.pipeline.per_photo.source_light import explain_source_light, exposure_of_photo
from relight_core.pipeline.plan import Plan, plan_of_own_light
from relight_core.pipeline.prepared import Prepared
from relight_core.pipeline.quality import Tier

_KNOWN_ALONE = (
    *("view", "seen_view", "network_view", "delight", "outline", "wider_outline", "corneas"),
    *("normals", "relief", "source_light", "begun", "lamps_view", "edges", "eye_skies"),
)
"""Stages that read nothing of the photo's other faces."""


class FaceInPhoto(FaceTakenApart):
    """A face that is taken apart, and the light that its photo was taken in; one of a `company`, or alone."""

    _company: Company | None = None

    def join(self, company: Company | None) -> None:
        """Share the light with the photo's other faces; None for nobody's company."""
        before, after = (one.faces if one else () for one in (self._company, company))
        self._company = company
        if before != after:
            self.cache.keep_only(_KNOWN_ALONE)
        if self.nearer is not None:
            self.nearer.join(company)

    def flattened(self, ready: Prepared) -> Prepared:
        """The same with its albedo flattened (see `pipeline.per_photo.albedo`), and as bright as beside the others."""
        relief, light = self._relief(ready), self._source_light(ready)

        def flatten() -> stages.Surface:
            surface = flatten_albedo(ready.found, relief, light, stages.reflect(self._reflector(ready), light))
            gain = self._company.albedo_gain(self, ready.tier) if self._company else 1.0
            return replace(surface, albedo=(gain * surface.albedo).clamp(0, 1))

        return replace(ready, surface=self._once("albedo", ready.tier.relief_key, flatten))

    def _source_light(self, ready: Prepared) -> torch.Tensor:
        """The photo's light (1, 16, 32, 3) as this view sees it; a nearer view stands in the light of its face.

        It has been turned into the camera's view and back, as any light has that is served: turned once less it would
        be sharper than the photo's own light when that is the target, and not make the photo again.
        """
        tier = ready.tier
        if self.wider is not None:
            return self.wider._source_light(self.wider.prepare(tier))
        return self._once("served_light", tier.relief_key, lambda: self._turned(self.own_light_normalised(ready)))

    def _estimate(self, ready: Prepared) -> torch.Tensor:
        relief = self._relief(ready)
        return self._once(
            "source_light",
            ready.tier.relief_key,
            lambda: explain_source_light(ready.found, self._reflector(ready), relief),
        )

    def estimate(self, tier: Tier) -> np.ndarray:
        """See `company.Member`."""
        return self._as_the_camera_sees(self._estimate(self.prepare(tier)))

    def exposure(self, tier: Tier) -> float:
        """See `company.Member`."""
        ready = self.prepare(tier)

        def expose() -> float:
            seen = exposure_of_photo(ready.found, stages.reflect(self._reflector(ready), self._source_light(ready)))
            return seen / self.portrait.exposure

        return self._once("exposure", tier.relief_key, expose)

    def model_level(self, tier: Tier, plan: Plan) -> float:
        """See `company.Member`."""
        ready = self.prepare(tier)
        alone = self._residual_alone(self.flattened(ready) if plan.runs("flattening") else ready, plan)
        return alone.level / self.portrait.exposure

    def _turned(self, light: np.ndarray) -> torch.Tensor:
        """A light (16, 32, 3) as the camera sees it, (1, 16, 32, 3) as this view does."""
        return torch.from_numpy(roll_light(light, self.portrait.view.roll_deg))[None].to(self._shop.device)

    def _as_the_camera_sees(self, light: torch.Tensor) -> np.ndarray:
        """A light (1, 16, 32, 3) as this view sees it, (16, 32, 3) and of mean luminance 1."""
        return normalise_light(roll_light(light[0].cpu().numpy(), -self.portrait.view.roll_deg))

    def own_light(self, tier: Tier) -> np.ndarray:
        """The source light (16, 32, 3) as the photo's camera sees it, so bright that model and photo agree."""
        ready = self.flattened(self.prepare(tier))
        level = self._residual(ready, plan_of_own_light(tier)).level
        return self.own_light_normalised(ready) * np.float32(level / self.portrait.exposure)

    def own_light_normalised(self, ready: Prepared) -> np.ndarray:
        """The source light (16, 32, 3) as the photo's camera sees it, of mean luminance 1."""
        return self._company.light(ready.tier) if self._company else self.estimate(ready.tier)

    def _residual(self, ready: Prepared, plan: Plan) -> Residual:
        """What the model, as far as the plan runs it, misses of the photo.

        A nearer view's is at the level of its face, or the photo's own light would not make both the photo again.
        """
        alone, face = self._residual_alone(ready, plan), self.wider or self
        if face is self and self._company is None and ready.tier.level_of is None:
            return alone
        level = lambda: at_light_level(alone, face._level(ready.tier, plan) * self.portrait.exposure)  # noqa: E731
        return self._once("residual_in_company", plan.keys["residual"], level)

    def _level(self, tier: Tier, plan: Plan) -> float:
        """The level of the light at which model and photo agree, by the model of the tier that has the say."""
        if tier.level_of is not None:
            tier, plan = tier.level_of, plan_of_own_light(tier.level_of)
        return self._company.level(tier, plan) if self._company else self.model_level(tier, plan)

    def _residual_alone(self, ready: Prepared, plan: Plan) -> Residual:
        def compose(light: torch.Tensor) -> stages.Composed:
            relief = self._relief(ready) if plan.runs("relief") else None
            networks = self._shop.pair(ready.tier)
            occluding = networks if plan.shadow_network else None
            composing = networks if plan.runs("correction") else None
            surface = ReadySurface(ready.surface, self._reflector(ready), relief)
            return light_surface(surface, light, occluding, composing).composed

        source = self._source_light(ready)

        def find() -> Residual:
            recorded = as_tensor(within_halves(ready.photo_small), self._shop.device)
            shadow = ready.found.foreign_shadow
            if shadow is None:
                return find_residual(ready.surface, recorded, source, compose)
            shadow = resized(shadow, ready.tier.network_size)
            residual = find_residual(ready.surface, without_shadow(recorded, shadow), source, compose)
            return replace(residual, foreign_shadow=shadow)

        return self._once("residual", plan.keys["residual"], find)
