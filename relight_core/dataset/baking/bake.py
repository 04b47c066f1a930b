"""Baking: from a head, once, everything that any light needs to light it.

Direct light is linear in the environment, so visibility toward each texel of the 16 x 32 light, with
normals, texture coordinates and labels, gives the image and all channels of the paper (section 3.2)
under any light by linear algebra (see `illumination`).
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from relight_core.dataset.baking.framing import Framing
from relight_core.dataset.baking.raycast import RayCaster
from relight_core.dataset.baking.scene import FROM_FACE_MAP, Material, Scene
from relight_core.dataset.painting.texture import look_up
from relight_core.face.parsing import FACE_LABELS
from relight_core.lighting.sphere import directions

LIGHT_HEIGHT, LIGHT_WIDTH = 16, 32
SKIN = (Material.FACE, Material.HEAD)
"""Materials with pores."""
FABRIC = (Material.HAT, Material.TRIM, Material.CLOTH)
"""Materials with threads."""
_OFFSET_CM = 0.03
_RAYS_AT_ONCE = 1 << 22


@dataclass(frozen=True)
class BakedHead:
    """Light transport of one head in one pose through one framing; P is the number of covered pixels.

    Attributes:
        covered: (S, S) bool; the arrays below list these pixels in row order.
        normal: (P, 3) float32 unit, camera space.
        depth: (P,) float32, +z toward the camera, in half-widths of the crop, 0 at the face's mean.
        uv: (P, 2) float32 in the material's own texture.
        material, label: (P,) uint8.
        visibility: (512, ceil(P / 8)) uint8, packed bits over pixels, one row per texel of the light; means nothing
            where the texel is below the pixel's horizon.
        albedo: (P, 3) float32 linear, of a scan; None where albedo is painted.
    """

    covered: np.ndarray
    normal: np.ndarray
    depth: np.ndarray
    uv: np.ndarray
    material: np.ndarray
    label: np.ndarray
    visibility: np.ndarray
    albedo: np.ndarray | None = None

    @property
    def size(self) -> int:
        """Side of the square image in pixels."""
        return self.covered.shape[0]

    def scatter(self, values: np.ndarray, background: float = 0.0) -> np.ndarray:
        """Per-pixel values (P, ...) laid out as an image (S, S, ...)."""
        image = np.full(self.covered.shape + values.shape[1:], background, values.dtype)
        image[self.covered] = values
        return image

    def visible(self) -> np.ndarray:
        """(512, P) bool: does each texel of the light see each pixel?"""
        return np.unpackbits(self.visibility, axis=1, count=len(self.normal)).view(bool)


def bake(scene: Scene, framing: Framing, face_labels: np.ndarray, size: int, rng: np.random.Generator) -> BakedHead:
    """Cast primary rays through the framing, then a shadow ray per pixel and texel toward a random place in it.

    Args:
        face_labels: label map of the face tile (see `face_map.face_label_map`).
        size: side of the image in pixels.
    """
    caster = RayCaster(scene)
    origin, toward = framing.rays(size)
    triangle, barycentric, distance = caster.closest(origin, toward)
    hit = triangle >= 0
    triangle, barycentric = triangle[hit], barycentric[hit]
    points = origin + toward[hit] * distance[hit][:, None]
    geometric, normal = _normals(scene, triangle, barycentric, -toward[hit])
    uv = np.einsum("pk,pkc->pc", barycentric, scene.corner_uv[triangle])
    label = _labels(scene.label[triangle], uv, face_labels)
    face = np.isin(label, FACE_LABELS)
    level = points[face, 2].mean() if face.any() else points[:, 2].mean()
    return BakedHead(
        covered=hit.reshape(size, size),
        normal=normal,
        depth=((points[:, 2] - level) / framing.half_width_cm).astype(np.float32),
        uv=uv.astype(np.float32),
        material=scene.material[triangle],
        label=label,
        visibility=_visibility(caster, points + geometric * _OFFSET_CM, normal, rng),
    )


def _normals(scene: Scene, triangle, barycentric, toward_camera):
    """Geometric and interpolated normals (P, 3), both turned to face the camera."""
    corners = scene.vertices[scene.triangles]
    scaled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    at_vertex = np.zeros_like(scene.vertices)
    for corner in range(3):
        np.add.at(at_vertex, scene.triangles[:, corner], scaled)
    smooth = np.einsum("pk,pkc->pc", barycentric, at_vertex[scene.triangles[triangle]])
    return _facing(scaled[triangle], toward_camera), _facing(smooth, toward_camera)


def _facing(normals: np.ndarray, toward_camera: np.ndarray) -> np.ndarray:
    normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    flip = np.einsum("pc,pc->p", normals, toward_camera) < 0
    return np.where(flip[:, None], -normals, normals).astype(np.float32)


def _labels(label: np.ndarray, uv: np.ndarray, face_labels: np.ndarray) -> np.ndarray:
    size = len(face_labels)
    x = np.clip((uv[:, 0] * size).astype(int), 0, size - 1)
    y = np.clip(((1 - uv[:, 1]) * size).astype(int), 0, size - 1)
    return np.where(label == FROM_FACE_MAP, face_labels[y, x], label).astype(np.uint8)


def _visibility(caster: RayCaster, points: np.ndarray, normal: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Packed (512, ceil(P / 8)) bits; texels below a pixel's own horizon are seen as the texel before them is.

    cos n.l makes those nothing; like this they compress best.
    """
    centres = directions(LIGHT_HEIGHT, LIGHT_WIDTH).reshape(-1, 3)
    # One direction for all pixels: a ray of its own for each would be noise, which nothing can compress and
    # which is farther from the mean over a texel than a hard edge in the right place is.
    toward = _jittered(np.arange(len(centres)), rng)
    count = len(points)
    visible = np.ones((len(centres), count), bool)
    batch = max(1, _RAYS_AT_ONCE // max(count, 1))
    for start in range(0, len(centres), batch):
        texels = np.arange(start, min(start + batch, len(centres)))
        facing = centres[texels] @ normal.T > 0
        texel, pixel = np.nonzero(facing)
        if len(texel):
            visible[texels[texel], pixel] = ~caster.occluded(points[pixel], toward[texels[texel]])
        for number, above_horizon in zip(texels, facing, strict=True):
            visible[number] = np.where(above_horizon, visible[number], visible[_before(number)])
    return np.packbits(visible, axis=1)


def _before(texel: int) -> int:
    """The texel to the left in its row, above at the start of a row; the first texel itself."""
    return texel - 1 if texel % LIGHT_WIDTH else max(texel - LIGHT_WIDTH, 0)


def _jittered(texel: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A random direction, uniform in solid angle, within each texel of the light. (N, 3) float32."""
    row, column = np.divmod(texel, LIGHT_WIDTH)
    top, bottom = np.cos(np.pi * row / LIGHT_HEIGHT), np.cos(np.pi * (row + 1) / LIGHT_HEIGHT)
    height = (top + (bottom - top) * rng.random(len(texel))).astype(np.float32)
    phi = (2 * np.pi * ((column + rng.random(len(texel))) / LIGHT_WIDTH - 0.5)).astype(np.float32)
    ring = np.sqrt(np.maximum(1 - height**2, 0))
    return np.stack([ring * np.sin(phi), height, -ring * np.cos(phi)], 1)


def add_relief(
    head: BakedHead,
    normal: np.ndarray,
    height_map: np.ndarray,
    strength: float,
    materials: tuple[int, ...] = SKIN,
    repeat: int = 1,
) -> np.ndarray:
    """Normals (P, 3) with pores, wrinkles or threads that the mesh lacks, tilted by a height map's slope on screen.

    Args:
        normal: (P, 3) unit normals to start from.
        height_map: (T, T) float32, about [-1, 1], looked up by texture coordinates times `repeat`.
        strength: tilt per unit of slope.
        materials: what it lies on.
    """
    heights = look_up(height_map, head.uv, repeat)
    image = head.scatter(heights)
    group = head.scatter(head.material + 1)
    down, right = np.gradient(image)
    inside = cv2.erode((cv2.morphologyEx(group, cv2.MORPH_GRADIENT, np.ones((3, 3))) == 0).astype(np.uint8), None)
    smooth = (inside[head.covered] > 0) & np.isin(head.material, materials)
    tilt = np.stack([-right[head.covered], down[head.covered], np.zeros(len(heights))], 1) * strength
    tilted = normal + np.clip(tilt, -0.4, 0.4) * smooth[:, None]
    return (tilted / np.linalg.norm(tilted, axis=1, keepdims=True)).astype(np.float32)
