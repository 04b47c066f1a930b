"""The Relighter: a portrait is set once, slowly, and relit many times, quickly."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import torch

from relight_core.errors import InputError
from relight_core.face.find import FaceBox
from relight_core.imaging.joint_upsampling import JointUpsampler
from relight_core.imaging.light_change import LightChange
from relight_core.imaging.matte import refine_matte
from relight_core.imaging.photo import Photo
from relight_core.imaging.resampling import resize_area
from relight_core.lighting.background import panorama_background
from relight_core.lighting.environment import Environment, mean_luminance, network_light
from relight_core.lighting.reflection import ReflectionTable
from relight_core.lighting.relief import ReliefTransport
from relight_core.networks.bundle import load_bundle
from relight_core.pipeline import stages
from relight_core.pipeline.albedo import flatten_albedo
from relight_core.pipeline.cache import Stage, StageCache
from relight_core.pipeline.channels import (
    LIGHT_CHANNELS,
    SURFACE_CHANNELS,
    ViewChange,
    as_image,
    enlarge_change,
    fit_view,
    light_channels,
    surface_channel,
    upsampler_for,
)
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.finish import finish, over_background
from relight_core.pipeline.hints import Effects
from relight_core.pipeline.kept_lights import KeptLights, ServingLight
from relight_core.pipeline.model import light_surface
from relight_core.pipeline.plan import Effect, Plan, Scene, make_plan
from relight_core.pipeline.portrait import Portrait, choose_face, frame, refine
from relight_core.pipeline.quality import Tier, tier_of
from relight_core.pipeline.residual import Residual, add_residual, find_residual
from relight_core.resources import resource_path

WEIGHTS = ("weights", "relight.safetensors")

_KEPT_LIGHTS = 24
"""Results of this many lights stay: a light that is turned there and back, or two that are compared."""

_KEPT_TIERS = 16
"""As many tiers may be compared side by side without any of them being prepared twice."""


@dataclass(frozen=True, eq=False)
class Relit:
    """A relit portrait.

    Attributes:
        image: (H, W, 3) float32 linear radiance at the photo's size, without `Edit.exposure_ev`.
        alpha: (H, W) float32 in [0, 1] where the background was taken away, else None.
        channels: views (S, S, 3) or (S, S) float32 by name, as far as `Edit.channels` asks for them: "photo",
            "albedo", "normal" (unit vectors, camera space), "parsing" (int labels), "specular", "shadow" and
            "composition" (linear, at the light's level), and the lights "source_light" and "target_light"
            (16, 32, 3).
        faces: the boxes of the faces that were relit, in photo pixels.
        stages: what each stage did, in the order in which they ended.
        plan: what was decided about each effect, and why.
        window: x0, y0, x1, y1 of the square the channels show, in photo pixels; it may reach beyond the photo.
    """

    image: np.ndarray
    alpha: np.ndarray | None
    channels: dict[str, np.ndarray]
    faces: list[FaceBox]
    stages: dict[str, Stage] = field(default_factory=dict)
    plan: tuple[Effect, ...] = ()
    window: tuple[float, float, float, float] | None = None


@dataclass(frozen=True, eq=False)
class _Prepared:
    """A portrait as one tier of quality sees it.

    Attributes:
        found: what de-lighting found.
        surface: the same, its albedo flattened where the plan wants that.
    """

    portrait: Portrait
    tier: Tier
    found: stages.Surface
    surface: stages.Surface
    photo_view: np.ndarray
    photo_small: np.ndarray


@dataclass(frozen=True, eq=False)
class _Lit:
    """A prepared portrait under a light, at the networks' size."""

    reflected: torch.Tensor
    effects: Effects
    composed: stages.Composed


class Relighter:
    """Takes a portrait apart once and puts it together under any light.

    Not thread-safe: one thread at a time.
    """

    def __init__(self, weights_path: Path | None = None, device: str = "cpu", *, remembers: bool = True):
        """Load the networks.

        Args:
            weights_path: a file written by `save_bundle`; None takes the bundled one.
            device: "cpu" or "cuda".
            remembers: False computes everything anew for every picture, to see what reuse is worth.

        Raises:
            InputError: the weights are missing or damaged.
        """
        path = Path(weights_path) if weights_path else resource_path(*WEIGHTS)
        self._device = device
        self._bundle = load_bundle(path).for_inference().to(device)
        self._table = ReflectionTable().to(device)
        self._cache = StageCache(remembers)
        self._lights = KeptLights(_KEPT_LIGHTS)
        self._portrait: Portrait | None = None

    def set_portrait(self, photo: Photo, face_index: int | None = None) -> None:
        """Choose the photo to relight; finds its face and frames it by the parsing map.

        Args:
            face_index: which face, in order of size; None for the largest.

        Raises:
            InputError: no face is found, or there is none of that index. The previous portrait stays.
        """
        portrait = frame(photo, choose_face(photo, face_index))
        live = tier_of("live")
        found = self._delight(portrait.view.extract(photo.linear, live.size), live)
        labels = found.parsing[0].argmax(0).cpu().numpy()
        self._portrait = refine(portrait, labels)
        self._cache.clear()
        self._lights.clear()

    def estimated_light(self, quality: str = "live") -> Environment:
        """The light the photo was taken under, as de-lighting sees it, at the photo's own exposure.

        Raises:
            InputError: no portrait has been set.
        """
        tier = tier_of(quality)
        plan = make_plan(Scene(tier, "own", 0.0, None, 1.0), Edit(quality=quality))
        ready = self._flattened(self._prepare(tier))
        return Environment.from_radiance(self._own_light(ready, plan), "borrowed")

    def plan(self, environment: Environment, edit: Edit) -> Plan:
        """What `relight` would do now; computes nothing.

        Raises:
            InputError: as `relight`.
        """
        return self._planned(environment, edit)[0]

    def relight(self, environment: Environment, edit: Edit) -> Relit:
        """Light the portrait.

        Only what the scene calls for and what is not known yet is computed; `Relit.plan` says which effects,
        `Relit.stages` which steps. The light's level scales the result like exposure and never reaches a
        network.

        Raises:
            InputError: no portrait has been set, or the edit asks for something unknown.
        """
        self._cache.begin_update()
        plan, light = self._planned(environment, edit)
        ready = self._prepare(tier_of(edit.quality))
        if plan.runs("flattening"):
            ready = self._flattened(ready)
        lit = self._lit(ready, light, plan)
        change = self._cache.run(
            "sliders",
            plan.keys["sliders"],
            lambda: self._change(ready, lit, plan, edit, environment.level),
            "new light or slider",
        )
        image, alpha = self._finished(ready, change, plan, environment, edit)
        channels = self._channels(ready, lit, change, plan, edit)
        if edit.looks_at("target_light") and plan.runs("channels"):
            channels["target_light"] = network_light(environment, edit.yaw_deg) * np.float32(environment.level)
        faces, window = [ready.portrait.face], ready.portrait.view.window
        return Relit(image, alpha, channels, faces, dict(self._cache.stages), plan.effects, window)

    def forget(self, stage: str) -> None:
        """Drop a stage's results, so that it runs again when next needed; for measuring it."""
        self._cache.forget(stage)

    def _planned(self, environment: Environment, edit: Edit) -> tuple[Plan, ServingLight]:
        if self._portrait is None:
            raise InputError("no portrait is open: choose a photo first")
        tier = tier_of(edit.quality)
        exact = not self._cache.remembers or bool(edit.forced_on)
        light = self._lights.match(tier, network_light(environment, edit.yaw_deg), 0.0 if exact else edit.tolerance)
        backdrop = (environment.fingerprint, edit.yaw_deg)
        scene = Scene(tier, light.name, light.bound, backdrop, environment.level)
        return make_plan(scene, edit, self._cache.has, self._cache.typical_ms), light

    def _once(self, name: str, key: Hashable, make):
        """A stage that only a new photo or another quality makes run again."""
        return self._cache.run(name, key, make, "new photo or quality", keep=_KEPT_TIERS)

    def _prepare(self, tier: Tier) -> _Prepared:
        portrait = self._portrait
        if portrait is None:
            raise InputError("no portrait is open: choose a photo first")
        photo_view = self._once("view", tier.size, lambda: portrait.view.extract(portrait.photo.linear, tier.size))
        small = (tier.network_size, tier.network_size)
        photo_small = self._once("network_view", (tier.size, tier.network_size), lambda: resize_area(photo_view, small))
        found = self._once("delight", tier.surface_key, lambda: self._delight(photo_view, tier))
        return _Prepared(portrait, tier, found, found, photo_view, photo_small)

    def _delight(self, photo_view: np.ndarray, tier: Tier) -> stages.Surface:
        seen = resize_area(photo_view, (tier.delight_size, tier.delight_size))
        return stages.delight(
            self._bundle, seen, tier.network_size, self._device, mirrored=tier.mirrored, precision=tier.precision
        )

    def _flattened(self, ready: _Prepared) -> _Prepared:
        relief, light = self._relief(ready), self._source_light(ready)
        surface = self._once("albedo", ready.tier.relief_key, lambda: flatten_albedo(ready.found, relief, light))
        return replace(ready, surface=surface)

    def _relief(self, ready: _Prepared) -> ReliefTransport:
        return self._once("relief", ready.tier.relief_key, lambda: stages.march(ready.found, ready.tier.relief_size))

    def _source_light(self, ready: _Prepared) -> torch.Tensor:
        relief = self._relief(ready)
        return self._once(
            "source_light",
            ready.tier.relief_key,
            lambda: stages.explain_source_light(ready.found, self._table, relief),
        )

    def _own_light(self, ready: _Prepared, plan: Plan) -> np.ndarray:
        """The source light (16, 32, 3), as bright as makes the whole model of the photo as bright as the photo."""
        light = self._source_light(ready)[0].cpu().numpy()
        if not plan.runs("residual"):
            return light
        return light * np.float32(self._residual(ready, plan).level / max(mean_luminance(light), 1e-12))

    def _residual(self, ready: _Prepared, plan: Plan) -> Residual:
        """What the model, as far as the plan runs it, misses of the photo."""

        def compose(light: torch.Tensor) -> stages.Composed:
            relief = self._relief(ready) if plan.runs("relief") else None
            how = {"by_network": plan.shadow_network, "corrected": plan.runs("correction")}
            precision = ready.tier.precision
            return light_surface(self._bundle, self._table, ready.surface, relief, light, precision=precision, **how)[2]

        source = self._source_light(ready)
        return self._once("residual", plan.keys["residual"], lambda: find_residual(ready.surface, source, compose))

    def _matte(self, portrait: Portrait) -> np.ndarray:
        """The person at the photo's resolution; from one tier for all, so that it depends on no history."""
        surface = self._prepare(tier_of("live")).surface
        person = surface.person[0, 0].cpu().numpy()
        return refine_matte(portrait.photo.linear, person, portrait.view, portrait.photo.alpha)

    def _lit(self, ready: _Prepared, serving: ServingLight, plan: Plan) -> _Lit:
        light = torch.from_numpy(serving.radiance)[None].to(self._device)
        reflected = self._cache.run(
            "irradiance",
            plan.keys["irradiance"],
            lambda: stages.reflect(self._table, ready.surface, light),
            "new light",
        )
        effects = self._effects(ready, reflected, light, plan)
        composed = self._cache.run(
            "compose",
            plan.keys["compose"],
            lambda: stages.compose(
                self._bundle,
                ready.surface,
                reflected,
                effects,
                light,
                self._device,
                corrected=plan.runs("correction"),
                parts=(plan.runs("specular"), plan.runs("shadow")),
                precision=ready.tier.precision,
            ),
            "new light",
            keep=_KEPT_LIGHTS,
        )
        return _Lit(reflected, effects, composed)

    def _effects(self, ready: _Prepared, reflected: torch.Tensor, light: torch.Tensor, plan: Plan) -> Effects:
        """Specular and shadow; none where the plan has neither."""
        if not (plan.runs("shadow") or plan.runs("specular")):
            self._cache.skip("specular_shadow", plan.effect("shadow").why)
            return stages.no_effects(ready.surface)
        relief = self._relief(ready) if plan.runs("relief") else None
        return self._cache.run(
            "specular_shadow",
            plan.keys["specular_shadow"],
            lambda: stages.estimate_effects(
                self._bundle,
                ready.surface,
                reflected,
                relief,
                light,
                self._device,
                by_network=plan.shadow_network,
                precision=ready.tier.precision,
            ),
            "new light",
            keep=_KEPT_LIGHTS,
        )

    def _change(self, ready: _Prepared, lit: _Lit, plan: Plan, edit: Edit, level: float) -> ViewChange:
        """How the relit view differs from the photo's, at the sliders' gains and the light's level."""
        fit = self._cache.run("detail_fit", plan.keys["detail_fit"], lambda: self._fit(ready, lit, plan), "new light")
        moved = None
        if plan.runs("sliders"):
            specular, shadow = edit.specular * plan.runs("specular"), edit.shadow * plan.runs("shadow")
            moved = stages.move_sliders(lit.composed, ready.surface, lit.reflected, lit.effects, specular, shadow)
        return enlarge_change(fit, moved, self._upsampler(ready), level)

    def _fit(self, ready: _Prepared, lit: _Lit, plan: Plan) -> LightChange:
        """The relit view as gain and offset of the photo; without detail, offset only."""
        image, effects = lit.composed.image, lit.effects
        if plan.runs("residual"):
            image, effects = add_residual(self._residual(ready, plan), lit.composed, effects)
        if plan.runs("detail"):
            return fit_view(ready.photo_small, ready.surface, lit.reflected, effects, image)
        relit = as_image(image)
        return LightChange(np.zeros_like(relit), relit)

    def _upsampler(self, ready: _Prepared) -> JointUpsampler:
        return self._once("edges", ready.tier.surface_key, lambda: upsampler_for(ready.photo_view, ready.photo_small))

    def _finished(self, ready: _Prepared, change: ViewChange, plan: Plan, environment: Environment, edit: Edit):
        """Full resolution: the photo's detail, then the background. (H, W, 3) and alpha or None."""
        photo, place = ready.portrait.photo, ready.portrait.view
        matte = self._once("matte", "photo", lambda: self._matte(ready.portrait))
        full_view = self._once("full_view", "photo", lambda: place.extract(photo.linear, round(place.side)))
        why = "new light or slider"
        relit = self._cache.run("detail", plan.keys["detail"], lambda: change.apply(full_view), why)
        pasted = self._cache.run("paste", plan.keys["paste"], lambda: finish(photo.linear, relit, place, matte), why)
        if not plan.runs("background"):
            return pasted, None
        behind = self._panorama(photo.linear.shape[:2], plan, environment, edit)
        return self._cache.run(
            "background",
            plan.keys["background"],
            lambda: over_background(pasted, matte, edit.background, behind),
            "new light, slider or background",
        )

    def _panorama(self, size: tuple[int, int], plan: Plan, environment: Environment, edit: Edit) -> np.ndarray | None:
        """What the camera sees of the light (H, W, 3), where that is the background."""
        if edit.background != "light":
            return None
        return self._cache.run(
            "panorama",
            plan.keys["panorama"],
            lambda: panorama_background(environment, edit.yaw_deg, *size) * np.float32(environment.level),
            "new light",
        )

    def _channels(self, ready: _Prepared, lit: _Lit, change: ViewChange, plan: Plan, edit: Edit) -> dict:
        """The channels that are looked at, all but "target_light"."""
        if not plan.runs("channels"):
            self._cache.skip("channels", plan.effect("channels").why)
            return {}
        fixed = {
            name: self._once(
                f"{name}_channel",
                plan.keys["surface"],
                lambda name=name: surface_channel(name, ready.surface, ready.photo_view, ready.photo_small),
            )
            for name in SURFACE_CHANNELS
            if edit.looks_at(name)
        }
        if plan.runs("source_light") and edit.looks_at("source_light"):
            fixed["source_light"] = self._own_light(ready, plan)
        shown = Effects(lit.effects.specular * plan.runs("specular"), lit.effects.shadow * plan.runs("shadow"))
        lighted = self._cache.run(
            "channels",
            plan.keys["channels"],
            lambda: light_channels(
                shown, change, ready.photo_view, [name for name in LIGHT_CHANNELS if edit.looks_at(name)]
            ),
            "new light or slider",
        )
        return fixed | lighted
