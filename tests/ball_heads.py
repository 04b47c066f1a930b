"""A head as round as a ball, and what every garment on it has to fulfil."""

import numpy as np
from scipy.spatial import ConvexHull

from relight_core.dataset.garments.garment_binding import HeadSurface
from relight_core.dataset.garments.garment_mesh import vertex_normals
from relight_core.dataset.heads import HeadModel

RADIUS = 9.0
CENTRE = np.array([0.0, 3.0, 1.5])


def sphere(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points evenly over the unit sphere, and triangles wound outward."""
    height = 1 - 2 * (np.arange(count) + 0.5) / count
    angle = np.arange(count) * np.pi * (3 - np.sqrt(5))
    ring = np.sqrt(1 - height**2)
    points = np.stack([ring * np.cos(angle), height, ring * np.sin(angle)], 1)
    faces = ConvexHull(points).simplices
    corners = points[faces]
    inward = np.linalg.det(corners) < 0
    faces[inward] = faces[inward][:, ::-1]
    return points, faces


def ball_head() -> HeadModel:
    """A head model that is one round skin."""
    points, faces = sphere(3000)
    return HeadModel(
        mean=(points * RADIUS + CENTRE).astype(np.float32),
        identity=np.zeros((0, len(points), 3)),
        expression=np.zeros((0, len(points), 3)),
        expression_names=(),
        triangles=faces.astype(np.int64),
        triangles_uv=faces.astype(np.int64),
        triangle_region=np.zeros(len(faces), np.uint8),
        vertex_region=np.zeros(len(points), np.uint8),
        region_names=("face", "head_neck"),
        uv=np.zeros((len(points), 2), np.float32),
        landmarks=np.arange(68),
    )


def surface(model: HeadModel, head: np.ndarray) -> HeadSurface:
    return HeadSurface(head, vertex_normals(head, model.triangles))


def assert_well_formed(garment):
    assert np.isfinite(garment.vertices).all()
    assert garment.vertices.dtype == np.float32
    assert garment.faces.dtype == np.int32
    assert set(np.unique(garment.faces)) == set(range(len(garment.vertices)))
    assert garment.uv.shape == (len(garment.vertices), 2)
    assert garment.uv.min() >= 0
    assert garment.uv.max() <= 1
