"""A researcher's own scanned heads: a folder of meshes with albedo and label pictures.

    scans/
      anna/                       one sub-folder per person
        smile.obj                 triangles or polygons with texture coordinates
        smile.albedo.png          reflectance, sRGB-encoded (or linear, as .exr)
        smile.labels.png          8-bit grey, one label of `face.parsing.CLASSES` per texel
      ben/ ...

Units and axes: centimetres, +y up, the face toward +z. Where the head stands does not matter. Any size of
picture does; pictures named after the folder ("anna.albedo.png") serve all of a person's meshes.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from relight_core.dataset.baking.scene import Material
from relight_core.errors import InputError
from relight_core.face.parsing import CLASSES, FACE_LABELS, INDEX
from relight_core.imaging.read import read_photo
from relight_core.imaging.resampling import resize_area

_TEXTURE_SIZE = 1024
_ALBEDO_SUFFIXES = (".albedo.png", ".albedo.jpg", ".albedo.tif", ".albedo.exr")
_LABELS_SUFFIX = ".labels.png"
_SMALLEST_FACE_CM, _LARGEST_FACE_CM = 8.0, 40.0
# Where a head model's face has its middle, so that both turn about the same neck.
_FACE_MIDDLE_CM = np.array([0.0, -1.0, 10.0], np.float32)
_SPLIT_SEED = 8
_TEST_PEOPLE = 8
_VALIDATION_PEOPLE = 8
_MATERIALS = {
    "inner_mouth": Material.MOUTH,
    "left_eye": Material.SCLERA,
    "right_eye": Material.SCLERA,
    "left_brow": Material.BROW,
    "right_brow": Material.BROW,
    "hair": Material.HAIR,
    "hat": Material.HAT,
    "glasses": Material.GLASSES,
    "cloth": Material.CLOTH,
}
_MATERIAL_OF = np.array([_MATERIALS.get(name, Material.FACE) for name in CLASSES], np.uint8)


@dataclass(frozen=True)
class Scan:
    """One mesh of one person, in centimetres, moved to where a head model's face is.

    Attributes:
        vertices: (V, 3) float32.
        triangles: (F, 3) int64.
        corner_uv: (F, 3, 2) float32 in [0, 1], v up.
        material: (F,) uint8, a `Material`.
        labels: (T, T) uint8 parsing labels, row 0 is v = 1.
        albedo: (T, T, 3) float32 linear.
        face: indices of the vertices of the face proper.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    corner_uv: np.ndarray
    material: np.ndarray
    labels: np.ndarray
    albedo: np.ndarray
    face: np.ndarray


def people_of(folder: Path, split: str) -> list[list[Path]]:
    """The meshes of every person of a split: "train", "validation" or "test".

    Test and validation have 8 people each, but no more than a fifth of all.

    Raises:
        InputError: no scans, or too few people for this split to have any.
    """
    people = _everybody(folder)
    test, validation = (min(most, len(people) // 5) for most in (_TEST_PEOPLE, _VALIDATION_PEOPLE))
    order = np.random.default_rng(_SPLIT_SEED).permutation(len(people))
    ends = {"test": (0, test), "validation": (test, test + validation), "train": (test + validation, len(people))}
    first, last = ends[split]
    if first == last:
        raise InputError(f"{folder}: too few people for the {split} split to have any; scan at least five")
    return [people[i] for i in order[first:last]]


def names_of_people(folder: Path) -> list[str]:
    """Everybody's name, the scans' folders, in order; who is in which split follows from them.

    Raises:
        InputError: no scans.
    """
    return [meshes[0].parent.name for meshes in _everybody(folder)]


def _everybody(folder: Path) -> list[list[Path]]:
    people = [sorted(person.glob("*.obj")) for person in sorted(folder.iterdir()) if person.is_dir()]
    people = [meshes for meshes in people if meshes]
    if not people:
        raise InputError(f"{folder}: no scans here; put each person's .obj files into a sub-folder of it")
    return people


def read_scan(path: Path) -> Scan:
    """Read a mesh with its pictures.

    Raises:
        InputError: a file is missing or damaged, or the mesh is no head of the right size.
    """
    labels = _labels(_beside(path, (_LABELS_SUFFIX,)))
    picture = _beside(path, _ALBEDO_SUFFIXES)
    albedo = resize_area(np.clip(read_photo(picture).linear, 0, 1), (_TEXTURE_SIZE, _TEXTURE_SIZE))
    vertices, triangles, corner_uv = _read_mesh(path)
    middle = corner_uv.mean(1)
    label = _at(labels, middle)
    face = np.unique(triangles[np.isin(label, FACE_LABELS)])
    if len(face) == 0:
        raise InputError(f"{path}: no triangle has a label of the face; check {_LABELS_SUFFIX} and the coordinates")
    low, high = vertices[face].min(0), vertices[face].max(0)
    height_cm = float(high[1] - low[1])
    if not _SMALLEST_FACE_CM <= height_cm <= _LARGEST_FACE_CM:
        raise InputError(f"{path}: a face {height_cm:g} high; scale the mesh to centimetres, +y up")
    return Scan(
        vertices=(vertices - (low + high) / 2 + _FACE_MIDDLE_CM).astype(np.float32),
        triangles=triangles,
        corner_uv=corner_uv,
        material=_MATERIAL_OF[label],
        labels=labels,
        albedo=np.ascontiguousarray(albedo, np.float32),
        face=face,
    )


def _beside(path: Path, suffixes: tuple[str, ...]) -> Path:
    """The picture of a mesh, or of its person."""
    for stem in (path.stem, path.parent.name):
        for suffix in suffixes:
            if (path.parent / f"{stem}{suffix}").is_file():
                return path.parent / f"{stem}{suffix}"
    raise InputError(f"{path}: no {path.stem}{suffixes[0]} beside it; a scan needs that picture")


def _labels(path: Path) -> np.ndarray:
    try:
        labels = np.asarray(Image.open(path))
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: can't be read as a picture of labels ({error}); save it as 8-bit grey") from error
    if labels.ndim != 2 or labels.dtype != np.uint8 or labels.max() >= len(CLASSES):
        raise InputError(f"{path}: labels are 8-bit grey from 0 to {len(CLASSES) - 1}, one per texel")
    labels = cv2.resize(labels, (_TEXTURE_SIZE, _TEXTURE_SIZE), interpolation=cv2.INTER_NEAREST)
    return np.where(labels == INDEX["background"], INDEX["neck"], labels).astype(np.uint8)


def _at(labels: np.ndarray, uv: np.ndarray) -> np.ndarray:
    pixel = np.clip(np.stack([uv[:, 0], 1 - uv[:, 1]]) * len(labels), 0, len(labels) - 1).astype(int)
    return labels[pixel[1], pixel[0]]


def _read_mesh(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (V, 3), triangles (F, 3) and their texture coordinates (F, 3, 2) of an .obj file."""
    vertices, texture, corners = [], [], []
    try:
        for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
            kind, *fields = line.split() or [""]
            if kind == "v":
                vertices.append([float(field) for field in fields[:3]])
            elif kind == "vt":
                texture.append([float(field) for field in fields[:2]])
            elif kind == "f":
                corner = [[int(number) for number in field.split("/")[:2]] for field in fields]
                corners += [(corner[0], corner[i], corner[i + 1]) for i in range(1, len(corner) - 1)]
        places, uv, index = np.array(vertices, np.float32), np.array(texture, np.float32), np.array(corners, np.int64)
        counts = np.array([len(places), len(uv)])
        index = np.where(index < 0, index + counts, index - 1)
        sound = places.shape[1] == 3 and uv.shape[1] == 2 and np.isfinite(places).all() and np.isfinite(uv).all()
        if not sound or index.min() < 0 or (index >= counts).any():
            raise ValueError("numbers that make no mesh")
    except (OSError, ValueError, IndexError, OverflowError) as error:
        raise InputError(f"{path}: not a mesh with texture coordinates ({error}); export it as .obj again") from error
    return places, index[..., 0], np.clip(uv[index[..., 1]], 0, 1)
