"""Lashes, of strips before the lids of a ball."""

from dataclasses import replace

import numpy as np
import pytest
from ball_heads import CENTRE, RADIUS, assert_well_formed, ball_head

from relight_core.dataset.baking.scene import Material, build_scene
from relight_core.dataset.garments.garment_mesh import grid_faces
from relight_core.dataset.garments.lashes import LashStrips
from relight_core.face.parsing import INDEX

ROWS, COLUMNS = 3, 7


def strip(side: int, upper: bool, layer: int) -> np.ndarray:
    """Vertices (ROWS * COLUMNS, 3) before the ball's front: roots 0.1 cm from it, tips 1 cm further forward."""
    along, out = np.meshgrid(np.linspace(2, 5, COLUMNS) * side, np.linspace(0, 1, ROWS))
    up = (1 if upper else -1) * (0.5 + 0.3 * out + 0.02 * layer) + 3
    front = 1.5 + np.sqrt(81 - along**2 - 0.25)
    return np.stack([along, up, front + 0.1 + out], -1).reshape(-1, 3)


@pytest.fixture(scope="module")
def model():
    ball = ball_head()
    vertices, lashes, start = [ball.mean], {}, len(ball.mean)
    for name, side in (("L", 1), ("R", -1)):
        faces, corners = [], []
        for number in range(6):
            vertices.append(strip(side, number >= 3, number % 3))
            grid = grid_faces(ROWS, COLUMNS)
            u, v = np.meshgrid(np.linspace(0, 1, COLUMNS), number + np.linspace(0.9, 0.1, ROWS))
            faces.append(grid + start)
            corners.append(np.stack([u.ravel(), v.ravel()], 1)[grid])
            start += ROWS * COLUMNS
        lashes[name] = (np.concatenate(faces), np.concatenate(corners))
    mean = np.concatenate(vertices).astype(np.float32)
    region = np.concatenate([ball.vertex_region, np.full(len(mean) - len(ball.mean), 1, np.uint8)])
    return replace(ball, mean=mean, vertex_region=region, lashes=lashes)


@pytest.mark.parametrize("seed", range(5))
def test_lashes_grow_from_both_lids_and_thin_out_to_their_tips(model, seed):
    worn = LashStrips(model).grow(model.mean, np.random.default_rng(seed))
    assert {np.sign(lash.vertices[:, 0].mean()) for lash in worn} == {-1, 1}
    for lash in worn:
        assert_well_formed(lash)
        assert lash.label == "lash"
        corners = lash.vertices[lash.faces]
        area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        # Roots are 0.1 cm from the ball and tips 1 cm before these.
        from_root = np.linalg.norm(corners.mean(1) - CENTRE, axis=1) - RADIUS - 0.1
        assert area[from_root < 0.3].sum() > 2 * area[from_root > 0.6].sum()
    upper = [lash for lash in worn if lash.vertices[:, 1].mean() > 3]
    assert upper
    assert np.ptp(upper[0].vertices[:, 0]) > 2


def test_lashes_move_with_the_lids(model):
    def heights(shift):
        head = model.mean + np.float32([0, shift, 0])
        return [lash.vertices[:, 1].mean() for lash in LashStrips(model).grow(head, np.random.default_rng(1))]

    np.testing.assert_allclose(np.array(heights(0.7)) - heights(0.0), 0.7, atol=1e-4)


def test_a_model_without_strips_has_no_lashes(model):
    assert LashStrips(replace(model, lashes=None)).grow(model.mean, np.random.default_rng(0)) == []


def test_lashes_are_painted_as_brows_and_belong_to_the_eye_of_their_side(model):
    worn = LashStrips(model).grow(model.mean, np.random.default_rng(0))
    scene = build_scene(model, model.mean, worn, np.eye(3, dtype=np.float32))
    lash = scene.material == Material.BROW
    on_left = scene.vertices[scene.triangles[lash, 0], 0] > 0
    assert lash.sum() == sum(len(garment.faces) for garment in worn)
    np.testing.assert_array_equal(scene.label[lash], np.where(on_left, INDEX["left_eye"], INDEX["right_eye"]))
