"""How a surface reflects a light: Lambert and the GGX lobe, and both as tables over the normal.

With a distant camera the outgoing direction is +z everywhere, so what an unoccluded surface reflects under a given
light depends on its normal alone. A small table over the normals, made once per light, gives irradiance and gloss of
every pixel by one look-up.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
import torch.nn.functional as F

from relight_core.lighting.environment import NETWORK_HEIGHT
from relight_core.lighting.response import response_to
from relight_core.lighting.sphere import directions, solid_angles

TABLE_SIZE = 64
"""T, cells along a side of the table."""
_TABLE_EXTENT = 1.15
"""The table's axes reach from minus this to this; the silhouette, n_z = 0, is at a radius of 1."""


@dataclass(frozen=True)
class Gloss:
    """The principled BSDF's dielectric lobe: `specular` 0.5 is an F0 of 4 %, alpha is roughness squared."""

    specular: float = 0.6
    roughness: float = 0.5


GLOSS = Gloss()
"""The paper's values (section 3.2)."""


def specular_lobe(toward_light: torch.Tensor, normal: torch.Tensor, gloss: Gloss = GLOSS) -> torch.Tensor:
    """BRDF times cos(n, l) of the isotropic GGX lobe, viewed from +z (Walter et al. 2007; Burley 2012).

    Half-vectors need no array of their own: n.h = (n.v + n.l) / |v + l| and v.h = (1 + v.l) / |v + l|.

    Args:
        toward_light: (J, 3) unit vectors.
        normal: (P, 3) unit vectors.

    Returns:
        (J, P), 1 / sr; 0 where the light is below the horizon.
    """
    alpha2 = gloss.roughness**4
    f0 = 0.08 * gloss.specular
    n_l = toward_light @ normal.T
    n_v = normal[:, 2].clamp_min(0.05)[None]
    length = (2 + 2 * toward_light[:, 2:3]).clamp_min(1e-6).sqrt()
    n_h = ((n_v + n_l) / length).clamp(0, 1)
    v_h = (length / 2).clamp(0, 1)
    distribution = alpha2 / (torch.pi * (n_h.square() * (alpha2 - 1) + 1).square())
    fresnel = f0 + (1 - f0) * (1 - v_h).pow(5)
    lit = n_l.clamp_min(0)
    masking_l = 1 / (lit + (alpha2 + (1 - alpha2) * lit.square()).sqrt())
    masking_v = 1 / (n_v + (alpha2 + (1 - alpha2) * n_v.square()).sqrt())
    return distribution * fresnel * masking_l * masking_v * lit


def network_texels() -> tuple[torch.Tensor, torch.Tensor]:
    """Unit vectors (texels, 3) to the texels of the networks' light, and their solid angles (texels,)."""
    size = NETWORK_HEIGHT, 2 * NETWORK_HEIGHT
    parts = directions(*size).reshape(-1, 3), solid_angles(*size).reshape(-1)
    return tuple(torch.from_numpy(part) for part in parts)


class ReflectionTable(torch.nn.Module):
    """Irradiance / pi and gloss of an unoccluded surface, looked up by its normal.

    The table's axes are the Lambert azimuthal equal-area coordinates (n_x, n_y) / sqrt(1 + n_z), smooth
    over the silhouette. Everything stays in fp32: bright suns lose 3 % in bf16.
    """

    def __init__(self):
        super().__init__()
        toward, weights = network_texels()
        normals = _table_normals(TABLE_SIZE)
        diffuse = (toward @ normals.T).clamp_min(0) / torch.pi
        lobe = specular_lobe(toward, normals, GLOSS)
        self.register_buffer("transport", torch.cat([diffuse, lobe], 1) * weights[:, None], persistent=False)

    def tabulate(self, light: torch.Tensor) -> torch.Tensor:
        """Light (B, 16, 32, 3), linear radiance, to a table (B, 6, T, T): irradiance rgb, gloss rgb."""
        batch = light.shape[0]
        flat = light.float().reshape(batch, -1, 3).permute(0, 2, 1)
        with torch.autocast(light.device.type, enabled=False):
            both = (flat @ self.transport).reshape(batch, 3, 2, TABLE_SIZE, TABLE_SIZE)
        return both.permute(0, 2, 1, 3, 4).reshape(batch, 6, TABLE_SIZE, TABLE_SIZE)

    def look_up(self, table: torch.Tensor, normal: torch.Tensor) -> torch.Tensor:
        """Values (B, 6, H, W) at unit normals (B, 3, H, W)."""
        with torch.autocast(normal.device.type, enabled=False):
            # On a CPU grid_sample writes its gradient wherever NaN points to: a bad batch would end the process.
            position = table_position(normal.float()).nan_to_num()
            return F.grid_sample(table, position, mode="bilinear", padding_mode="border", align_corners=True)

    def forward(self, light: torch.Tensor, normal: torch.Tensor) -> torch.Tensor:
        """`look_up` in the table of `light`."""
        return self.look_up(self.tabulate(light), normal)


class NormalLookup:
    """Look-ups at the same normals under many lights: of each light's table only the cells they read are computed."""

    def __init__(self, table: ReflectionTable, normal: torch.Tensor, *, gloss: bool = True):
        """Find the cells that the normals read.

        Args:
            table: whose `transport` is used.
            normal: (1, 3, H, W) unit vectors.
            gloss: if False, only the irradiance is looked up.
        """
        self._position = table_position(normal.float())
        self._cells = _cells_read(self._position)
        parts = 2 if gloss else 1
        transport = table.transport.reshape(-1, 2, TABLE_SIZE**2)[:, :parts]
        self._transport = transport[:, :, self._cells].flatten(1)
        self._parts = parts

    def __call__(self, light: torch.Tensor) -> torch.Tensor:
        """As `ReflectionTable.forward` under a light (1, 16, 32, 3): (1, 6, H, W), or (1, 3, H, W) without gloss."""
        with torch.autocast(light.device.type, enabled=False):
            read = response_to(light.float().reshape(-1, 3).T, self._transport)
        table = read.new_zeros(self._parts, 3, TABLE_SIZE**2)
        table[:, :, self._cells] = read.reshape(3, self._parts, -1).transpose(0, 1)
        table = table.reshape(1, 3 * self._parts, TABLE_SIZE, TABLE_SIZE)
        return F.grid_sample(table, self._position, mode="bilinear", padding_mode="border", align_corners=True)


def _cells_read(position: torch.Tensor) -> torch.Tensor:
    """Indices of the table's cells that bilinear lookups at positions (1, H, W, 2) touch."""
    place = ((position.reshape(-1, 2) + 1) / 2 * (TABLE_SIZE - 1)).clamp(0, TABLE_SIZE - 1)
    first = place.floor().long()
    # One more cell on each side, since grid_sample may round differently.
    touched = torch.zeros(TABLE_SIZE, TABLE_SIZE, dtype=torch.bool, device=position.device)
    for down in range(-1, 3):
        for right in range(-1, 3):
            x, y = ((first[:, axis] + step).clamp(0, TABLE_SIZE - 1) for axis, step in ((0, right), (1, down)))
            touched[y, x] = True
    return touched.flatten().nonzero()[:, 0]


def table_position(normal: torch.Tensor) -> torch.Tensor:
    """Where unit normals (B, 3, H, W) lie in the table, in grid_sample's coordinates: (B, H, W, 2) in [-1, 1]."""
    scale = (1 + normal[:, 2:3]).clamp_min(0.1).rsqrt() / _TABLE_EXTENT
    return (normal[:, :2] * scale).permute(0, 2, 3, 1)


def _table_normals(size: int) -> torch.Tensor:
    """The unit normals (size * size, 3) of the table's cells, the inverse of `table_position`."""
    axis = torch.linspace(-_TABLE_EXTENT, _TABLE_EXTENT, size)
    b, a = torch.meshgrid(axis, axis, indexing="ij")
    radius2 = (a.square() + b.square()).clamp_max(2)
    scale = (2 - radius2).sqrt()
    return F.normalize(torch.stack([a * scale, b * scale, 1 - radius2], -1).reshape(-1, 3), dim=1)
