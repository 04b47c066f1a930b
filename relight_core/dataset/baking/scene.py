"""One dressed head as triangles, with what each triangle is made of."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from relight_core.dataset.face_map import region_labels
from relight_core.dataset.garments.dressing import Garment
from relight_core.dataset.heads import HeadModel, pose
from relight_core.face.parsing import INDEX

FROM_FACE_MAP = 255
"""A triangle label that means: look the label up in the face label map by texture coordinate."""


class Material(IntEnum):
    """What a surface is made of; decides how its albedo is painted."""

    FACE = 0
    HEAD = 1
    MOUTH = 2
    TEETH = 3
    SCLERA = 4
    IRIS = 5
    HAIR = 6
    HAT = 7
    GLASSES = 8
    CLOTH = 9
    BROW = 10
    TRIM = 11


_REGION_MATERIALS = {
    "face": Material.FACE,
    "teeth": Material.TEETH,
    "mouth_socket": Material.MOUTH,
    "gums_tongue": Material.MOUTH,
    "sclera_L": Material.SCLERA,
    "sclera_R": Material.SCLERA,
    "iris_L": Material.IRIS,
    "iris_R": Material.IRIS,
}
_GARMENT_MATERIALS = {
    "hair": Material.HAIR,
    "hat": Material.HAT,
    "glasses": Material.GLASSES,
    "cloth": Material.CLOTH,
    "brow": Material.BROW,
    "trim": Material.TRIM,
    "lash": Material.BROW,
    "neck": Material.HEAD,
}
# Of these garments the person's left and right are labelled apart.
_SIDED = {"brow": ("left_brow", "right_brow"), "lash": ("left_eye", "right_eye")}


@dataclass(frozen=True)
class Scene:
    """Triangles in camera space, centimetres.

    Attributes:
        vertices: (V, 3) float32.
        triangles: (F, 3) int64.
        corner_uv: (F, 3, 2) float32, fraction within the triangle's own texture.
        material: (F,) uint8, a `Material`.
        label: (F,) uint8, a parsing label or `FROM_FACE_MAP`.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    corner_uv: np.ndarray
    material: np.ndarray
    label: np.ndarray


def build_scene(model: HeadModel, head_vertices: np.ndarray, garments: list[Garment], rotation: np.ndarray) -> Scene:
    """Put the garments on the head and turn everything by the head's rotation (3, 3)."""
    head = _head_scene(model, pose(head_vertices, rotation))
    parts = [head] + [_garment_scene(g, rotation) for g in garments if g.label in _GARMENT_MATERIALS]
    offsets = np.cumsum([0] + [len(part.vertices) for part in parts[:-1]])
    return Scene(
        vertices=np.concatenate([part.vertices for part in parts]),
        triangles=np.concatenate([p.triangles + o for p, o in zip(parts, offsets, strict=True)]),
        corner_uv=np.concatenate([part.corner_uv for part in parts]),
        material=np.concatenate([part.material for part in parts]),
        label=np.concatenate([part.label for part in parts]),
    )


def _head_scene(model: HeadModel, vertices: np.ndarray) -> Scene:
    materials = np.array([_REGION_MATERIALS.get(n, Material.HEAD) for n in model.region_names], np.uint8)
    material, label = materials[model.triangle_region], region_labels(model)[model.triangle_region]
    corner_uv = model.uv[model.triangles_uv]
    beyond_face_tile = (material == Material.FACE) & (corner_uv[..., 0].max(1) > 1)
    return Scene(
        vertices=vertices,
        triangles=model.triangles,
        corner_uv=(corner_uv % 1.0).astype(np.float32),
        material=np.where(beyond_face_tile, Material.HEAD, material).astype(np.uint8),
        label=np.where(beyond_face_tile, INDEX["neck"], label).astype(np.uint8),
    )


def _garment_scene(garment: Garment, rotation: np.ndarray) -> Scene:
    vertices = pose(garment.vertices, rotation)
    count = len(garment.faces)
    if garment.label in _SIDED:
        left, right = (INDEX[name] for name in _SIDED[garment.label])
        right_of_image = garment.vertices[garment.faces[:, 0], 0] > 0
        label = np.where(right_of_image, left, right).astype(np.uint8)
    else:
        label = np.full(count, INDEX[garment.label], np.uint8)
    return Scene(
        vertices=vertices,
        triangles=garment.faces.astype(np.int64),
        corner_uv=garment.uv[garment.faces].astype(np.float32),
        material=np.full(count, _GARMENT_MATERIALS[garment.made_of or garment.label], np.uint8),
        label=label,
    )
