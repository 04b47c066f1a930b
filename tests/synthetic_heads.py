"""A ball in place of a baked head, a few lights, and a head model of some hundred triangles."""

from __future__ import annotations

import numpy as np

from relight_core.dataset.baking.bake import BakedHead
from relight_core.dataset.baking.shard import write_shard
from relight_core.lighting.sphere import directions

SKIN, NECK = 1, 9
REGIONS = (
    "face",
    "head_neck",
    "mouth_socket",
    "eye_socket_L",
    "eye_socket_R",
    "gums_tongue",
    "teeth",
    "sclera_L",
    "iris_L",
    "sclera_R",
    "iris_R",
)


def ball(size: int = 16, *, dark_side: str = "") -> BakedHead:
    """A ball of 0.8 half-widths that every texel sees; where dark_side is "right", none with x > 0 does."""
    axis = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = np.meshgrid(axis, -axis)
    covered = x**2 + y**2 < 0.64
    normal = np.stack([x, y, np.sqrt(np.maximum(0.64 - x**2 - y**2, 0))], -1)[covered] / 0.8
    visible = np.ones((512, len(normal)), bool)
    if dark_side == "right":
        visible[directions(16, 32).reshape(-1, 3)[:, 0] > 0] = False
    return BakedHead(
        covered=covered,
        normal=normal.astype(np.float32),
        depth=(0.8 * normal[:, 2] - 0.5).astype(np.float32),
        uv=np.stack([x + 1, y + 1], -1)[covered].astype(np.float32) / 2,
        material=np.zeros(len(normal), np.uint8),
        label=np.where(y > -0.4, SKIN, NECK)[covered].astype(np.uint8),
        visibility=np.packbits(visible, axis=1),
    )


def write_balls(folder, first_seed: int, count: int, size: int = 16) -> None:
    """Shards of balls, as bake would name them."""
    folder.mkdir(exist_ok=True)
    for seed in range(first_seed, first_seed + count):
        write_shard(folder / f"head-{seed:07d}.npz", ball(size))


def write_lights(path, count: int, places: int | None = None) -> None:
    """A library of random panoramas, each with its own place or with some to a place."""
    rng = np.random.default_rng(0)
    env64 = np.repeat(np.repeat(rng.gamma(0.5, 1.0, (count, 8, 16, 3)), 8, 1), 8, 2)
    groups = [f"place {i % (places or count)}" for i in range(count)]
    np.savez(
        path,
        env64=env64.astype(np.float16),
        names=np.array([f"light {i}" for i in range(count)]),
        group=np.array(groups),
    )


def write_head_model(path) -> None:
    """A shallow bowl as face, a flat back, and a small tetrahedron for each of the other regions."""
    grid = 24
    u, v = np.meshgrid(np.linspace(0, 1, grid), np.linspace(0, 1, grid))
    x, y = 16 * (u - 0.5), 20 * (v - 0.5)
    front = np.stack([x, y, 9 * np.sqrt(np.maximum(1 - (x / 9) ** 2 * 0.9 - (y / 11) ** 2 * 0.9, 0))], -1)
    at = np.arange(grid * grid).reshape(grid, grid)
    a, b, c, d = (part.ravel() for part in (at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    vertices, uv = front.reshape(-1, 3), np.stack([u, v], -1).reshape(-1, 2)
    regions = [np.zeros(len(faces), int)]
    all_faces, vertex_regions = [faces], [np.zeros(len(vertices), int)]
    for region in range(1, len(REGIONS)):
        corner = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * 0.5 + [0, -6, -3]
        all_faces.append(np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]) + len(vertices))
        vertices, uv = np.concatenate([vertices, corner]), np.concatenate([uv, np.full((4, 2), 1.5)])
        regions.append(np.full(4, region))
        vertex_regions.append(np.full(4, region))
    triangles = np.concatenate(all_faces)
    expression = np.zeros((2, len(vertices), 3), np.float16)
    expression[0, : grid * grid, 2] = 0.3 * np.sin(8 * u).ravel()
    identity = np.zeros((3, len(vertices), 3), np.float16)
    identity[0, :, 0], identity[1, :, 1] = vertices[:, 0] * 0.03, vertices[:, 1] * 0.03
    landmarks = [int(np.argmin(np.abs(uv[: grid * grid] - place).sum(1))) for place in _landmark_places()]
    np.savez(
        path,
        mean=vertices.astype(np.float32),
        identity=identity,
        expression=expression,
        expression_names=np.array(["jawOpen", "mouthSmile_L"]),
        faces=triangles,
        faces_uv=triangles,
        face_region=np.concatenate(regions),
        vertex_region=np.concatenate(vertex_regions),
        region_names=np.array(REGIONS),
        uv=uv.astype(np.float32),
        landmarks68=np.array(landmarks),
    )


def _landmark_places() -> np.ndarray:
    """(68, 2) texture coordinates: jaw, brows, nose, eyes, mouth, about where a face has them."""
    jaw = [(0.5 - 0.4 * np.cos(t), 0.55 - 0.4 * np.sin(t)) for t in np.linspace(0, np.pi, 17)]
    brows = [(s, 0.75) for s in np.linspace(0.22, 0.43, 5)] + [(s, 0.75) for s in np.linspace(0.57, 0.78, 5)]
    nose = [(0.5, s) for s in np.linspace(0.7, 0.52, 4)] + [(s, 0.47) for s in np.linspace(0.42, 0.58, 5)]
    turns = np.linspace(0, 2 * np.pi, 6, endpoint=False)
    eyes = [(c + 0.07 * np.cos(t), 0.66 + 0.03 * np.sin(t)) for c in (0.33, 0.67) for t in turns]
    lips = [(0.5 + 0.14 * np.cos(t), 0.33 + 0.06 * np.sin(t)) for t in np.linspace(0, 2 * np.pi, 12, endpoint=False)]
    mouth = [(0.5 + 0.1 * np.cos(t), 0.33 + 0.02 * np.sin(t)) for t in np.linspace(0, 2 * np.pi, 8, endpoint=False)]
    return np.array(jaw + brows + nose + eyes + lips + mouth)
