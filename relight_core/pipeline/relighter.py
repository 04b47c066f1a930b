"""The Relighter: a portrait is set once, slowly, and relit many times, quickly."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import torch

from relight_core.errors import InputError
from relight_core.face.find import FaceBox
from relight_core.imaging.guided_detail import apply_detail, fit_detail
from relight_core.imaging.matte import refine_matte
from relight_core.imaging.photo import Photo
from relight_core.lighting.environment import Environment, network_light
from relight_core.lighting.reflection import ReflectionTable
from relight_core.lighting.relief import ReliefTransport
from relight_core.networks.bundle import load_bundle
from relight_core.pipeline import stages
from relight_core.pipeline.cache import Stage, StageCache
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
    photo_level: float


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
        draft = stages.delight(self._bundle, portrait.view.extract(photo.linear, tier_of("draft").size), self._device)
        labels = draft.parsing[0].argmax(0).cpu().numpy()
        self._portrait = refine(portrait, labels)
        self._cache = StageCache()

    def estimated_light(self, quality: str = "live") -> Environment:
        """The light the photo was taken under, as de-lighting sees it, at the photo's own exposure.

        Raises:
            InputError: no portrait has been set.
        """
        ready = self._prepare(tier_of(quality))
        shape = ready.surface.source_light[0].cpu().numpy()
        return Environment.from_radiance(shape * ready.photo_level, "borrowed")

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
        gains = (edit.specular, edit.shadow)
        view = self._cache.run(
            "sliders",
            (light_key, gains),
            lambda: self._with_sliders(composed, ready, reflected, effects, gains),
            "new light or slider",
        )
        image, alpha = self._finished(ready, view, light_key, environment, edit)
        channels = self._channels(ready, effects, view, light, environment.level)
        return Relit(image, alpha, channels, [ready.portrait.face], dict(self._cache.stages))

    def _prepare(self, tier: Tier) -> _Prepared:
        portrait = self._portrait
        if portrait is None:
            raise InputError("no portrait is open: choose a photo first")

        def once(name: str, key: Tier | int, make):
            return self._cache.run(name, key, make, "new photo or quality", keep=len(TIERS))

        photo_view = once("view", tier.size, lambda: portrait.view.extract(portrait.photo.linear, tier.size))
        surface = once("delight", tier.size, lambda: stages.delight(self._bundle, photo_view, self._device))
        relief = once("relief", tier, lambda: stages.march(surface, tier.relief_size))
        level = once("exposure", tier.size, lambda: stages.exposure_of_photo(surface, self._table))
        return _Prepared(portrait, surface, relief, photo_view, level)

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

    def _with_sliders(self, composed, ready: _Prepared, reflected, effects, gains) -> np.ndarray:
        effects = effects or stages.no_effects(ready.surface)
        image = stages.apply_sliders(composed, ready.surface, reflected, effects, *gains)
        return _image(image)

    def _finished(self, ready: _Prepared, view: np.ndarray, light_key, environment: Environment, edit: Edit):
        """Full resolution: the photo's detail, then the background. (H, W, 3) and alpha or None."""
        photo, place = ready.portrait.photo, ready.portrait.view
        sliders = (light_key, edit.specular, edit.shadow, environment.level)
        matte = self._cache.run("matte", "photo", lambda: self._matte(ready.portrait), "new photo")
        full_view = self._cache.run(
            "full_view", "photo", lambda: place.extract(photo.linear, round(place.side)), "new photo"
        )
        relit = self._cache.run(
            "detail",
            sliders,
            lambda: apply_detail(fit_detail(ready.photo_view, view * environment.level), full_view),
            "new light or slider",
        )
        pasted = self._cache.run(
            "paste", sliders, lambda: finish(photo.linear, relit, place, matte), "new light or slider"
        )
        return self._cache.run(
            "background",
            (sliders, edit.background, edit.yaw_deg),
            lambda: over_background(pasted, matte, environment, edit),
            "new light or background",
        )

    def _channels(self, ready: _Prepared, effects, view: np.ndarray, light, level: float) -> dict[str, np.ndarray]:
        surface = ready.surface
        fixed = self._cache.run("fixed_channels", surface.photo.shape, lambda: _fixed_channels(surface), "new photo")
        effects = effects or stages.no_effects(surface)
        return fixed | {
            "specular": _image(effects.specular) * level,
            "shadow": _image(effects.shadow) * level,
            "composition": view * level,
            "target_light": light[0].cpu().numpy() * level,
        }


def _fixed_channels(surface: stages.Surface) -> dict[str, np.ndarray]:
    return {
        "photo": _image(surface.photo),
        "albedo": _image(surface.albedo),
        "normal": _image(surface.normal),
        "parsing": surface.parsing[0].argmax(0).cpu().numpy().astype(np.int32),
        "source_light": surface.source_light[0].cpu().numpy(),
    }


def _image(tensor: torch.Tensor) -> np.ndarray:
    """(1, C, S, S) to (S, S, C), or (S, S) for one channel."""
    array = np.ascontiguousarray(tensor[0].permute(1, 2, 0).float().cpu().numpy())
    return array[..., 0] if array.shape[-1] == 1 else array
