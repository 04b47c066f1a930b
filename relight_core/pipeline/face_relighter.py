"""One face of a photo: taken apart once, and put together at the networks' size under any light."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import torch

from relight_core.face.crop import Crop
from relight_core.face.parsing import INDEX
from relight_core.face.silhouette import person_with_headwear
from relight_core.imaging.colour import without_colour
from relight_core.imaging.joint_upsampling import JointUpsampler
from relight_core.imaging.light_change import LightChange
from relight_core.imaging.resampling import resize_area
from relight_core.lighting.environment import mean_luminance
from relight_core.lighting.lamps import Lamp
from relight_core.lighting.reflection import ReflectionTable
from relight_core.lighting.relief import ReliefTransport
from relight_core.lighting.roll import roll_light
from relight_core.networks.bundle import NetworkBundle
from relight_core.pipeline import stages
from relight_core.pipeline.cache import StageCache
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.model import light_surface
from relight_core.pipeline.per_light.hard_shadow import harden_shadow, horizon_of
from relight_core.pipeline.per_light.hints import Effects
from relight_core.pipeline.per_light.kept_lights import ServingLight
from relight_core.pipeline.per_light.residual import Residual, add_residual, find_residual
from relight_core.pipeline.per_light.sliders import soften_shadow, specular_gain
from relight_core.pipeline.per_photo.albedo import flatten_albedo
from relight_core.pipeline.per_photo.blown import skin_share
from relight_core.pipeline.per_photo.nearer_look import (
    nearer_view,
    with_nearer_change,
    with_nearer_effects,
    with_nearer_look,
)
from relight_core.pipeline.per_photo.outline import Outline, outline_person, parsing_within
from relight_core.pipeline.per_photo.portrait import Portrait
from relight_core.pipeline.per_photo.second_look import take_apart
from relight_core.pipeline.per_photo.source_light import explain_source_light
from relight_core.pipeline.plan import Plan, plan_of_own_light
from relight_core.pipeline.prepared import Lit, Prepared
from relight_core.pipeline.quality import Tier, tier_of
from relight_core.pipeline.results.channels import (
    LIGHT_CHANNELS,
    SURFACE_CHANNELS,
    ViewChange,
    as_image,
    as_tensor,
    enlarge_change,
    fit_view,
    light_channels,
    surface_channel,
    upsampler_for,
)
from relight_core.pipeline.results.face_level import MOST_STOPS, level_as_in_photo_ev

KEPT_LIGHTS = 24
"""Results of this many lights stay: a light that is turned there and back, or two that are compared."""

_KEPT_TIERS = 16
"""As many tiers may be compared side by side without any of them being prepared twice."""


@dataclass(frozen=True, eq=False)
class Workshop:
    """What all faces share: the networks, what open surfaces reflect, and where both live."""

    bundle: NetworkBundle
    table: ReflectionTable
    device: str

    def delight(self, photo_view: np.ndarray, tier: Tier) -> stages.Surface:
        """Take a view (S, S, 3) apart."""
        return take_apart(self.bundle, photo_view, tier, self.device)


class FaceRelighter:
    """The stages of one face, each result kept in a cache under what it was made from.

    Attributes:
        portrait: the photo and where the face is in it.
        cache: of this face alone.
        nearer: the same face in a view of little else; None where its own is near enough.
    """

    def __init__(self, workshop: Workshop, portrait: Portrait, cache: StageCache, *, outlined: bool = True):
        """Compute nothing yet.

        Args:
            outlined: the person network, where there is one, has a say in the parsing.
        """
        self.portrait = portrait
        self._shop = workshop
        self.cache = cache
        self._outlined = outlined
        nearer, self.nearer = nearer_view(portrait), None
        if nearer is not None:
            self.nearer = FaceRelighter(workshop, replace(portrait, view=nearer), StageCache(), outlined=False)

    @property
    def caches(self) -> tuple[StageCache, ...]:
        """Its own, and that of the nearer view."""
        return (self.cache,) if self.nearer is None else (self.cache, self.nearer.cache)

    def forget(self, stage: str | None = None) -> None:
        """Drop a stage's results, or all there are."""
        for cache in self.caches:
            cache.clear() if stage is None else cache.forget(stage)

    def _once(self, name: str, key: Hashable, make):
        """A stage that only a new photo or another quality makes run again."""
        return self.cache.run(name, key, make, "new photo or quality", keep=_KEPT_TIERS)

    def prepare(self, tier: Tier) -> Prepared:
        """The face as one tier of quality sees it."""
        photo, size = self.portrait.photo, tier.size
        photo_view = self._once("view", size, lambda: self.portrait.view.extract(photo.seen.linear, size))
        seen = photo_view
        if photo.monochrome:
            seen = self._once("seen_view", size, lambda: without_colour(photo_view))
        small = (tier.network_size, tier.network_size)
        photo_small = self._once("network_view", (size, tier.network_size), lambda: resize_area(seen, small))
        found = self._once("delight", tier.surface_key, lambda: self._within_outline(seen, tier))
        return Prepared(self.portrait, tier, found, found, photo_view, seen, photo_small)

    def _within_outline(self, photo_view: np.ndarray, tier: Tier) -> stages.Surface:
        found, outline = self._shop.delight(photo_view, tier), self.outline()
        if self.nearer is not None:
            seen_nearer = self.nearer.prepare(tier).found
            found = with_nearer_look(found, seen_nearer, self.portrait.view, self.nearer.portrait.view)
        if self.portrait.photo.monochrome:
            found = stages.without_colour(found)
        if outline is None:
            return found
        return stages.reparsed(found, parsing_within(found.parsing, outline, self.portrait.view))

    def mask(self) -> tuple[np.ndarray, Crop]:
        """Probability (S, S) of person, gaps between hair and shoulders left open, and the view it lies in."""
        parsing, view = self.prepare(tier_of("live")).found.parsing[0].cpu().numpy(), self.portrait.view
        outline = self.outline()
        if outline is None:
            return person_with_headwear(parsing), view
        whole = outline.corrected(1 - parsing[INDEX["background"]], view)
        return whole.likely, whole.view

    def outline(self) -> Outline | None:
        """The person as the person network sees them; None where there is no such network, or it isn't asked."""
        bundle, portrait = self._shop.bundle, self.portrait
        if bundle.person is None or not self._outlined:
            return None
        return self._once(
            "outline", "photo", lambda: outline_person(bundle, portrait.photo, portrait.crop, self._shop.device)
        )

    def flattened(self, ready: Prepared) -> Prepared:
        """The same with its albedo flattened (see `pipeline.per_photo.albedo`)."""
        relief, light = self._relief(ready), self._source_light(ready)
        surface = self._once("albedo", ready.tier.relief_key, lambda: flatten_albedo(ready.found, relief, light))
        return replace(ready, surface=surface)

    def _relief(self, ready: Prepared) -> ReliefTransport:
        return self._once("relief", ready.tier.relief_key, lambda: stages.march(ready.found, ready.tier.relief_size))

    def _source_light(self, ready: Prepared) -> torch.Tensor:
        relief = self._relief(ready)
        return self._once(
            "source_light",
            ready.tier.relief_key,
            lambda: explain_source_light(ready.found, self._reflector(ready), relief),
        )

    def own_light(self, tier: Tier) -> np.ndarray:
        """The source light (16, 32, 3) as the photo's camera sees it, so bright that model and photo agree."""
        ready = self.flattened(self.prepare(tier))
        level = self._residual(ready, plan_of_own_light(tier)).level
        return self.own_light_normalised(ready) * np.float32(level)

    def own_light_normalised(self, ready: Prepared) -> np.ndarray:
        """The source light (16, 32, 3) as the photo's camera sees it, of mean luminance 1."""
        light = roll_light(self._source_light(ready)[0].cpu().numpy(), -self.portrait.view.roll_deg)
        return light / np.float32(max(mean_luminance(light), 1e-12))

    def _residual(self, ready: Prepared, plan: Plan) -> Residual:
        """What the model, as far as the plan runs it, misses of the photo."""

        def compose(light: torch.Tensor) -> stages.Composed:
            relief = self._relief(ready) if plan.runs("relief") else None
            how = {"by_network": plan.shadow_network, "corrected": plan.runs("correction")}
            how |= {"precision": ready.tier.precision, "pair": ready.tier.pair}
            return light_surface(self._shop.bundle, self._reflector(ready), ready.surface, relief, light, **how)[2]

        source = self._source_light(ready)

        def find() -> Residual:
            recorded = as_tensor(ready.photo_small).to(self._shop.device)
            return find_residual(ready.surface, recorded, source, compose)

        return self._once("residual", plan.keys["residual"], find)

    def prepared_and_lit(self, tier: Tier, serving: ServingLight, plan: Plan) -> tuple[Prepared, Lit]:
        """The face as a tier sees it, flattened where the plan says so, and the same under a light."""
        ready = self.prepare(tier)
        ready = self.flattened(ready) if plan.runs("flattening") else ready
        return ready, self.lit(ready, serving, plan)

    def lit(self, ready: Prepared, serving: ServingLight, plan: Plan) -> Lit:
        """The face under a normalised light, as the photo's camera sees it."""
        turned = roll_light(serving.radiance, self.portrait.view.roll_deg)
        light = torch.from_numpy(turned)[None].to(self._shop.device)
        reflected = self.cache.run(
            "irradiance",
            plan.keys["irradiance"],
            lambda: stages.reflect(self._reflector(ready), light),
            "new light",
        )
        effects = self._effects(ready, reflected, light, plan)
        if plan.runs("hard_shadow") and plan.runs("relief"):
            effects = self._hardened(ready, effects, reflected, light, serving.lamps, plan)
        composed = self.cache.run(
            "compose",
            plan.keys["compose"],
            lambda: stages.compose(
                self._shop.bundle,
                ready.surface,
                reflected,
                effects,
                light,
                self._shop.device,
                corrected=plan.runs("correction"),
                parts=(plan.runs("specular"), plan.runs("shadow")),
                precision=ready.tier.precision,
                pair=ready.tier.pair,
            ),
            "new light",
            keep=KEPT_LIGHTS,
        )
        return Lit(light, reflected, effects, composed, self._lit_nearer(ready.tier, serving, plan))

    def _lit_nearer(self, tier: Tier, serving: ServingLight, plan: Plan) -> tuple[Prepared, Lit] | None:
        """The nearer view under the same light, where there is one and the tier has time for it."""
        nearer = self.nearer
        if nearer is None or not tier.lights_nearer:
            return None

        light = partial(nearer.prepared_and_lit, tier, serving, plan)
        return self.cache.run("nearer_face", plan.keys["compose"], light, "new light", keep=KEPT_LIGHTS)

    def _effects(self, ready: Prepared, reflected: torch.Tensor, light: torch.Tensor, plan: Plan) -> Effects:
        """Specular and shadow; none where the plan has neither."""
        if not (plan.runs("shadow") or plan.runs("specular")):
            self.cache.skip("specular_shadow", plan.effect("shadow").why)
            return stages.no_effects(ready.surface)
        relief = self._relief(ready) if plan.runs("relief") else None
        return self.cache.run(
            "specular_shadow",
            plan.keys["specular_shadow"],
            lambda: stages.estimate_effects(
                self._shop.bundle,
                ready.surface,
                reflected,
                relief,
                light,
                self._shop.device,
                by_network=plan.shadow_network,
                precision=ready.tier.precision,
                pair=ready.tier.pair,
                begun=self._begun(ready) if plan.shadow_network else None,
            ),
            "new light",
            keep=KEPT_LIGHTS,
        )

    def _hardened(
        self,
        ready: Prepared,
        effects: Effects,
        reflected: torch.Tensor,
        light: torch.Tensor,
        lamps: tuple[Lamp, ...],
        plan: Plan,
    ) -> Effects:
        """The effects with the edges of small lamps' shadows."""
        seen = [lamp.rolled(self.portrait.view.roll_deg) for lamp in lamps]
        relief = self._relief(ready)
        horizon = self._once("horizon", ready.tier.surface_key, lambda: horizon_of(ready.found))
        return self.cache.run(
            "hard_shadow",
            plan.keys["hard_shadow"],
            lambda: harden_shadow(effects, ready.surface, reflected, light, relief, horizon, seen),
            "new light",
            keep=KEPT_LIGHTS,
        )

    def _begun(self, ready: Prepared) -> torch.Tensor:
        shop, tier = self._shop, ready.tier
        how = {"precision": tier.precision, "pair": tier.pair}
        make = lambda: stages.begin_effects(shop.bundle, ready.found, shop.device, **how)  # noqa: E731
        return self._once("begun", tier.begun_key, make)

    def _reflector(self, ready: Prepared) -> stages.Reflector:
        make = lambda: stages.reflector(self._shop.table, ready.found)  # noqa: E731
        return self._once("normals", ready.tier.surface_key, make)

    def change(self, ready: Prepared, lit: Lit, plan: Plan, edit: Edit, level: float) -> ViewChange:
        """How the relit view differs from the photo's, at the sliders' gains and the light's level."""
        fit = self.cache.run("detail_fit", plan.keys["detail_fit"], lambda: self._fit(ready, lit, plan), "new light")
        moved = None
        if plan.runs("sliders"):
            specular = specular_gain(edit.specular * plan.runs("specular"), edit.specular_tint, self._shop.device)
            effects = soften_shadow(lit.effects, ready.surface, lit.reflected, edit.shadow_softness)
            shadow = edit.shadow * plan.runs("shadow")
            moved = stages.move_sliders(lit.composed, ready.surface, lit.reflected, effects, specular, shadow)
        change = enlarge_change(fit, moved, self._upsampler(ready), level)
        if lit.nearer is not None:
            from_near = self.nearer.change(*lit.nearer, plan, edit, level)
            change = with_nearer_change(change, from_near, self.portrait.view, self.nearer.portrait.view)
        return change.toned(ready.photo_view) if self.portrait.photo.monochrome else change

    def level_as_in_photo_ev(self, ready: Prepared, change: ViewChange, most_stops: float = MOST_STOPS) -> float:
        """See `pipeline.results.face_level`."""
        skin = skin_share(ready.surface.parsing)[0, 0].cpu().numpy()
        return level_as_in_photo_ev(ready.photo_view, change, skin, most_stops)

    def _fit(self, ready: Prepared, lit: Lit, plan: Plan) -> LightChange:
        """The relit view as gain and offset of the photo; without detail, offset only."""
        image, effects = lit.composed.image, lit.effects
        if plan.runs("residual"):
            image, effects = add_residual(self._residual(ready, plan), lit.composed, effects, lit.light)
        if plan.runs("detail"):
            return fit_view(ready.photo_small, ready.surface, lit.reflected, effects, image)
        relit = as_image(image)
        nothing = np.zeros_like(relit)
        return LightChange(nothing, relit, nothing, nothing + 1)

    def _upsampler(self, ready: Prepared) -> JointUpsampler:
        sizes = ready.tier.size, ready.tier.network_size
        return self._once("edges", sizes, lambda: upsampler_for(ready.seen, ready.photo_small))

    def channels(self, ready: Prepared, lit: Lit, change: ViewChange, plan: Plan, edit: Edit) -> dict:
        """The channels that are looked at, all but "target_light"."""
        if not plan.runs("channels"):
            self.cache.skip("channels", plan.effect("channels").why)
            return {}
        fixed = {
            name: self._once(f"{name}_channel", plan.keys["surface"], partial(self._surface_channel, name, ready))
            for name in SURFACE_CHANNELS
            if edit.looks_at(name)
        }
        if plan.runs("source_light") and edit.looks_at("source_light"):
            fixed["source_light"] = self.own_light(ready.tier)
        # Behind the person the networks see no surface, and what they say there is no part of the picture.
        specular, shadow = (ready.surface.person * plan.runs(name) for name in ("specular", "shadow"))
        effects = lit.effects
        if lit.nearer is not None:
            views = self.portrait.view, self.nearer.portrait.view
            effects = with_nearer_effects(effects, lit.nearer[1].effects, *views)
        shown = Effects(effects.specular * specular, effects.shadow * shadow)
        lighted = self.cache.run(
            "channels",
            plan.keys["channels"],
            lambda: light_channels(
                shown, change, ready.photo_view, [name for name in LIGHT_CHANNELS if edit.looks_at(name)]
            ),
            "new light or slider",
        )
        return fixed | lighted

    @staticmethod
    def _surface_channel(name: str, ready: Prepared) -> np.ndarray:
        view = ready.photo_view if name == "photo" else ready.seen
        return surface_channel(name, ready.surface, view, ready.photo_small)
