"""Cast shadows from geometry: which part of a light a relief lets through to each of its points.

The relief that de-lighting predicts is a height field seen from the camera. Its horizons are marched once, in many
directions of the image plane (horizon mapping: Max 1988). They give each point's response to every texel of a light,
so that the shadow under any light is a matrix product. What the camera doesn't see casts no shadow here, and what it
does see is taken to extend back without end; the SS network corrects both.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import torch
import torch.nn.functional as F

from relight_core.imaging.tensor_colour import luminance_weights
from relight_core.lighting.reflection import network_texels, specular_lobe
from relight_core.lighting.response import response_to

_AZIMUTHS = 48
"""Directions of the image plane, evenly spaced, in which horizons are marched."""
_STEPS = 20
"""Samples along each march."""
_PENUMBRA = 0.15
"""Radians of elevation, centred on the horizon, over which a texel of 11 degrees goes from hidden to visible."""
_GRAZING, _FAINT_GLOSS = 0.05, 0.005
"""Irradiance over pi, and gloss, under a light of mean luminance 1, below which the lost fraction fades to 0."""
REACH = 1.3
"""Length of a march in half-widths of the image: as far as a head casts a shadow on itself."""

BIAS = 0.002
"""Half-widths of the image by which something must stand out to hide anything, so that pixels' own steps don't."""

NOTHING = -1e3
"""The height, in half-widths of the image, where nothing casts a shadow."""


@dataclass(frozen=True)
class ReliefTransport:
    """Response of every point of a relief to every texel of a light, before albedo.

    As in precomputed radiance transfer (Sloan, Kautz and Snyder 2002), with and without the relief's own shadows.

    Attributes:
        unshadowed: (S * S, texels) cos(n, l) times solid angle over pi; 0 beside the surface.
        shadowed: the same times the visibility of the texel, [0, 1].
        size: S, pixels along a side of the relief.
        normal: (S * S, 3) unit vectors, which only `gloss_fraction` needs; None if that is never called.
    """

    unshadowed: torch.Tensor
    shadowed: torch.Tensor
    size: int
    normal: torch.Tensor | None = None

    def shadow_fraction(self, light: torch.Tensor) -> torch.Tensor:
        """Fraction of the unoccluded grey irradiance that is lost: (B, 1, S, S) in [0, 1].

        It fades to 0 where the light only grazes the surface. There is next to nothing to lose there, and the fraction
        of it would flip between 0 and 1 while a lamp sets.

        Args:
            light: (B, H, 2H, 3) normalised radiance of the texels the transport was made for.
        """
        return self._lost(light, self._at_surface, _GRAZING)

    def gloss_fraction(self, light: torch.Tensor) -> torch.Tensor:
        """Fraction of the unoccluded grey gloss that is lost: (B, 1, S, S) in [0, 1].

        It differs from `shadow_fraction`: if a lamp behind the head, which would only graze the side of a nose, is
        hidden from it, that takes a small share of the irradiance there and a large one of the gloss.

        Args:
            light: as of `shadow_fraction`.
        """
        return self._lost(light, self._gloss_at_surface, _FAINT_GLOSS)

    def _lost(self, light: torch.Tensor, at_surface: tuple[torch.Tensor, torch.Tensor], least: float) -> torch.Tensor:
        """Fraction that occlusion takes of a quantity, fading to 0 where the quantity is less than `least`.

        Args:
            at_surface: its transport, from `_at_surface` or `_gloss_at_surface`.
        """
        light = light.float()
        grey = light @ luminance_weights(light)
        points, both = at_surface
        unshadowed, shadowed = (grey.flatten(1) @ both).chunk(2, dim=1)
        lost = (1 - shadowed / unshadowed.clamp_min(1e-6)).clamp(0, 1) * (unshadowed / least).clamp_max(1)
        fraction = lost.new_zeros(len(lost), len(self.unshadowed))
        fraction[:, points] = lost
        return fraction.reshape(-1, 1, self.size, self.size)

    def visibility(self, grey: torch.Tensor, size: int) -> torch.Tensor:
        """Share of each light's irradiance that reaches each point, (B, 1, size, size) in [0, 1]; 1 if it gives none.

        Args:
            grey: (B, H, 2H) radiance of the texels the transport was made for.
            size: pixels along a side of the result.
        """
        points, both = self._at_surface
        field = torch.zeros(len(grey), 2, len(self.unshadowed))
        for answer, light in zip(field, grey.float().flatten(1), strict=True):
            answer[:, points] = response_to(light[None], both)[0].unflatten(0, (2, -1))
        # Upsampled before the division. Otherwise points that face away would leak into the edge of those that don't.
        field = field.unflatten(2, (self.size, self.size))
        unshadowed, shadowed = F.interpolate(field, size=size, mode="bilinear", align_corners=False).chunk(2, 1)
        return torch.where(unshadowed > 1e-6, shadowed / unshadowed.clamp_min(1e-6), 1.0)

    @cached_property
    def _at_surface(self) -> tuple[torch.Tensor, torch.Tensor]:
        """Indices (P,) of the points with a surface, and their `unshadowed` and `shadowed` side by side, (texels, 2 P).

        One row for each texel, so that a light with few lit texels reads few rows (see `response_to`).
        """
        points = self.unshadowed.any(dim=1).nonzero()[:, 0]
        return points, torch.cat([self.unshadowed[points], self.shadowed[points]]).T.contiguous()

    @cached_property
    def _gloss_at_surface(self) -> tuple[torch.Tensor, torch.Tensor]:
        """As `_at_surface`, for the gloss of skin instead of irradiance."""
        points = self.unshadowed.any(dim=1).nonzero()[:, 0]
        toward, weight = (part.to(self.unshadowed.device) for part in network_texels())
        gloss = specular_lobe(toward, self.normal[points]).T * weight
        visible = (self.shadowed[points] / self.unshadowed[points].clamp_min(1e-12)).clamp_max(1)
        return points, torch.cat([gloss, gloss * visible]).T.contiguous()


def march_relief(relief: torch.Tensor, normal: torch.Tensor, covered: torch.Tensor) -> ReliefTransport:
    """`march_reliefs` for one surface, without the leading axis."""
    return march_reliefs(relief[None], normal[None], covered[None])[0]


@torch.no_grad()
def march_reliefs(relief: torch.Tensor, normal: torch.Tensor, covered: torch.Tensor) -> list[ReliefTransport]:
    """March the horizons of reliefs in all directions of the image plane, and compare each texel with its horizon.

    Args:
        relief: (B, S, S) height toward the camera, in half-widths of the image.
        normal: (B, 3, S, S) unit vectors, camera space.
        covered: (B, S, S) in [0, 1]: where there is a surface; elsewhere nothing casts a shadow.
    """
    angle = torch.arange(_AZIMUTHS, device=relief.device) * (2 * torch.pi / _AZIMUTHS)
    horizons = horizon_slopes(relief.float(), covered, angle).atan().transpose(0, 1)
    parts = zip(horizons, normal, covered, strict=True)
    return [_transport(*part) for part in parts]


def _transport(horizon: torch.Tensor, normal: torch.Tensor, covered: torch.Tensor) -> ReliefTransport:
    """The transport of one surface.

    Args:
        horizon: (azimuths, S, S) elevations in radians.
        normal: (3, S, S).
        covered: (S, S).
    """
    size = horizon.shape[-1]
    toward, weight = (part.to(horizon.device) for part in network_texels())
    normal = normal.float().flatten(1).T.contiguous()
    cosine = (normal @ toward.T).clamp_min(0)
    unshadowed = cosine * weight / torch.pi * (covered > 0.5).flatten()[:, None]
    horizon = horizon.flatten(1)
    across = toward[:, :2].norm(dim=1).clamp_min(1e-4)
    elevation = torch.atan2(toward[:, 2], across)
    turn = torch.atan2(toward[:, 1], toward[:, 0]) / (2 * torch.pi) * _AZIMUTHS
    first = turn.floor()
    blend = (turn - first)[:, None]
    before, after = (horizon[(first.long() + step) % _AZIMUTHS] for step in (0, 1))
    above = elevation[:, None] - (before + (after - before) * blend)
    visible = (above / _PENUMBRA + 0.5).clamp(0, 1).T
    return ReliefTransport(unshadowed, unshadowed * visible, size, normal)


def _march_distances(size: int, steps: int) -> list[float]:
    """Distances from a point at which its horizon is sampled, in half-widths of an image of `size` pixels.

    They begin at about the next pixel and grow further apart, since near a point even small steps hide light.
    """
    return [2.0 / size + REACH * (step / steps) ** 1.8 for step in range(1, steps + 1)]


def horizon_slopes(relief: torch.Tensor, covered: torch.Tensor, azimuth_rad: torch.Tensor) -> torch.Tensor:
    """Slope over the image plane up to which each point's sky is hidden, (azimuths, B, S, S); differentiable.

    Azimuth 0 is +x, pi / 2 is +y. A relief extends back without end: it hides everything behind it.

    Args:
        relief: (B, S, S) height toward the camera, in half-widths of the image.
        covered: (B, S, S) in [0, 1]: where there is a surface; elsewhere nothing casts a shadow.
        azimuth_rad: (azimuths,) directions in which to look from every point.
    """
    size = relief.shape[-1]
    height = torch.where(covered > 0.5, relief, torch.full_like(relief, NOTHING))
    axis = (torch.arange(size, device=relief.device) + 0.5) / size * 2 - 1
    grid = torch.stack(torch.meshgrid(axis, axis, indexing="xy"), -1)
    step = torch.stack([azimuth_rad.cos(), -azimuth_rad.sin()], -1)
    field = height.expand(len(azimuth_rad), *height.shape)
    steepest = torch.full_like(field, NOTHING)
    for distance in _march_distances(size, _STEPS):
        position = grid + (distance * step)[:, None, None]
        sampled = F.grid_sample(field, position, mode="bilinear", padding_mode="border", align_corners=False)
        across, down = ((axis + distance * along[:, None]).abs() < 1 for along in step.unbind(-1))
        inside = (across[:, None] & down[:, :, None])[:, None]
        steepest = torch.maximum(steepest, torch.where(inside, (sampled - relief - BIAS) / distance, NOTHING))
    return steepest
