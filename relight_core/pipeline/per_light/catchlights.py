"""Catchlights: the reflections of the new light in the eyes, in place of those in the photo.

The cornea is a wet ball that mirrors 2.5 % of what is in front of it (refractive index 1.376), so little but lamps can
be seen in it. The even part of a light is already in the photo of the eye and changes with its gain; what exceeds it is
mirrored here, as sharply as the photo shows the eye. Under the photo's own light its own catchlights stay, since they
are finer than any estimate of that light.
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
from relight_core.lighting.sphere import solid_angles, without_whole_turns
from relight_core.pipeline.per_light.hints import Effects, hidden_share
from relight_core.pipeline.per_photo.corneas import Cornea
from relight_core.pipeline.stages import Surface

_BLUR = 0.012
"""Standard deviation of the lens's blur, as a share of the eye's square."""
_FEWEST_ROWS, _MOST_ROWS = 16, 256
"""Of the panorama that an eye mirrors."""
_DIFFERENT = 0.1
"""If at least this share of a light comes from elsewhere than the photo's own, it counts wholly as another light."""
_LEAST_OPEN = 1e-9
"""Response of an eye to a texel below which the texel counts as hidden."""


@dataclass(frozen=True, eq=False)
class Catchlight:
    """The reflection of a light in one eye.

    Attributes:
        cornea: the eye's.
        mirrored: (E, E, 3) float32 linear radiance that it mirrors of a light of mean luminance 1.
        replaces: in [0, 1], the degree to which this replaces the photo's own catchlights.
    """

    cornea: Cornea
    mirrored: np.ndarray
    replaces: float

    def times(self, gloss: np.ndarray, monochrome: bool = False) -> Catchlight:
        """The catchlight times a gain, (1,) or (3,): the light's level times the sliders' gain on gloss."""
        mirrored = gloss * self.mirrored
        return replace(self, mirrored=without_colour(mirrored) if monochrome else mirrored)

    def change(self, gain: np.ndarray) -> np.ndarray:
        """What is added to the relit picture, (E, E, 3): the new catchlights minus the relit old ones.

        Args:
            gain: (E, E, 3) by which the photo is multiplied there.
        """
        return np.float32(self.replaces) * (self.mirrored - gain * self.cornea.mirrored)


@dataclass(frozen=True, eq=False)
class EyeSky:
    """The directions from which light reaches an eye, according to the relief; independent of the light.

    Attributes:
        unshadowed, shadowed: (texels,) of the relief's transport, averaged over the iris.
        seen: (h, 2h) in [0, 1], visibility of each direction from the eye, in the photo's camera space.
        place: rows and columns of the surface that contain the iris.
        weights: (rows, columns) float32, the share of each of these pixels that is iris, scaled to a sum of 1; all 0 if
            the iris is outside the view.
    """

    unshadowed: torch.Tensor
    shadowed: torch.Tensor
    seen: np.ndarray
    place: tuple[slice, slice]
    weights: np.ndarray


@dataclass(frozen=True, eq=False)
class LitEye:
    """What reaches one eye of a light.

    Attributes:
        seen: as of `EyeSky`, corrected by what the networks say of this light.
        evenly: (3,) mean radiance that reaches the eye, of a light of mean luminance 1.
    """

    seen: np.ndarray
    evenly: np.ndarray


def mirrored_key(environment: Environment) -> Hashable:
    """A cache key for what eyes can mirror of a light, whatever its level.

    It is the hash of a small copy, since hashing a whole panorama takes longer than mirroring it.
    """
    return environment.of_shape("mirrored, named", lambda _: blake2b(_as_fine_as_eyes(environment).tobytes()).digest())


def _as_fine_as_eyes(environment: Environment) -> np.ndarray:
    """The light's shape at the highest resolution that any eye mirrors, (h, 2h, 3)."""
    return environment.of_shape(
        "mirrored", lambda shape: shrink(shape, _MOST_ROWS) if len(shape) > _MOST_ROWS else shape
    )


def _mirrored_by(cornea: Cornea, environment: Environment) -> np.ndarray:
    """The light's shape with texels at least as large as the step between two normals' mirrored directions, (h, 2h, 3).

    A lamp in a smaller texel could fall between two normals.
    """
    step_deg = np.degrees(2 * float(np.abs(np.diff(cornea.normal[0], axis=1)).max()))
    finest, rows = _as_fine_as_eyes(environment), _FEWEST_ROWS
    while 2 * rows <= min(180 / max(step_deg, 1e-3), len(finest)):
        rows *= 2
    return environment.of_shape(("mirrored", rows), lambda _: shrink(finest, rows) if len(finest) > rows else finest)


def difference_of_lights(light: np.ndarray, own: np.ndarray) -> float:
    """How different a light's distribution over the sphere is from the photo's own, [0, 1]; both (16, 32, 3)."""
    areas = solid_angles(*light.shape[:2])
    one, other = (luminance(part) * areas for part in (light, own))
    apart = np.abs(one / max(one.sum(), 1e-12) - other / max(other.sum(), 1e-12)).sum() / 2
    return float(ramp(float(apart), 0.0, _DIFFERENT))


def sky_over(cornea: Cornea, view: Crop, transport: ReliefTransport, size: int) -> EyeSky:
    """What an eye sees of the sphere past the relief.

    Args:
        view: of the relief and the surface.
        transport: of the relief.
        size: S, of the surface.
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
    """What reaches an eye of a light, by relief and networks together.

    Args:
        effects, reflected: as of `hints.explicit_sum`, under the light.
        light: (1, 16, 32, 3) in the view's camera space.
    """
    flat = light.float().reshape(-1, 3).cpu()
    evenly, unshadowed = sky.shadowed @ flat, float((sky.unshadowed @ flat).sum())
    # If the networks say that the eye lies in shadow, of a brim or a nose, it mirrors no lamp either.
    reaches = 1 - _hidden_at(sky, surface, effects, reflected)
    agreed = min(1.0, reaches * unshadowed / max(float(evenly.sum()), 1e-12))
    return LitEye(np.float32(agreed) * sky.seen, evenly.numpy())


def unoccluded(light: torch.Tensor) -> LitEye:
    """What reaches an eye of a light (1, h, 2h, 3) without any occlusion."""
    return LitEye(np.ones(light.shape[1:3], np.float32), mean_radiance(light[0].cpu().numpy()).astype(np.float32))


def _hidden_at(sky: EyeSky, surface: Surface, effects: Effects, reflected: torch.Tensor) -> float:
    """Share of the diffuse light that is hidden from an eye."""
    parts = surface.albedo, reflected, effects.specular, effects.shadow
    albedo, reflected, specular, shadow = (part[..., *sky.place] for part in parts)
    hidden = hidden_share(Effects(specular, shadow), grey(albedo * reflected[:, :3]), grey(reflected[:, 3:]))
    return float((hidden[0, 0].cpu().numpy() * sky.weights).sum())


def mirrored_light(cornea: Cornea, eye: LitEye, environment: Environment, yaw_deg: float) -> np.ndarray:
    """Radiance (E, E, 3) that an eye mirrors of a light of mean luminance 1, beyond the light's even part.

    Args:
        environment: the light, whose level is ignored.
        yaw_deg: its rotation.
    """
    across, down = cornea.mirrored_places
    turn = np.float32(without_whole_turns(yaw_deg) / 360)
    radiance = _looked_up(_mirrored_by(cornea, environment), across - turn, down)
    share = cornea.reflectance * _looked_up(eye.seen, across, down)
    finely = share[..., None] * np.maximum(radiance - eye.evenly, 0)
    size = len(cornea.bare)
    finely = resize_area(finely, (min(size, len(finely)),) * 2)
    seen = cv2.GaussianBlur(finely, (0, 0), max(_BLUR * len(finely), 0.5))
    if len(seen) < size:
        seen = cv2.resize(seen, (size, size), interpolation=cv2.INTER_LINEAR)
    return cornea.bare[..., None] * seen


def _weights(cornea: Cornea, view: Crop, size: int) -> np.ndarray:
    """The share of each pixel of a view that is iris, scaled to a sum of 1, (size, size) float32; 0 if none is."""
    iris = cornea.iris
    x, y = view.from_photo(np.array([iris.x, iris.y]), size) - 0.5
    place, radius = np.arange(size), max(iris.radius * size / view.side, 1.0)
    within = np.clip(radius + 0.5 - np.hypot(place[None, :] - x, place[:, None] - y), 0, 1)
    return (within / max(within.sum(), 1e-12)).astype(np.float32)


def _looked_up(panorama: np.ndarray, across: np.ndarray, down: np.ndarray) -> np.ndarray:
    """Bilinear look-up in a panorama, (h, w) or (h, w, 3).

    Args:
        across, down: shares of its width, which is periodic, and of its height.
    """
    height, width = panorama.shape[:2]
    wrapped = np.concatenate([panorama[:, -1:], panorama, panorama[:, :1]], axis=1).astype(np.float32)
    column, row = np.mod(across, 1) * width + 0.5, down * height - 0.5
    places = column.astype(np.float32), row.astype(np.float32)
    return cv2.remap(wrapped, *places, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
