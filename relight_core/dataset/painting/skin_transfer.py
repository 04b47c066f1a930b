"""MakeHuman's skins carried onto the head model's texture tiles.

Every texel of the head has a place on the mean head; the warped MakeHuman head has a skin texel near it
that faces the same way. Colours are averaged over the nearest few of those, so that the seams of
MakeHuman's own atlas leave none.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from PIL import Image
from scipy.ndimage import distance_transform_edt
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from relight_core.dataset.garments.garment_binding import scattered
from relight_core.dataset.garments.garment_mesh import at_midpoints, subdivide, vertex_normals
from relight_core.dataset.garments.makehuman import find_root, read_textured_base, whole
from relight_core.dataset.garments.makehuman_fit import HeadWarp
from relight_core.dataset.heads import OUTER_SKIN, HeadModel
from relight_core.dataset.painting.skin_textures import SkinTextures
from relight_core.imaging.colour import srgb_decode_integers, srgb_encode

_SKIN_REGIONS = (*OUTER_SKIN, "eye_socket_L", "eye_socket_R")
_LOWEST_CM = -25.0
_SUBDIVISIONS = 3
_NEIGHBOURS = 4
_BLUR_CM = 1.2
_BLUR_NEIGHBOURS = 96
# How many centimetres of distance a quarter turn of the surface counts as: keeps lips off gums, lids off balls.
_TURN_CM = 1.0


def transfer_skins(makehuman: Path, model: HeadModel, size: int = 256) -> SkinTextures:
    """All skins in the head model's tiles.

    Raises:
        InputError: the folder holds no MakeHuman data, or damaged ones.
    """
    root = find_root(makehuman)
    points, uv = _skin_points(root, model)
    tiles = [_texel_places(model, tile, size) for tile in range(2)]
    coarse = [_texel_places(model, tile, size // 4) for tile in range(2)]
    sharp = [_nearest(places, points) for _, places in tiles]
    blurred = [_blurring(places, points) for _, places in coarse]
    names, fine, smooth = [], [], []
    for path in sorted((root / "skins").glob("*/textures/*_diffuse*.png")):
        with whole(path):
            picture = np.asarray(Image.open(path).convert("RGB"))
        colours = _look_up(srgb_decode_integers(picture), uv)
        names.append(path.stem.replace("_diffuse", ""))
        fine.append(_encoded(tiles, sharp, colours))
        smooth.append(_encoded(coarse, blurred, colours))
    return SkinTextures(tuple(names), np.array(fine), np.array(smooth))


def _skin_points(root: Path, model: HeadModel) -> tuple[np.ndarray, np.ndarray]:
    """A dense cloud on the warped MakeHuman head: places with normals (N, 6) and texture coordinates (N, 2)."""
    base, faces, corner_uv = read_textured_base(root)
    both, index = np.unique(
        np.concatenate([faces.reshape(-1, 1), corner_uv.reshape(-1, 2)], 1), axis=0, return_inverse=True
    )
    vertex, uv, split = both[:, 0].astype(int), both[:, 1:], index.reshape(-1, 3)
    warped = HeadWarp(base, faces, model)(base)
    # Normals are of the whole surface, not of its pieces, or texture seams would show in them.
    moved, normals = warped[vertex], vertex_normals(warped, faces)[vertex]
    split = split[_outside(split) & (moved[split][..., 1] > _LOWEST_CM).all(1)]
    for _ in range(_SUBDIVISIONS):
        edges, split = subdivide(split, len(moved))
        moved, uv, normals = (at_midpoints(values, edges) for values in (moved, uv, normals))
    used = np.unique(split)
    return _with_normals(moved[used], normals[used]), uv[used].astype(np.float32)


def _outside(faces: np.ndarray) -> np.ndarray:
    """(F,) bool: is a triangle in one of the atlas's two largest pieces, head and body? Gums and tongue are not."""
    edges = np.concatenate([faces[:, :2], faces[:, 1:]])
    count = faces.max() + 1
    joined = coo_matrix((np.ones(len(edges)), edges.T), (count, count))
    piece = connected_components(joined, directed=False)[1][faces[:, 0]]
    return np.isin(piece, np.argsort(np.bincount(piece))[-2:])


def _with_normals(places: np.ndarray, normals: np.ndarray) -> np.ndarray:
    normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
    return np.concatenate([places, normals * _TURN_CM], 1).astype(np.float32)


def _texel_places(model: HeadModel, tile: int, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Which texels of a tile the skin covers, (size, size) bool, and their places with normals (T, 6)."""
    skin = model.has_triangles_of(*_SKIN_REGIONS)
    corner_uv = model.uv[model.triangles_uv]
    chosen = np.flatnonzero(skin & ((corner_uv[..., 0].max(1) > 1) == bool(tile)))
    triangle = np.full((size, size), -1, np.int32)
    pixels = (corner_uv[chosen] - [tile, 0]) * [size, -size] + [-0.5, size - 0.5]
    for number, outline in enumerate(np.round(pixels * 16).astype(np.int32)):
        cv2.fillConvexPoly(triangle, outline, number, shift=4)
    covered = triangle >= 0
    row, column = np.nonzero(covered)
    number = triangle[covered]
    barycentric = _barycentric(np.stack([column, row], 1), pixels[number])
    corners = model.triangles[chosen][number]
    values = np.concatenate([model.mean, vertex_normals(model.mean, model.triangles[skin])], 1)[corners]
    mixed = (values * barycentric[..., None]).sum(1)
    return covered, _with_normals(mixed[:, :3], mixed[:, 3:])


def _barycentric(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """(N, 3) weights of points (N, 2) in triangles (N, 3, 2), clipped to the triangle."""
    a, b, c = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p = points - a
    area = b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0]
    area = np.where(np.abs(area) < 1e-9, 1e-9, area)
    second = (p[:, 0] * c[:, 1] - p[:, 1] * c[:, 0]) / area
    third = (b[:, 0] * p[:, 1] - b[:, 1] * p[:, 0]) / area
    weights = np.clip(np.stack([1 - second - third, second, third], 1), 0, 1)
    return weights / np.maximum(weights.sum(1, keepdims=True), 1e-9)


def _nearest(places: np.ndarray, points: np.ndarray) -> csr_matrix:
    """(T, N) weights of the cloud's nearest points for every texel; rows sum to one."""
    distance, index = cKDTree(points).query(places, _NEIGHBOURS)
    weight = 1 / (distance + 0.02)
    weight /= weight.sum(1, keepdims=True)
    rows = np.repeat(np.arange(len(places)), _NEIGHBOURS)
    return csr_matrix((weight.ravel().astype(np.float32), (rows, index.ravel())), (len(places), len(points)))


def _blurring(places: np.ndarray, points: np.ndarray) -> csr_matrix:
    """(T, N) Gaussian weights over the cloud: blurred on the surface, so that no seam of the tiles shows."""
    sparse = scattered(points[:, :3], _BLUR_CM / 3)
    distance, index = cKDTree(points[sparse, :3]).query(places[:, :3], _BLUR_NEIGHBOURS)
    weight = np.exp(-(distance**2 - distance[:, :1] ** 2) / (2 * _BLUR_CM**2))
    weight /= weight.sum(1, keepdims=True)
    rows = np.repeat(np.arange(len(places)), _BLUR_NEIGHBOURS)
    columns = sparse[index.ravel()]
    return csr_matrix((weight.ravel().astype(np.float32), (rows, columns)), (len(places), len(points)))


def _encoded(tiles: list, weights: list[csr_matrix], colours: np.ndarray) -> np.ndarray:
    """Two tiles of mixed colours, (2, size, size, 3) uint8 sRGB."""
    filled = [_filled(covered, mix @ colours) for (covered, _), mix in zip(tiles, weights, strict=True)]
    return np.round(srgb_encode(np.stack(filled)) * 255).astype(np.uint8)


def _look_up(texture: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Bilinear colours (N, 3) of a texture at (N, 2) coordinates in [0, 1], v up."""
    height, width = texture.shape[:2]
    x = np.clip(uv[:, 0] * width - 0.5, 0, width - 1)
    y = np.clip((1 - uv[:, 1]) * height - 0.5, 0, height - 1)
    x0, y0 = np.minimum(x.astype(int), width - 2), np.minimum(y.astype(int), height - 2)
    fx, fy = (x - x0)[:, None], (y - y0)[:, None]
    top = texture[y0, x0] * (1 - fx) + texture[y0, x0 + 1] * fx
    bottom = texture[y0 + 1, x0] * (1 - fx) + texture[y0 + 1, x0 + 1] * fx
    return (top * (1 - fy) + bottom * fy).astype(np.float32)


def _filled(covered: np.ndarray, values: np.ndarray) -> np.ndarray:
    """A tile (size, size, 3) whose uncovered texels repeat the nearest covered one."""
    tile = np.zeros((*covered.shape, 3), np.float32)
    tile[covered] = values
    row, column = distance_transform_edt(~covered, return_distances=False, return_indices=True)
    return tile[row, column]
