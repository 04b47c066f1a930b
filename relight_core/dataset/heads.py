"""Heads from a morphable model: identity, expression, gaze, pose."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from relight_core.dataset.archive import read_arrays
from relight_core.errors import InputError

# Transparent overlays of the model (tear film, lid occlusion, lashes) would be opaque to a ray.
_OPAQUE_REGIONS = (
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

_AXES: dict[str, tuple[str | int, ...]] = {
    "mean": ("vertices", 3),
    "identity": ("modes", "vertices", 3),
    "expression": ("expressions", "vertices", 3),
    "expression_names": ("expressions",),
    "faces": ("triangles", 3),
    "faces_uv": ("triangles", 3),
    "face_region": ("triangles",),
    "vertex_region": ("vertices",),
    "region_names": ("regions",),
    "uv": ("texture coordinates", 2),
    "landmarks68": (68,),
}
"""The arrays of a head model, and what stands along the axes of each."""

_POINTS_INTO = {
    "faces": "vertices",
    "faces_uv": "texture coordinates",
    "face_region": "regions",
    "vertex_region": "regions",
    "landmarks68": "vertices",
}
_SHAPES = ("mean", "identity", "expression", "uv")

OUTER_SKIN = ("face", "head_neck")
"""Regions that things are worn on."""

_NECK_PIVOT_CM = np.array([0.0, -8.0, 0.0], np.float32)

NAMED_EXPRESSIONS: dict[str, dict[str, float]] = {
    "neutral": {},
    "smile": {"mouthSmile": 0.8, "cheekSquint": 0.4},
    "grin": {"mouthSmile": 0.9, "jawOpen": 0.15, "mouthUpperUp": 0.4, "cheekSquint": 0.6},
    "laugh": {"mouthSmile": 1.0, "jawOpen": 0.45, "mouthUpperUp": 0.5, "eyeSquint": 0.5},
    "frown": {"mouthFrown": 0.8, "browDown": 0.5},
    "anger": {"browDown": 1.0, "noseSneer": 0.6, "mouthPress": 0.6, "eyeSquint": 0.4},
    "surprise": {"browInnerUp": 0.9, "browOuterUp": 0.8, "jawOpen": 0.5, "eyeWide": 0.7},
    "fear": {"browInnerUp": 1.0, "eyeWide": 0.9, "mouthStretch": 0.6},
    "disgust": {"noseSneer": 1.0, "mouthUpperUp": 0.5, "browDown": 0.4},
    "sadness": {"browInnerUp": 0.8, "mouthFrown": 0.6, "mouthShrugLower": 0.4},
    "pucker": {"mouthPucker": 0.9},
    "funnel": {"mouthFunnel": 0.8, "jawOpen": 0.2},
    "closed_eyes": {"eyeBlink": 1.0},
    "squint": {"eyeSquint": 0.9, "cheekSquint": 0.7},
    "jaw_left": {"jawLeft": 0.7, "jawOpen": 0.2},
    "jaw_right": {"jawRight": 0.7, "jawOpen": 0.2},
    "puffed_cheeks": {"cheekPuff": 0.9},
    "pressed_lips": {"mouthPress": 0.9, "mouthRollLower": 0.5, "mouthRollUpper": 0.5},
    "shout": {"jawOpen": 0.9, "mouthStretch": 0.4, "browDown": 0.4},
    "raised_brows": {"browInnerUp": 0.7, "browOuterUp": 0.9},
}
"""Twenty expressions, as the paper records twenty (section 3.1); weights of both sides of the face."""


@dataclass(frozen=True)
class HeadModel:
    """A linear face model, in centimetres, face toward +z, +y up.

    Attributes:
        mean: (V, 3) float32.
        identity: (modes, V, 3) offsets for unit weights.
        expression: (shapes, V, 3) offsets; `expression_names` names them.
        triangles: (F, 3) vertex indices of the opaque parts.
        triangles_uv: (F, 3) indices into `uv` (tiles: face 0-1, back of the head 1-2, teeth 3-4 ...).
        triangle_region: (F,) index into `region_names`.
        landmarks: (68,) vertex indices in the common 68-point order.
        lashes: by side, "L" and "R", triangles (F, 3) of the strips for lashes and their corners' texture
            coordinates (F, 3, 2); None where the model has none. They are transparent, and not in `triangles`.
    """

    mean: np.ndarray
    identity: np.ndarray
    expression: np.ndarray
    expression_names: tuple[str, ...]
    triangles: np.ndarray
    triangles_uv: np.ndarray
    triangle_region: np.ndarray
    vertex_region: np.ndarray
    region_names: tuple[str, ...]
    uv: np.ndarray
    landmarks: np.ndarray
    lashes: dict[str, tuple[np.ndarray, np.ndarray]] | None = None

    def vertices_of(self, *regions: str) -> np.ndarray:
        """Indices of the vertices of named regions."""
        return np.flatnonzero(self.has_vertices_of(*regions))

    def has_vertices_of(self, *regions: str) -> np.ndarray:
        """(V,) bool: is a vertex of one of the named regions?"""
        return np.isin(self.vertex_region, [self.region_names.index(name) for name in regions])

    def has_triangles_of(self, *regions: str) -> np.ndarray:
        """(F,) bool: is a triangle of one of the named regions?"""
        return np.isin(self.triangle_region, [self.region_names.index(name) for name in regions])


def load_head_model(path: Path) -> HeadModel:
    """Read an ICT-FaceKit archive (.npz).

    Raises:
        InputError: missing or damaged, or its arrays are not finite or don't fit each other.
    """
    mend = "give the ICT-FaceKit archive"
    data = read_arrays(path, tuple(_AXES), "a head model", mend)
    misfit = _misfit(data)
    if misfit:  # Heads of it would be empty or torn, or end in the middle of a bake.
        raise InputError(f"{path}: {misfit}; {mend}")
    names = tuple(str(name) for name in data["region_names"])
    opaque = np.isin(data["face_region"], [names.index(name) for name in _OPAQUE_REGIONS])
    return HeadModel(
        mean=data["mean"].astype(np.float32),
        identity=data["identity"],
        expression=data["expression"],
        expression_names=tuple(str(name) for name in data["expression_names"]),
        triangles=data["faces"][opaque].astype(np.int64),
        triangles_uv=data["faces_uv"][opaque].astype(np.int64),
        triangle_region=data["face_region"][opaque],
        vertex_region=data["vertex_region"],
        region_names=names,
        uv=data["uv"],
        landmarks=data["landmarks68"].astype(np.int64),
        lashes=_lashes(data, names),
    )


def _misfit(data: dict[str, np.ndarray]) -> str:
    """What is wrong with a head model's arrays, in words; nothing where all is well."""
    counts: dict[str, int] = {}
    for name, axes in _AXES.items():
        shape = data[name].shape
        expected = [axis if isinstance(axis, int) else counts.get(axis) for axis in axes]
        fits = [count in (None, length) for count, length in zip(expected, shape, strict=False)]
        if len(shape) != len(axes) or not all(fits):
            return f"its {name!r} is of shape {shape}, which does not fit the other arrays"
        counts |= {axis: length for axis, length in zip(axes, shape, strict=True) if isinstance(axis, str)}
    for name in _SHAPES:
        if data[name].dtype.kind != "f" or not np.isfinite(data[name]).all():
            return f"not all of its {name!r} are finite numbers"
    for name, what in _POINTS_INTO.items():
        if data[name].dtype.kind not in "iu" or not ((data[name] >= 0) & (data[name] < counts[what])).all():
            return f"its {name!r} name others than its {counts[what]} {what}"
    missing = [name for name in _OPAQUE_REGIONS if name not in data["region_names"]]
    return f"its 'region_names' lack {missing[0]!r}" if missing else ""


def _lashes(data: dict[str, np.ndarray], names: tuple[str, ...]) -> dict[str, tuple[np.ndarray, np.ndarray]] | None:
    if not {"eyelashes_L", "eyelashes_R"} <= set(names):
        return None
    strips = {side: data["face_region"] == names.index(f"eyelashes_{side}") for side in "LR"}
    return {side: (data["faces"][here], data["uv"][data["faces_uv"][here]]) for side, here in strips.items()}


def expression_weights(model: HeadModel, named: dict[str, float]) -> np.ndarray:
    """Weights of all shapes from side-less names: "mouthSmile" sets both mouthSmile_L and mouthSmile_R."""
    weights = np.zeros(len(model.expression_names), np.float32)
    for index, name in enumerate(model.expression_names):
        weights[index] = named.get(name.removesuffix("_L").removesuffix("_R"), named.get(name, 0.0))
    return weights


def sample_expression(model: HeadModel, rng: np.random.Generator) -> np.ndarray:
    """A named expression at a random strength, sometimes with a sparse random blend on top."""
    name = rng.choice(list(NAMED_EXPRESSIONS))
    weights = expression_weights(model, NAMED_EXPRESSIONS[str(name)]) * rng.uniform(0.5, 1.1)
    if rng.random() < 0.5:
        sparse = (rng.random(weights.shape) < 0.15) * rng.uniform(0, 0.5, weights.shape)
        weights = weights + sparse
    return np.clip(weights, 0, 1.2).astype(np.float32)


def shape_head(model: HeadModel, identity: np.ndarray, expression: np.ndarray) -> np.ndarray:
    """(V, 3) vertices for identity weights (modes,) ~ N(0, 1) and expression weights in [0, 1]."""
    offsets = np.tensordot(identity.astype(np.float32), model.identity.astype(np.float32), 1)
    used = np.flatnonzero(expression)
    offsets += np.tensordot(expression[used], model.expression[used].astype(np.float32), 1)
    return model.mean + offsets


def turn_eyes(model: HeadModel, vertices: np.ndarray, yaw_deg: float, pitch_deg: float) -> np.ndarray:
    """Turn both eyeballs about their own centres; positive yaw looks to the image's right."""
    vertices = vertices.copy()
    rotation = rotation_matrix(yaw_deg, pitch_deg, 0.0)
    for side in "LR":
        ball = np.concatenate([model.vertices_of(f"sclera_{side}"), model.vertices_of(f"iris_{side}")])
        low, high = vertices[ball].min(0), vertices[ball].max(0)
        centre = (low + high) / 2
        vertices[ball] = (vertices[ball] - centre) @ rotation.T + centre
    return vertices


def rotation_matrix(yaw_deg: float, pitch_deg: float, roll_deg: float) -> np.ndarray:
    """Rotation of the head: roll about +z, then pitch about +x, then yaw about +y. (3, 3) float32."""
    yaw, pitch, roll = np.radians([yaw_deg, pitch_deg, roll_deg])
    about_y = [[np.cos(yaw), 0, np.sin(yaw)], [0, 1, 0], [-np.sin(yaw), 0, np.cos(yaw)]]
    about_x = [[1, 0, 0], [0, np.cos(pitch), -np.sin(pitch)], [0, np.sin(pitch), np.cos(pitch)]]
    about_z = [[np.cos(roll), -np.sin(roll), 0], [np.sin(roll), np.cos(roll), 0], [0, 0, 1]]
    return (np.array(about_y) @ np.array(about_x) @ np.array(about_z)).astype(np.float32)


def sample_pose(rng: np.random.Generator) -> np.ndarray:
    """A head rotation in the paper's ranges (section 3.2), and up to 60 degrees of yaw in one of eight."""
    widest = 60.0 if rng.random() < 0.125 else 30.0
    return rotation_matrix(rng.uniform(-widest, widest), rng.uniform(-15, 15), rng.uniform(-15, 15))


def pose(vertices: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Rotate about the base of the neck."""
    return ((vertices - _NECK_PIVOT_CM) @ rotation.T + _NECK_PIVOT_CM).astype(np.float32)
