"""Interreflection: one bounce of light from the surface that the camera sees onto parts of itself.

Networks and relief only model direct light. That is not enough in an eye socket beside a nose that is lit from the
side: skin reflects more than half of the light, and the corner of the eye faces it directly.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
import torch.nn.functional as F

_SOURCES = 32
"""Cells along a side of the image from which light is gathered."""
_NEAREST = 0.75
"""In widths of a source cell: no distance counts as less. A nearer cell surrounds the point it lights, and the form
factor of two points would grow without bound."""


@dataclass(frozen=True, eq=False)
class Bounce:
    """The linear map from a surface's irradiance to the light that it reflects onto some of its own pixels.

    Attributes:
        places: (R,) indices of the receiving pixels in the flattened image.
        sources: (C,) indices of those of the image's 32 * 32 cells that contain some surface.
        weights: (R, C) share of what each source cell sends out that reaches each receiving pixel: form factors
            (cosine * cosine * area over pi r^2).
        reflecting: (1, 3, 32, 32) albedo, 0 beside the surface.
    """

    places: torch.Tensor
    sources: torch.Tensor
    weights: torch.Tensor
    reflecting: torch.Tensor

    def add_to(self, irradiance: torch.Tensor) -> torch.Tensor:
        """Irradiance over pi (1, 3, S, S), with the bounce added; shadows on the surroundings are ignored."""
        return irradiance + self.of(irradiance) if len(self.places) else irradiance

    def of(self, irradiance: torch.Tensor) -> torch.Tensor:
        """The bounce alone, in the units and shape of the surface's irradiance over pi, (1, 3, S, S)."""
        result = irradiance.new_zeros(irradiance.shape)
        sent = F.interpolate(irradiance, size=_SOURCES, mode="area") * self.reflecting
        result.flatten(2)[0, :, self.places] = (self.weights @ sent[0].flatten(1)[:, self.sources].T).T
        return result


@torch.no_grad()
def gather_bounce(
    normal: torch.Tensor, relief: torch.Tensor, albedo: torch.Tensor, person: torch.Tensor, receives: torch.Tensor
) -> Bounce:
    """Form factors between the pixels that receive and coarse cells of the whole surface.

    Args:
        normal: (1, 3, S, S) unit vectors, camera space.
        relief: (1, 1, S, S) height toward the camera, in half-widths of the image.
        albedo: (1, 3, S, S) linear.
        person: (1, 1, S, S) in [0, 1], where there is a surface.
        receives: (S, S) in [0, 1], the share of its bounce that each pixel is given.
    """
    places = (receives.flatten() > 0.02).nonzero()[:, 0]
    small = (F.interpolate(image, size=_SOURCES, mode="area") for image in (normal, relief, albedo, person))
    cell_normal, cell_relief, cell_albedo, cell_person = small
    here, facing = points_of(relief)[places], normal[0].flatten(1).T[places]
    sources = (cell_person.flatten() > 0).nonzero()[:, 0]
    there, away = points_of(cell_relief)[sources], F.normalize(cell_normal, dim=1)[0].flatten(1).T[sources]
    weights = form_factors(here, facing, there, away, 2.0 / _SOURCES)
    weights *= receives.flatten()[places, None] / weights.sum(1, keepdim=True).clamp_min(1)
    return Bounce(places, sources, weights, cell_albedo * cell_person)


def form_factors(
    here: torch.Tensor, facing: torch.Tensor, there: torch.Tensor, away: torch.Tensor, width: float
) -> torch.Tensor:
    """Form factors from cells of a surface to points, (R, C): cosine * cosine * area over pi r^2.

    Args:
        here, facing: (R, 3) receiving points and the unit normals there.
        there, away: (C, 3) centres of the source cells and their unit normals.
        width: of a cell as the camera sees it, in the points' units.
    """
    # Axis by axis: PyTorch takes twice as long with an array whose last dimension is 3.
    between = [there[:, axis] - here[:, axis, None] for axis in range(3)]
    leaving = -sum(way * normal for way, normal in zip(between, away.T, strict=True))
    arriving = sum(way * normal[:, None] for way, normal in zip(between, facing.T, strict=True))
    squared = sum(way.square() for way in between).clamp_min(1e-12)
    area = width * width / away[:, 2].clamp_min(0.25)
    beyond = torch.pi * squared * squared.clamp_min((_NEAREST * width) ** 2)
    return leaving.clamp_min(0) * arriving.clamp_min(0) * area / beyond


def points_of(relief: torch.Tensor) -> torch.Tensor:
    """A relief (1, 1, S, S) as points (S * S, 3) in camera space, where the view reaches from -1 to 1."""
    size = relief.shape[-1]
    axis = (torch.arange(size, device=relief.device) + 0.5) / size * 2 - 1
    y, x = torch.meshgrid(axis, axis, indexing="ij")
    return torch.stack([x, -y, relief[0, 0]], -1).flatten(0, 1)
