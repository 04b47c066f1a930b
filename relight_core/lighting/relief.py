"""Cast shadow from geometry: which part of the light a relief lets through to each of its points.

The relief that de-lighting predicts is a height field seen from the camera. Marching it once toward
every texel of the light gives each pixel's response to light; from then on the shadow under any light is
a matrix product. What the camera does not see casts no shadow here: the SS network corrects that.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
import torch.nn.functional as F

from relight_core.lighting.sphere import directions, solid_angles

_BIAS = 0.008
_THICKNESS = 0.9
_DIRECTIONS_AT_ONCE = 64


@dataclass(frozen=True)
class ReliefTransport:
    """Response of every point of a relief to every texel of a light, before albedo.

    Attributes:
        open: (S * S, texels) cos(n, l) times solid angle over pi, no occlusion.
        closed: the same times visibility.
        size: S.
    """

    open: torch.Tensor
    closed: torch.Tensor
    size: int

    def shadow_fraction(self, light: torch.Tensor) -> torch.Tensor:
        """Fraction of the unoccluded grey irradiance that is lost: (B, 1, S, S) in [0, 1].

        Args:
            light: (B, H, 2H, 3) of the texels the transport was made for.
        """
        grey = light.float() @ torch.tensor([0.2126, 0.7152, 0.0722])
        grey = grey.flatten(1).T
        opened = self.open @ grey
        fraction = torch.where(opened > 1e-6, 1 - (self.closed @ grey) / opened.clamp_min(1e-6), 0.0)
        return fraction.clamp(0, 1).T.reshape(-1, 1, self.size, self.size)


@torch.no_grad()
def march_relief(
    relief: torch.Tensor, normal: torch.Tensor, covered: torch.Tensor, light_height: int = 16, steps: int = 28
) -> ReliefTransport:
    """March a relief toward every texel of a lat-long light.

    Args:
        relief: (S, S) height toward the camera, in half-widths of the image.
        normal: (3, S, S) unit vectors, camera space.
        covered: (S, S) in [0, 1]: where there is a surface; elsewhere nothing casts a shadow.
        light_height: rows of the light.
        steps: samples along each ray; they lie closer together near the point.
    """
    size = relief.shape[-1]
    toward = torch.from_numpy(directions(light_height, 2 * light_height).reshape(-1, 3))
    weight = torch.from_numpy(solid_angles(light_height, 2 * light_height).reshape(-1))
    cosine = (normal.float().flatten(1).T @ toward.T).clamp_min(0)
    opened = cosine * weight / torch.pi * (covered > 0.5).flatten()[:, None]
    height = torch.where(covered > 0.5, relief.float(), torch.full_like(relief, -1e3, dtype=torch.float32))
    visible = torch.ones_like(opened)
    for start in range(0, len(toward), _DIRECTIONS_AT_ONCE):
        part = slice(start, start + _DIRECTIONS_AT_ONCE)
        if float(cosine[:, part].max()) > 0:
            visible[:, part] = _march(height, relief.float(), toward[part], size, steps)
    return ReliefTransport(opened, opened * visible, size)


def _march(height: torch.Tensor, start: torch.Tensor, toward: torch.Tensor, size: int, steps: int) -> torch.Tensor:
    """Visibility (S * S, D) along D directions."""
    axis = (torch.arange(size) + 0.5) / size * 2 - 1
    y, x = torch.meshgrid(axis, axis, indexing="ij")
    count = len(toward)
    field = height.expand(count, 1, size, size)
    blocked = torch.zeros(count, size, size)
    step_x, step_y, step_z = (toward[:, i, None, None] for i in range(3))
    # A ray that climbs fast leaves the relief's range soon: no need to walk to the border.
    reach = torch.minimum(torch.full_like(step_z, 1.4), 1.2 / step_z.clamp_min(0.2))
    for step in range(1, steps + 1):
        distance = reach * (step / steps) ** 1.6 + 1.0 / size
        position = torch.stack([(x + distance * step_x).expand(count, -1, -1), y - distance * step_y], -1)
        sampled = F.grid_sample(field, position, mode="bilinear", padding_mode="border", align_corners=False)[:, 0]
        gap = sampled - (start + distance * step_z)
        softness = 1.5 / size + 0.06 * distance
        inside = position.abs().amax(-1) < 1
        hit = ((gap - _BIAS) / softness + 0.5).clamp(0, 1) * (inside & (gap < _THICKNESS))
        blocked = torch.maximum(blocked, hit)
    return 1 - blocked.flatten(1).T
