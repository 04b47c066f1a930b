"""The Relighter: a portrait is set once, slowly, and relit many times, quickly."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import torch

from relight_core.errors import InputError
from relight_core.face.find import FaceBox
from relight_core.imaging.guided_detail import fit_detail
from relight_core.imaging.matte import refine_matte
from relight_core.imaging.photo import Photo
from relight_core.imaging.resampling import resize_area
from relight_core.lighting.environment import Environment, network_light
from relight_core.lighting.reflection import ReflectionTable
from relight_core.lighting.relief import ReliefTransport
from relight_core.networks.bundle import load_bundle
from relight_core.pipeline import stages
from relight_core.pipeline.cache import Stage, StageCache
from relight_core.pipeline.channels import ViewChange, as_image, light_channels, surface_channels
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.finish import finish, over_background
from relight_core.pipeline.portrait import Portrait, choose_face, frame, refine
from relight_core.pipeline.quality import TIERS, Tier, tier_of
from relight_core.resources import resource_path

WEIGHTS = ("weights", "relight.safetensors")


@dataclass(frozen=True, eq=False)
class Relit:
    """A relit portrait.

    Attributes:
        image: (H, W, 3) float32 linear radiance at the photo's size, without `Edit.exposure_ev`.
        alpha: (H, W) float32 in [0, 1] where the background was taken away, else None.
        channels: views (S, S, 3) or (S, S) float32 by name: "photo", "albedo", "normal" (unit vectors,
            camera space), "parsing" (int labels), "specular", "shadow" and "composition" (linear, at the
            light's level), and the lights "source_light" and "target_light" (16, 32, 3).
        faces: the boxes of the faces that were relit, in photo pixels.
        stages: what each stage did, in the order in which they ran.
    """

    image: np.ndarray
    alpha: np.ndarray | None
    channels: dict[str, np.ndarray]
    faces: list[FaceBox]
    stages: dict[str, Stage] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class _Prepared:
    """A portrait as one tier of quality sees it, with everything that no light changes."""

    portrait: Portrait
    surface: stages.Surface
    relief: ReliefTransport
    photo_view: np.ndarray
    photo_small: np.ndarray
    source_light: np.ndarray


class Relighter:
    """Takes a portrait apart once and puts it together under any light.

    Not thread-safe: one thread at a time.
    """

    def __init__(self, weights_path: Path | None = None, device: str = "cpu"):
        """Load the networks.

        Args:
            weights_path: a file written by `save_bundle`; None takes the bundled one.
            device: "cpu" or "cuda".

        Raises:
            InputError: the weights are missing or damaged.
        """
        path = Path(weights_path) if weights_path else resource_path(*WEIGHTS)
        self._device = device
        self._bundle = load_bundle(path).for_inference().to(device)
        self._table = ReflectionTable().to(device)
        self._cache = StageCache()
        self._portrait: Portrait | None = None

    def set_portrait(self, photo: Photo, face_index: int | None = None) -> None:
        """Choose the photo to relight; finds its face and frames it by the parsing map.

        Args:
            face_index: which face, in order of size; None for the largest.

        Raises:
            InputError: no face is found, or there is none of that index. The previous portrait stays.
        """
        portrait = frame(photo, choose_face(photo, face_index))
        small = portrait.view.extract(photo.linear, tier_of("live").network_size)
        labels = stages.delight(self._bundle, small, self._device).parsing[0].argmax(0).cpu().numpy()
        self._portrait = refine(portrait, labels)
        self._cache = StageCache()

    def estimated_light(self, quality: str = "live") -> Environment:
        """The light the photo was taken under, as de-lighting sees it, at the photo's own exposure.

        Raises:
            InputError: no portrait has been set.
        """
        return Environment.from_radiance(self._prepare(tier_of(quality)).source_light, "borrowed")

    def relight(self, environment: Environment, edit: Edit) -> Relit:
        """Light the portrait.

        Only stages whose inputs changed run; `Relit.stages` says which. The light's level scales the
        result like exposure and never reaches a network.

        Raises:
            InputError: no portrait has been set, or the edit asks for something unknown.
        """
        self._cache.begin_update()
        tier = tier_of(edit.quality)
        ready = self._prepare(tier)
        light_key = (tier, environment.fingerprint, edit.yaw_deg)
        light = torch.from_numpy(network_light(environment, edit.yaw_deg))[None].to(self._device)
        reflected = self._cache.run(
            "irradiance", light_key, lambda: stages.reflect(self._table, ready.surface, light), "new light"
        )
        effects = self._effects(ready, reflected, light, light_key, environment, edit)
        composed = self._cache.run(
            "compose",
            (light_key, effects is None),
            lambda: stages.compose(
                self._bundle,
                ready.surface,
                reflected,
                effects or stages.no_effects(ready.surface),
                light,
                self._device,
            ),
            "new light",
        )
        effects = effects or stages.no_effects(ready.surface)
        sliders = (light_key, edit.specular, edit.shadow, environment.level)
        change = self._cache.run(
            "sliders",
            sliders,
            lambda: self._change(composed, light_key, ready, reflected, effects, edit, environment.level),
            "new light or slider",
        )
        image, alpha = self._finished(ready, change, sliders, environment, edit)
        channels = self._cache.run(
            "channels",
            sliders,
            lambda: light_channels(effects, change, ready.photo_view, light),
            "new light or slider",
        )
        fixed = self._cache.run(
            "surface_channels",
            tier,
            lambda: (
                surface_channels(ready.surface, ready.photo_view, ready.photo_small)
                | {"source_light": ready.source_light}
            ),
            "new photo or quality",
            keep=len(TIERS),
        )
        return Relit(image, alpha, fixed | channels, [ready.portrait.face], dict(self._cache.stages))

    def _prepare(self, tier: Tier) -> _Prepared:
        portrait = self._portrait
        if portrait is None:
            raise InputError("no portrait is open: choose a photo first")

        def once(name: str, key: Tier | int, make):
            return self._cache.run(name, key, make, "new photo or quality", keep=len(TIERS))

        photo_view = once("view", tier.size, lambda: portrait.view.extract(portrait.photo.linear, tier.size))
        small = (tier.network_size, tier.network_size)
        photo_small = once("network_view", tier, lambda: resize_area(photo_view, small))
        surface = once(
            "delight",
            tier,
            lambda: stages.delight(self._bundle, photo_small, self._device, mirrored=tier.mirrored),
        )
        relief = once("relief", tier, lambda: stages.march(surface, tier.relief_size))
        light = once("source_light", tier, lambda: stages.explain_source_light(surface, self._table, relief))
        return _Prepared(portrait, surface, relief, photo_view, photo_small, light[0].cpu().numpy())

    def _matte(self, portrait: Portrait) -> np.ndarray:
        """The person at the photo's resolution; from one tier for all, so that it depends on no history."""
        surface = self._prepare(tier_of("live")).surface
        person = surface.person[0, 0].cpu().numpy()
        return refine_matte(portrait.photo.linear, person, portrait.view, portrait.photo.alpha)

    def _effects(self, ready: _Prepared, reflected, light, light_key, environment: Environment, edit: Edit):
        """Specular and shadow, or None where nothing asks for them."""
        if environment.level == 0:
            self._cache.skip("specular_shadow", "the light is black")
            return None
        return self._cache.run(
            "specular_shadow",
            light_key,
            lambda: stages.estimate_effects(self._bundle, ready.surface, reflected, ready.relief, light, self._device),
            "new light",
        )

    def _change(
        self, composed, light_key, ready: _Prepared, reflected, effects, edit: Edit, level: float
    ) -> ViewChange:
        """How the relit view differs from the photo's, at the sliders' gains and the light's level."""
        fit = self._cache.run(
            "detail_fit",
            light_key,
            lambda: fit_detail(ready.photo_small, as_image(composed.image)),
            "new light",
        )
        moved = stages.move_sliders(composed, ready.surface, reflected, effects, edit.specular, edit.shadow)
        if moved is None:
            return ViewChange(fit, None, None, level)
        return ViewChange(fit, as_image(moved.kept), as_image(moved.added), level)

    def _finished(self, ready: _Prepared, change: ViewChange, sliders, environment: Environment, edit: Edit):
        """Full resolution: the photo's detail, then the background. (H, W, 3) and alpha or None."""
        photo, place = ready.portrait.photo, ready.portrait.view
        matte = self._cache.run("matte", "photo", lambda: self._matte(ready.portrait), "new photo")
        full_view = self._cache.run(
            "full_view", "photo", lambda: place.extract(photo.linear, round(place.side)), "new photo"
        )
        relit = self._cache.run("detail", sliders, lambda: change.apply(full_view), "new light or slider")
        pasted = self._cache.run(
            "paste", sliders, lambda: finish(photo.linear, relit, place, matte), "new light or slider"
        )
        return self._cache.run(
            "background",
            (sliders, edit.background, edit.yaw_deg),
            lambda: over_background(pasted, matte, environment, edit),
            "new light or background",
        )
