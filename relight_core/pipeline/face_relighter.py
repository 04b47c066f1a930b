"""One face of a photo: taken apart once, and put together at the networks' size under any light."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import torch

from relight_core.face.parsing import skin_share
from relight_core.imaging.joint_upsampling import JointUpsampler
from relight_core.imaging.light_change import LightChange
from relight_core.imaging.photo import with_black
from relight_core.imaging.tensor_images import as_image, enlarge
from relight_core.imaging.view_of_photo import ViewOfPhoto
from relight_core.lighting.environment import Environment, network_light
from relight_core.lighting.lamps import Lamp
from relight_core.pipeline import stages
from relight_core.pipeline.edit import LIGHT_CHANNELS, Edit
from relight_core.pipeline.face_in_photo import FaceInPhoto
from relight_core.pipeline.per_light.catchlights import (
    Catchlight,
    EyeSky,
    difference_of_lights,
    light_about,
    mirrored_light,
    sky_over,
    unoccluded,
)
from relight_core.pipeline.per_light.fine_edges import FineEdges, draw_finely
from relight_core.pipeline.per_light.hard_shadow import harden_shadow, ready_for_lamps
from relight_core.pipeline.per_light.hints import Effects
from relight_core.pipeline.per_light.kept_lights import ServingLight
from relight_core.pipeline.per_light.residual import add_residual
from relight_core.pipeline.per_light.sliders import move_sliders, soften_shadow, specular_gain
from relight_core.pipeline.per_photo.nearer_look import with_nearer_change, with_nearer_effects
from relight_core.pipeline.plan import Plan
from relight_core.pipeline.prepared import Lit, Prepared
from relight_core.pipeline.quality import Tier
from relight_core.pipeline.results.channels import (
    ViewChange,
    effect_channels,
    enlarge_change,
    fit_view,
    light_channels,
    of_person,
    surface_channel,
    surface_channels_of,
    upsampler_for,
    view_as_seen,
)
from relight_core.pipeline.results.face_level import MOST_STOPS, level_as_in_photo_ev

KEPT_LIGHTS = 24
"""Results of this many lights stay: a light that is turned there and back, or two that are compared."""

_MOVED_AND_AT_REST = 2
"""Of what is quickly found for a light: one for the hand that moves a slider, one for the picture at rest."""


class FaceRelighter(FaceInPhoto):
    """All stages of one face, under any light."""

    def prepared_and_lit(self, tier: Tier, serving: ServingLight, plan: Plan) -> tuple[Prepared, Lit]:
        """The face as a tier sees it, flattened where the plan says so, and the same under a light."""
        ready = self._ready(tier, plan)
        return ready, self.lit(ready, serving, plan)

    def _ready(self, tier: Tier, plan: Plan) -> Prepared:
        ready = self.prepare(tier)
        return self.flattened(ready) if plan.runs("flattening") else ready

    def get_ready(self, tier: Tier, plan: Plan) -> None:
        """Find what a plan needs to know of the face once, under whatever light."""
        ready = self._ready(tier, plan)
        if plan.shadow_network:
            self._begun(ready)
        if plan.runs("residual"):
            self._residual(ready, plan)
        self._upsampler(ready)
        if plan.runs("detail"):
            self._view_of_photo(ready, plan)
        if self.nearer is not None and tier.lights_nearer:
            self.nearer.get_ready(tier, plan)

    def lit(self, ready: Prepared, serving: ServingLight, plan: Plan) -> Lit:
        """The face under a normalised light, as the photo's camera sees it."""
        light = self._turned(serving.radiance)
        reflected = self.cache.run(
            "irradiance",
            plan.keys["irradiance"],
            lambda: stages.reflect(self._reflector(ready), light),
            "new light",
            keep=_MOVED_AND_AT_REST,
        )
        effects = self._effects(ready, reflected, light, plan)
        if plan.runs("hard_shadow") and plan.runs("relief"):
            effects = self._hardened(ready, effects, reflected, light, serving.lamps, plan)
        composed = self.cache.run(
            "compose",
            plan.keys["compose"],
            lambda: stages.compose(
                self._shop.pair(ready.tier) if plan.runs("correction") else None,
                ready.surface,
                reflected,
                effects,
                light,
                parts=(plan.runs("specular"), plan.runs("shadow")),
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
                self._shop.pair(ready.tier) if plan.shadow_network else None,
                ready.surface,
                reflected,
                relief,
                light,
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
        reflect = partial(stages.reflect, self._reflector(ready))
        make = partial(ready_for_lamps, ready.found, self._relief(ready), reflect, self.portrait.view.roll_deg)
        view = self._once("lamps_view", ready.tier.relief_key, make)
        return self.cache.run(
            "hard_shadow",
            plan.keys["hard_shadow"],
            lambda: harden_shadow(effects, ready.surface, reflected, light, view, lamps),
            "new light",
            keep=KEPT_LIGHTS,
        )

    def _begun(self, ready: Prepared) -> torch.Tensor:
        make = lambda: stages.begin_effects(self._shop.pair(ready.tier), ready.found)  # noqa: E731
        return self._once("begun", ready.tier.begun_key, make)

    def change(self, ready: Prepared, lit: Lit, plan: Plan, edit: Edit, level: float) -> ViewChange:
        """How the relit view differs from the photo's, at the sliders' gains and the light's level."""
        make_fit = partial(self._fit, ready, lit, plan)
        fit = self.cache.run("detail_fit", plan.keys["detail_fit"], make_fit, "new light", keep=_MOVED_AND_AT_REST)
        gains = plan.gains(edit)
        moved, shadow = None, gains.shadow * plan.runs("shadow")
        if plan.runs("sliders"):
            specular = specular_gain(gains.specular * plan.runs("specular"), gains.specular_tint, self._shop.device)
            effects = soften_shadow(lit.effects, ready.surface, lit.reflected, gains.shadow_softness)
            moved = move_sliders(lit.composed, ready.surface, lit.reflected, effects, specular, shadow)
            moved = None if moved.is_none else moved
        fine = self._fine_edges(ready, lit, plan)
        edges = None if fine is None else fine.gain(shadow, gains.shadow_softness)
        change = enlarge_change(fit, moved, self._upsampler(ready), level, edges)
        change = change.of_photo_times(self.portrait.exposure)
        if lit.nearer is not None:
            from_near = self.nearer.change(*lit.nearer, plan, edit, level)
            change = with_nearer_change(change, from_near, self.portrait.view, self.nearer.portrait.view)
        if not self.portrait.monochrome:
            return change
        exposure = self.portrait.exposure
        return change.toned(ready.photo_view * np.float32(exposure), self.portrait.photo.tone_at(exposure))

    def _fine_edges(self, ready: Prepared, lit: Lit, plan: Plan) -> FineEdges | None:
        """The edges of small lamps' shadows at the view's size; None where there are none."""
        edges = lit.effects.edges
        if edges is None:
            return None
        fitted = plan.runs("detail")
        evened = self._view_of_photo(ready, plan).evened if fitted else np.asarray
        draw = lambda: draw_finely(edges, self._upsampler(ready), evened)  # noqa: E731
        return self.cache.run(
            "fine_edges", (plan.keys["hard_shadow"], fitted), draw, "new light", keep=_MOVED_AND_AT_REST
        )

    def catchlights(
        self, ready: Prepared, lit: Lit, plan: Plan, environment: Environment, yaw_deg: float
    ) -> tuple[Catchlight, ...]:
        """What the eyes mirror of a light, whatever its level and the sliders."""
        corneas = self.corneas()
        if not corneas:
            return ()
        eyes = [unoccluded(lit.light)] * len(corneas)
        if plan.runs("shadow") and plan.runs("relief"):
            of_light = ready.surface, lit.effects, lit.reflected, lit.light
            eyes = [light_about(sky, *of_light) for sky in self._skies(ready)]
        replaces = difference_of_lights(network_light(environment, yaw_deg), self.own_light_normalised(ready))
        seen = [mirrored_light(*eye, environment, yaw_deg) for eye in zip(corneas, eyes, strict=True)]
        return tuple(Catchlight(*parts, replaces) for parts in zip(corneas, seen, strict=True))

    def _skies(self, ready: Prepared) -> list[EyeSky]:
        of_view = self.portrait.view, self._relief(ready), ready.surface.normal.shape[-1]
        make = lambda: [sky_over(cornea, *of_view) for cornea in self.corneas()]  # noqa: E731
        return self._once("eye_skies", ready.tier.relief_key, make)

    def level_as_in_photo_ev(self, ready: Prepared, change: ViewChange, most_stops: float = MOST_STOPS) -> float:
        """See `pipeline.results.face_level`."""
        skin = skin_share(ready.surface.parsing)[0, 0].cpu().numpy()
        return level_as_in_photo_ev(ready.photo_view, change, skin, most_stops, self.portrait.exposure)

    def _fit(self, ready: Prepared, lit: Lit, plan: Plan) -> LightChange:
        """The relit view as gain and offset of the photo; without detail, offset only."""
        image, effects = lit.composed.image, lit.effects
        if plan.runs("residual"):
            image, effects = add_residual(self._residual(ready, plan), lit.composed, effects, lit.light)
        if plan.runs("detail"):
            return fit_view(self._view_of_photo(ready, plan), lit.reflected, effects, image)
        relit = as_image(image)
        nothing = np.zeros_like(relit)
        return LightChange(nothing, relit, nothing, nothing + 1)

    def _view_of_photo(self, ready: Prepared, plan: Plan) -> ViewOfPhoto:
        # The stage's name is one that programs read (docs/command-line.md, JSON).
        return self._once("makeup", plan.keys["surface"], lambda: view_as_seen(ready.photo_small, ready.surface))

    def _upsampler(self, ready: Prepared) -> JointUpsampler:
        sizes = ready.tier.surface_key, ready.tier.size, ready.tier.network_size
        return self._once("edges", sizes, lambda: upsampler_for(ready.seen, ready.photo_small, ready.surface))

    def channels(self, ready: Prepared, lit: Lit, change: ViewChange, plan: Plan, edit: Edit) -> dict:
        """The channels that are looked at, all but "target_light"."""
        if not plan.runs("channels"):
            self.cache.skip("channels", plan.effect("channels").why)
            return {}
        fixed = {
            name: self._once(f"{name}_channel", plan.keys["surface"], partial(self._surface_channel, name, ready))
            for name in surface_channels_of(ready.surface)
            if edit.looks_at(name)
        }
        if plan.runs("source_light") and edit.looks_at("source_light"):
            fixed["source_light"] = self.own_light(ready.tier)
        lighted = self._light_channels(ready, lit, change, plan, edit)
        return fixed | self.cache.run("channels", plan.keys["channels"], lighted, "new light or slider")

    def channels_later(
        self, ready: Prepared, lit: Lit, change: ViewChange, plan: Plan, edit: Edit
    ) -> Callable[[], dict[str, np.ndarray]]:
        """What makes the channels that are looked at, all but the photo and the lights, on any thread."""
        lighted = self._light_channels(ready, lit, change, plan, edit)
        there = surface_channels_of(ready.surface)
        names = [name for name in there if name != "photo" and edit.looks_at(name)]
        return lambda: {name: self._surface_channel(name, ready) for name in names} | lighted()

    def _light_channels(
        self, ready: Prepared, lit: Lit, change: ViewChange, plan: Plan, edit: Edit
    ) -> Callable[[], dict[str, np.ndarray]]:
        """What makes those of LIGHT_CHANNELS that are looked at; it asks no cache for anything."""
        effects = self._effect_channels(ready, lit, plan)
        names = [name for name in LIGHT_CHANNELS if edit.looks_at(name)]

        def make() -> dict[str, np.ndarray]:
            channels = light_channels(effects(), change, ready.photo_view, names)
            if "composition" in channels:
                channels["composition"] = with_black(channels["composition"], self.portrait.photo.black)
            return channels

        return make

    def _effect_channels(self, ready: Prepared, lit: Lit, plan: Plan) -> Callable[[], dict[str, np.ndarray]]:
        """What makes the channels of the effects that the plan has, of the person alone, as albedo and normals are."""
        size, edges = ready.photo_view.shape[0], self._fine_edges(ready, lit, plan)
        near_edges = None if lit.nearer is None else self.nearer._fine_edges(*lit.nearer, plan)

        def make() -> dict[str, np.ndarray]:
            effects = effect_channels(lit.effects, size, edges)
            if lit.nearer is not None:
                from_near = effect_channels(lit.nearer[1].effects, size, near_edges)
                effects = with_nearer_effects(effects, from_near, self.portrait.view, self.nearer.portrait.view)
            person = as_image(enlarge(ready.surface.person, size))
            return {name: effect * person * plan.runs(name) for name, effect in effects.items()}

        return make

    def _surface_channel(self, name: str, ready: Prepared) -> np.ndarray:
        view = with_black(ready.photo_view, self.portrait.photo.black) if name == "photo" else ready.seen
        channel = surface_channel(name, ready.surface, view, ready.photo_small)
        return of_person(channel, ready.surface) if name in ("albedo", "normal") else channel
