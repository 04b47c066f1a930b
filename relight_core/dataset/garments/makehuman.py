"""Reading the MakeHuman base mesh and its proxies (three.js JSON with fitting data)."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from PIL import Image

from relight_core.dataset.garments.garment_mesh import at_midpoints, compact, subdivide
from relight_core.errors import InputError

_CM_PER_UNIT = 10.0
_LEAST_OPACITY = 0.4


@dataclass(frozen=True)
class Item:
    """One proxy on the MakeHuman base body, in centimetres, vertices split along texture seams."""

    name: str
    vertices: np.ndarray
    faces: np.ndarray
    uv: np.ndarray
    opacity: np.ndarray | None
    colour_srgb: np.ndarray | None


def find_root(folder: Path) -> Path:
    """The folder that holds 3dobjs/base.obj: `folder` or its makehuman/; raises InputError when neither does."""
    for root in (Path(folder), Path(folder) / "makehuman"):
        if (root / "3dobjs" / "base.obj").is_file():
            return root
    raise InputError(f"{folder}: no 3dobjs/base.obj here; unpack the MakeHuman archive to this folder")


@contextmanager
def whole(path: Path) -> Iterator[None]:
    """While a file of the archive is read: what is wrong with it is told by InputError."""
    try:
        yield
    except (OSError, ValueError, KeyError, IndexError, TypeError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"{path}: can't be read ({reason}); unpack the MakeHuman archive again") from error


def read_base(root: Path) -> tuple[np.ndarray, np.ndarray]:
    """Base mesh: vertices (19158, 3) float32 in cm with helpers, and triangles (F, 3) of the body."""
    vertices, faces, _ = read_textured_base(root)
    return vertices, faces


def read_textured_base(root: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """`read_base` and the texture coordinates of the triangles' corners, (F, 3, 2) float32, v up.

    Raises:
        InputError: the file is damaged.
    """
    path = root / "3dobjs" / "base.obj"
    with whole(path):
        return _base(path.read_text())


def _base(text: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    vertices, texture, faces, faces_uv, group = [], [], [], [], ""
    for line in text.splitlines():
        kind, *fields = line.split() or [""]
        if kind == "v":
            vertices.append([float(field) for field in fields[:3]])
        elif kind == "vt":
            texture.append([float(field) for field in fields[:2]])
        elif kind == "g":
            group = fields[0]
        elif kind == "f" and group == "body":
            corner = np.array([field.split("/")[:2] for field in fields], int) - 1
            fan = [[0, i, i + 1] for i in range(1, len(corner) - 1)]
            faces += corner[fan, 0].tolist()
            faces_uv += corner[fan, 1].tolist()
    faces, uv = np.array(faces, np.int32), np.array(texture, np.float32).reshape(-1, 2)
    corner_uv = uv[faces_uv] if len(uv) else np.zeros((*faces.shape, 2), np.float32)
    return np.array(vertices, np.float32) * _CM_PER_UNIT, faces, corner_uv


def read_item(path: Path, base: np.ndarray) -> Item:
    """A proxy, placed on the base body by its own references: sum of weighted base vertices plus offset.

    Raises:
        InputError: the proxy or its texture is damaged.
    """
    with whole(path):
        return _item(path, base)


def _item(path: Path, base: np.ndarray) -> Item:
    data = json.loads(path.read_text())
    references, weights = np.array(data["ref_vIdxs"]), np.array(data["weights"], np.float32)
    placed = (base[references] * weights[..., None]).sum(1) + np.array(data["offsets"]) * _CM_PER_UNIT
    corner_vertex, corner_uv = _triangles(data["faces"])
    both, index = np.unique(np.stack([corner_vertex.ravel(), corner_uv.ravel()], 1), axis=0, return_inverse=True)
    uv = np.array(data["uvs"][0], np.float32).reshape(-1, 2)[both[:, 1]]
    opacity, colour = _texture(path, data)
    return Item(
        name=path.stem,
        vertices=placed[both[:, 0]].astype(np.float32),
        faces=index.reshape(-1, 3).astype(np.int32),
        uv=np.clip(uv, 0, 1),
        opacity=opacity,
        colour_srgb=colour,
    )


def _triangles(stream: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Vertex and uv indices per corner of three.js' packed faces (bits: 1 quad, 2 material, 8 uv)."""
    vertex, uv, at = [], [], 0
    while at < len(stream):
        kind = stream[at]
        corners = 4 if kind & 1 else 3
        start = at + 1
        v = stream[start : start + corners]
        start += corners + (1 if kind & 2 else 0)
        t = stream[start : start + corners]
        at = start + corners
        for i in range(1, corners - 1):
            vertex.append((v[0], v[i], v[i + 1]))
            uv.append((t[0], t[i], t[i + 1]))
    return np.array(vertex), np.array(uv)


def _texture(path: Path, data: dict) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Opacity (None where it is full everywhere) and colour of the first texture that is there."""
    folder = path.parent / "textures"
    named = [path.parent / str(material.get("mapDiffuse", "")) for material in data["materials"]]
    relief = ("_normal", "_ao", "_displacement")
    loose = [p for p in sorted(folder.glob("*.png")) if not p.stem.endswith(relief)]
    for candidate in named + loose:
        if candidate.is_file():
            pixels = np.asarray(Image.open(candidate).convert("RGBA"))
            opacity = np.ascontiguousarray(pixels[..., 3])
            return (opacity if opacity.min() < 250 else None), np.ascontiguousarray(pixels[..., :3])
    return None, None


def refine(item: Item) -> Item:
    """The item with every triangle split into four."""
    edges, faces = subdivide(item.faces, len(item.vertices))
    return replace(item, vertices=at_midpoints(item.vertices, edges), uv=at_midpoints(item.uv, edges), faces=faces)


def cut_by_opacity(item: Item, most_faces: int, deepest: int = 2, least_opacity: float = _LEAST_OPACITY) -> Item:
    """Drop what the texture makes transparent, so that the rest may be treated as opaque.

    Triangles are split up to `deepest` times first, as far as no more than `most_faces` remain, so that
    the outline of strands survives.
    """
    if item.opacity is None:
        return item
    best = None
    fine = item
    for level in range(deepest + 1):
        kept = fine.faces[_mean_opacity(item.opacity, fine.uv[fine.faces]) >= least_opacity]
        if best is not None and len(kept) > most_faces:
            break
        best = (kept, fine.vertices, fine.uv)
        if level < deepest:
            fine = refine(fine)
    faces, vertices, uv = compact(*best)
    return replace(item, vertices=vertices, faces=faces, uv=uv)


def _mean_opacity(opacity: np.ndarray, corner_uv: np.ndarray) -> np.ndarray:
    """(F,) opacity in [0, 1] averaged over the centroid and three points half-way to the corners."""
    middle = corner_uv.mean(1, keepdims=True)
    points = np.concatenate([middle, (corner_uv + middle) / 2], 1)
    height, width = opacity.shape
    x = np.clip((points[..., 0] * width).astype(int), 0, width - 1)
    y = np.clip(((1 - points[..., 1]) * height).astype(int), 0, height - 1)
    return opacity[y, x].mean(1) / 255
