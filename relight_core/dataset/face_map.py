"""Which part of the face a texture coordinate belongs to, drawn once from the model's 68 landmarks."""

from __future__ import annotations

import cv2
import numpy as np

from relight_core.dataset.heads import HeadModel
from relight_core.face.parsing import INDEX

_SIZE = 1024
_REGION_LABELS = {
    "mouth_socket": "inner_mouth",
    "gums_tongue": "inner_mouth",
    "teeth": "inner_mouth",
    "head_neck": "neck",
    "eye_socket_L": "left_eye",
    "sclera_L": "left_eye",
    "iris_L": "left_eye",
    "eye_socket_R": "right_eye",
    "sclera_R": "right_eye",
    "iris_R": "right_eye",
}


def landmark_uv(model: HeadModel) -> np.ndarray:
    """(68, 2) texture coordinates of the landmarks in the face tile, v up."""
    by_vertex = np.zeros((len(model.mean), 2), np.float32)
    by_vertex[model.triangles.ravel()] = model.uv[model.triangles_uv.ravel()]
    return by_vertex[model.landmarks]


def face_label_map(model: HeadModel) -> np.ndarray:
    """(1024, 1024) uint8 parsing labels of the face tile; row 0 is v = 1."""
    points = landmark_uv(model)
    pixels = np.stack([points[:, 0], 1 - points[:, 1]], 1) * _SIZE
    labels = np.full((_SIZE, _SIZE), INDEX["neck"], np.uint8)
    _fill(labels, _face_outline(pixels), "skin")
    _fill(labels, _nose_outline(pixels), "nose")
    _fill(labels, _smooth(pixels[48:60]), "lips")
    for name, brow in (("right_brow", pixels[17:22]), ("left_brow", pixels[22:27])):
        _fill(labels, _brow_outline(brow), name)
    return labels


def face_vertices(model: HeadModel, labels: np.ndarray) -> np.ndarray:
    """Indices of the vertices of the face proper: the paper's eight regions, without neck, ears and scalp."""
    on_face = model.has_triangles_of("face")
    vertices, uv = model.triangles[on_face].ravel(), model.uv[model.triangles_uv[on_face].ravel()]
    pixels = np.clip((uv * [1, -1] + [0, 1]) * len(labels), 0, len(labels) - 1).astype(int)
    proper = (uv[:, 0] < 1) & (labels[pixels[:, 1], pixels[:, 0]] != INDEX["neck"])
    return np.unique(vertices[proper])


def region_labels(model: HeadModel) -> np.ndarray:
    """(regions,) label of each region of the model; the face region is 255: ask `face_label_map`."""
    return np.array([INDEX[_REGION_LABELS[n]] if n in _REGION_LABELS else 255 for n in model.region_names], np.uint8)


def _fill(labels: np.ndarray, outline: np.ndarray, name: str) -> None:
    cv2.fillPoly(labels, [np.round(outline * 16).astype(np.int32)], INDEX[name], shift=4)


def _smooth(outline: np.ndarray) -> np.ndarray:
    """A closed Catmull-Rom curve through the points."""
    before, after, beyond = (np.roll(outline, shift, 0) for shift in (1, -1, -2))
    t = np.linspace(0, 1, 8, endpoint=False)[None, :, None]
    p0, p1, p2, p3 = (p[:, None] for p in (before, outline, after, beyond))
    curve = 2 * p1 + (p2 - p0) * t + (2 * p0 - 5 * p1 + 4 * p2 - p3) * t**2 + (3 * p1 - p0 - 3 * p2 + p3) * t**3
    return (curve / 2).reshape(-1, 2)


def _face_outline(pixels: np.ndarray) -> np.ndarray:
    """Jaw, temples and a hairline two thirds of the way from the brows to the tile's top."""
    brow_height = pixels[17:27, 1].mean()
    hairline = brow_height * 0.42
    top = [[pixels[16, 0], brow_height], [_SIZE * 0.76, hairline], [_SIZE * 0.5, hairline * 0.8]]
    top += [[_SIZE * 0.24, hairline], [pixels[0, 0], brow_height]]
    return _smooth(np.concatenate([pixels[:17], np.array(top, np.float32)]))


def _nose_outline(pixels: np.ndarray) -> np.ndarray:
    bridge, tip, wings = pixels[27], pixels[30], pixels[31:36]
    width = wings[4, 0] - wings[0, 0]
    left = [[bridge[0] - 0.22 * width, bridge[1]], [tip[0] - 0.5 * width, tip[1]]]
    right = [[tip[0] + 0.5 * width, tip[1]], [bridge[0] + 0.22 * width, bridge[1]]]
    lower = wings + np.array([[-0.12, 0.02], [0, 0.06], [0, 0.06], [0, 0.06], [0.12, 0.02]]) * width
    return _smooth(np.concatenate([left, lower, right]).astype(np.float32))


def _brow_outline(brow: np.ndarray) -> np.ndarray:
    """The landmarks run along the brow's middle; give them a thickness that thins outward."""
    inner_is_last = brow[-1, 0] < _SIZE / 2
    thickness = np.array([0.45, 0.8, 1.0, 1.1, 0.9]) * _SIZE * 0.014
    if not inner_is_last:
        thickness = thickness[::-1]
    rise = np.stack([np.zeros(5), thickness], 1)
    return _smooth(np.concatenate([brow - rise, (brow + rise)[::-1]]).astype(np.float32))
