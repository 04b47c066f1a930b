"""Triangle mesh operations that garments are made with."""

from __future__ import annotations

import numpy as np

from relight_core.imaging.ramp import smooth_ramp


def vertex_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Unit normals (V, 3) float32, weighted by area; unused vertices get zero."""
    corners = vertices[faces]
    scaled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    index = faces.ravel()
    normals = np.stack([np.bincount(index, np.repeat(scaled[:, axis], 3), len(vertices)) for axis in range(3)], 1)
    return (normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)).astype(np.float32)


def grid_faces(rows: int, columns: int) -> np.ndarray:
    """Triangles (2 (rows - 1) (columns - 1), 3) int32 over a grid of vertices in row order."""
    at = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = at[:-1, :-1].ravel(), at[1:, :-1].ravel(), at[1:, 1:].ravel(), at[:-1, 1:].ravel()
    return np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.int32)


def subdivide(faces: np.ndarray, vertex_count: int) -> tuple[np.ndarray, np.ndarray]:
    """Split every triangle into four at its edges' midpoints.

    Returns:
        edges (E, 2): new vertex `vertex_count + e` is the mean of the vertices edges[e]; faces (4F, 3).
    """
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges, which = np.unique(np.sort(sides, 1), axis=0, return_inverse=True)
    ab, bc, ca = (which.reshape(3, -1) + vertex_count).astype(faces.dtype)
    a, b, c = faces.T
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return edges, np.concatenate([np.stack(part, 1) for part in parts])


def at_midpoints(values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Values per vertex (V, ...) followed by their means over `edges`: (V + E, ...)."""
    return np.concatenate([values, values[edges].mean(1)])


def compact(faces: np.ndarray, *per_vertex: np.ndarray) -> tuple[np.ndarray, ...]:
    """Drop unused vertices: (faces int32, and each array of values per vertex without them)."""
    used, renumbered = np.unique(faces, return_inverse=True)
    return renumbered.reshape(-1, 3).astype(np.int32), *(values[used] for values in per_vertex)


def clip(faces: np.ndarray, field: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Keep the part of a mesh where a field per vertex is positive; cut triangles exactly on its zero line.

    Args:
        field: (V,) float.
        values: (V, C) whatever varies linearly over a triangle (position, uv ...).

    Returns:
        faces (F', 3) int32 and values (V', C), vertices unused before or after left out.
    """
    inside = field[faces] > 0
    count = inside.sum(1)
    # Turn mixed triangles so that the odd one out comes first.
    odd = np.where(count == 1, inside.argmax(1), (~inside).argmax(1))
    turned = np.take_along_axis(faces, (odd[:, None] + np.arange(3)) % 3, 1)
    one, two = turned[count == 1], turned[count == 2]
    crossing = np.concatenate([one[:, [0, 1]], one[:, [0, 2]], two[:, [0, 1]], two[:, [0, 2]]])
    cuts, which = np.unique(np.sort(crossing, 1), axis=0, return_inverse=True)
    share = field[cuts[:, 0]] / np.where(
        field[cuts[:, 0]] == field[cuts[:, 1]], 1, field[cuts[:, 0]] - field[cuts[:, 1]]
    )
    added = values[cuts[:, 0]] + (values[cuts[:, 1]] - values[cuts[:, 0]]) * share[:, None]
    new = which.ravel() + len(values)
    p, q, r, s = np.split(new, np.cumsum([len(one), len(one), len(two)]))
    parts = [
        faces[count == 3],
        np.stack([one[:, 0], p, q], 1),
        np.stack([r, two[:, 1], two[:, 2]], 1),
        np.stack([r, two[:, 2], s], 1),
    ]
    return compact(np.concatenate(parts), np.concatenate([values, added]).astype(values.dtype))


def waves(points: np.ndarray, rng: np.random.Generator, wavelength_cm: float, stretch=(1.0, 1.0, 1.0)) -> np.ndarray:
    """Smooth noise (N,), about standard normal: a sum of plane waves in random directions.

    Args:
        points: (N, 3) centimetres.
        stretch: how many times longer the waves are along x, y and z.
    """
    directions = rng.standard_normal((16, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    turns_per_cm = rng.uniform(0.7, 1.4, (16, 1)) / wavelength_cm
    frequency = (2 * np.pi * directions * turns_per_cm / np.asarray(stretch)).astype(np.float32)
    start = rng.uniform(0, 2 * np.pi, 16).astype(np.float32)
    return np.sin(points.astype(np.float32) @ frequency.T + start).sum(1) / np.float32(np.sqrt(8))


def fractal(points: np.ndarray, rng: np.random.Generator, wavelength_cm: float, octaves: int = 3) -> np.ndarray:
    """Noise (N,) of several octaves, each half as long and half as strong; about unit variance."""
    layers = [waves(points, rng, wavelength_cm / 2**o) / 2**o for o in range(octaves)]
    return sum(layers) / np.sqrt(sum(0.25**o for o in range(octaves)))


def smoothstep(low: float, high: float, value: np.ndarray) -> np.ndarray:
    """0 below `low`, 1 above `high`, smooth between."""
    return smooth_ramp(value, low, high)
