"""Catchlights: what the eyes mirror of a light, in place of what they mirrored when the photo was taken.

The cornea is a wet ball that mirrors 2.5 % of what is before it (refractive index 1.376), so that little but lamps is
seen in it. What comes from everywhere alike is in the photo of the eye already and changes with its gain; what a
light has beyond that is mirrored here, as sharply as the photo shows the eye. Under the light that the photo was taken
in its own stay, which are finer than any estimate of that light.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from hashlib import blake2b

import cv2
import numpy as np
import torch

from relight_core.face.crop import Crop
from relight_core.imaging.colour import luminance, without_colour
from relight_core.imaging.masks import bounds
from relight_core.imaging.ramp import ramp
from relight_core.imaging.resampling import resize_area
from relight_core.imaging.tensor_colour import grey
from relight_core.lighting.environment import Environment
from relight_core.lighting.panorama import mean_radiance, shrink
from relight_core.lighting.relief import ReliefTransport
from relight_core.lighting.roll import roll_light
from relight_core.lighting.sphere import solid_angles
from relight_core.pipeline.per_light.hints import Effects, hidden_share
from relight_core.pipeline.per_photo.corneas import Cornea
from relight_core.pipeline.stages import Surface

_BLUR = 0.012
"""Of an eye's square: lenses are no sharper."""
_FEWEST_ROWS, _MOST_ROWS = 16, 256
_ANOTHER_LIGHT = 0.1
"""Share of its light that lies elsewhere than the photo's own did, from which on a light is altogether another."""
_LEAST_OPEN = 1e-9


@dataclass(frozen=True, eq=False)
class Catchlight:
    """What a light does in one eye.

    Attributes:
        cornea: of it.
        mirrored: (E, E, 3) float32 linear, what it mirrors of a light of mean luminance 1.
        replaces: in [0, 1] how far that takes the place of what the photo shows.
    """

    cornea: Cornea
    mirrored: np.ndarray
    replaces: float

    def times(self, gloss: np.ndarray, monochrome: bool = False) -> Catchlight:
        """The same at a light's level and the sliders' gain on gloss, (1,) or (3,) together."""
        mirrored = gloss * self.mirrored
        return replace(self, mirrored=without_colour(mirrored) if monochrome else mirrored)

    def change(self, gain: np.ndarray) -> np.ndarray:
        """(E, E, 3) what it adds to the relit picture.

        Args:
            gain: (E, E, 3) by which the photo's colours are multiplied there.
        """
        return np.float32(self.replaces) * (self.mirrored - gain * self.cornea.mirrored)


@dataclass(frozen=True, eq=False)
class EyeSky:
    """From where light reaches an eye by the relief, whatever the light.

    Attributes:
        unshadowed, shadowed: (texels,) of the relief's transport, at the eye.
        seen: (h, 2h) share in [0, 1] of what comes from each direction that reaches it, in the photo's camera space.
        place: rows and columns of the surface in which its iris lies.
        weights: (rows, columns) float32, how far each of their pixels is iris; sum 1, or 0 where it lies beyond.
    """

    unshadowed: torch.Tensor
    shadowed: torch.Tensor
    seen: np.ndarray
    place: tuple[slice, slice]
    weights: np.ndarray


@dataclass(frozen=True, eq=False)
class LitEye:
    """The light about one eye.

    Attributes:
        seen: as of `EyeSky`, in the light in force.
        evenly: (3,) mean radiance that reaches it, of a light of mean luminance 1.
    """

    seen: np.ndarray
    evenly: np.ndarray


def name_of_mirrored(environment: Environment) -> Hashable:
    """Names what eyes can mirror of a light, whatever its level, by its contents.

    That is small: to name a whole panorama takes longer than to mirror it.
    """
    return environment.of_shape("mirrored, named", lambda _: blake2b(_as_fine_as_eyes(environment).tobytes()).digest())


def _as_fine_as_eyes(environment: Environment) -> np.ndarray:
    """(h, 2h, 3) of the finest that any eye mirrors."""
    return environment.of_shape(
        "mirrored", lambda shape: shrink(shape, _MOST_ROWS) if len(shape) > _MOST_ROWS else shape
    )


def _mirrored_by(cornea: Cornea, environment: Environment) -> np.ndarray:
    """(h, 2h, 3) whose texels are no smaller than what lies between two normals: none may fall between them."""
    step_deg = np.degrees(2 * float(np.abs(np.diff(cornea.normal[0], axis=1)).max()))
    finest, rows = _as_fine_as_eyes(environment), _FEWEST_ROWS
    while 2 * rows <= min(180 / max(step_deg, 1e-3), len(finest)):
        rows *= 2
    return environment.of_shape(("mirrored", rows), lambda _: shrink(finest, rows) if len(finest) > rows else finest)


def how_much_another(light: np.ndarray, own: np.ndarray) -> float:
    """How far a light is another than the photo's own, [0, 1]; both (16, 32, 3), of any level."""
    areas = solid_angles(*light.shape[:2])
    one, other = (luminance(part) * areas for part in (light, own))
    apart = np.abs(one / max(one.sum(), 1e-12) - other / max(other.sum(), 1e-12)).sum() / 2
    return float(ramp(float(apart), 0.0, _ANOTHER_LIGHT))


def sky_over(cornea: Cornea, view: Crop, transport: ReliefTransport, size: int) -> EyeSky:
    """What the relief leaves of the sky over an eye.

    Args:
        view: of the relief, and of the surface.
        size: of the surface.
    """
    points = torch.from_numpy(_weights(cornea, view, transport.size).ravel())
    at = points.nonzero()[:, 0]
    unshadowed, shadowed = (
        points[at] @ part[at.to(part.device)].cpu() for part in (transport.unshadowed, transport.shadowed)
    )
    seen = torch.where(unshadowed > _LEAST_OPEN, shadowed / unshadowed.clamp_min(_LEAST_OPEN), 0).clamp(0, 1)
    rows = round((len(seen) / 2) ** 0.5)
    seen = seen.reshape(rows, 2 * rows).numpy()
    if view.roll_deg:
        seen = np.clip(roll_light(np.repeat(seen[..., None], 3, axis=-1), -view.roll_deg)[..., 0], 0, 1)
    weights = _weights(cornea, view, size)
    place = bounds(weights)
    return EyeSky(unshadowed=unshadowed, shadowed=shadowed, seen=seen, place=place, weights=weights[place])


def light_about(
    sky: EyeSky, surface: Surface, effects: Effects, reflected: torch.Tensor, light: torch.Tensor
) -> LitEye:
    """What reaches an eye of a light, as the relief and the networks have it.

    Args:
        effects, reflected: as of `hints.explicit_sum`, of the light.
        light: (1, 16, 32, 3) as the view sees it.
    """
    flat = light.float().reshape(-1, 3).cpu()
    evenly, unshadowed = sky.shadowed @ flat, float((sky.unshadowed @ flat).sum())
    # What the networks know to be in shadow, of a brim or a nose, mirrors no lamp either.
    reaches = 1 - _hidden_at(sky, surface, effects, reflected)
    agreed = min(1.0, reaches * unshadowed / max(float(evenly.sum()), 1e-12))
    return LitEye(np.float32(agreed) * sky.seen, evenly.numpy())


def in_the_open(light: torch.Tensor) -> LitEye:
    """What reaches an eye of a light (1, h, 2h, 3) that nothing hides."""
    return LitEye(np.ones(light.shape[1:3], np.float32), mean_radiance(light[0].cpu().numpy()).astype(np.float32))


def _hidden_at(sky: EyeSky, surface: Surface, effects: Effects, reflected: torch.Tensor) -> float:
    """Share of the diffuse light that an eye does not get."""
    parts = surface.albedo, reflected, effects.specular, effects.shadow
    albedo, reflected, specular, shadow = (part[..., *sky.place] for part in parts)
    hidden = hidden_share(Effects(specular, shadow), grey(albedo * reflected[:, :3]), grey(reflected[:, 3:]))
    return float((hidden[0, 0].cpu().numpy() * sky.weights).sum())


def mirrored_light(cornea: Cornea, eye: LitEye, environment: Environment, yaw_deg: float) -> np.ndarray:
    """(E, E, 3) radiance that an eye mirrors of a light of mean luminance 1, beyond what comes evenly.

    Args:
        environment: the light; its level is not read.
        yaw_deg: its turn.
    """
    across, down = cornea.mirrored_places
    radiance = _looked_up(_mirrored_by(cornea, environment), across - np.float32(yaw_deg / 360), down)
    share = cornea.reflectance * _looked_up(eye.seen, across, down)
    finely = share[..., None] * np.maximum(radiance - eye.evenly, 0)
    size = len(cornea.bare)
    finely = resize_area(finely, (min(size, len(finely)),) * 2)
    seen = cv2.GaussianBlur(finely, (0, 0), max(_BLUR * len(finely), 0.5))
    if len(seen) < size:
        seen = cv2.resize(seen, (size, size), interpolation=cv2.INTER_LINEAR)
    return cornea.bare[..., None] * seen


def _weights(cornea: Cornea, view: Crop, size: int) -> np.ndarray:
    """(size, size) float32, sum 1: which pixels of a view an iris lies in; 0 where it lies beyond it."""
    iris = cornea.iris
    x, y = view.from_photo(np.array([iris.x, iris.y]), size) - 0.5
    place, radius = np.arange(size), max(iris.radius * size / view.side, 1.0)
    within = np.clip(radius + 0.5 - np.hypot(place[None, :] - x, place[:, None] - y), 0, 1)
    return (within / max(within.sum(), 1e-12)).astype(np.float32)


def _looked_up(panorama: np.ndarray, across: np.ndarray, down: np.ndarray) -> np.ndarray:
    """A panorama at places on it, bilinearly, (h, w) or (h, w, 3); shares of its width go round."""
    height, width = panorama.shape[:2]
    wrapped = np.concatenate([panorama[:, -1:], panorama, panorama[:, :1]], axis=1).astype(np.float32)
    column, row = np.mod(across, 1) * width + 0.5, down * height - 0.5
    places = column.astype(np.float32), row.astype(np.float32)
    return cv2.remap(wrapped, *places, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
