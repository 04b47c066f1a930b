"""What baking makes of surfaces whose every pixel is known, and what scenes are put together from."""

from dataclasses import replace

import numpy as np
import pytest
from ball_heads import ball_head
from synthetic_heads import ball

from relight_core.dataset.baking.bake import FABRIC, add_relief, bake
from relight_core.dataset.baking.framing import Framing
from relight_core.dataset.baking.raycast import RayCaster
from relight_core.dataset.baking.scene import FROM_FACE_MAP, Material, Scene, build_scene
from relight_core.dataset.garments.garment import Garment
from relight_core.errors import InputError
from relight_core.face.parsing import INDEX
from relight_core.lighting.sphere import directions

SKIN, HAT = INDEX["skin"], INDEX["hat"]


def scene_of(*quads):
    """Of quads, each its four corners, a material and a label; coordinates of the texture rise with x and y."""
    corners = np.concatenate([np.array(quad[0], np.float32) for quad in quads])
    at = np.concatenate([[[4 * n, 4 * n + 1, 4 * n + 2], [4 * n, 4 * n + 2, 4 * n + 3]] for n in range(len(quads))])
    material, label = (np.repeat([quad[part] for quad in quads], 2).astype(np.uint8) for part in (1, 2))
    return Scene(corners, at.astype(np.int64), (corners[at][..., :2] / 20 + 0.5).astype(np.float32), material, label)


def upright(x0, x1, z):
    return [(x0, -10, z), (x1, -10, z), (x1, 10, z), (x0, 10, z)]


@pytest.fixture(scope="module")
def baked():
    """The left half a face, wound away from the camera; the right half a hat, 5 cm behind; a wall between them."""
    wall = [(0.2, -90, -5), (0.2, -90, 90), (0.2, 90, 90), (0.2, 90, -5)]
    quads = [
        (upright(-10, 0, 0.0)[::-1], Material.FACE, FROM_FACE_MAP),
        (upright(0.4, 10, -5.0), Material.HAT, HAT),
        (wall, Material.CLOTH, INDEX["cloth"]),
    ]
    face_labels = np.full((4, 4), INDEX["lips"], np.uint8)
    face_labels[:2] = SKIN
    scene = scene_of(*quads)
    try:
        RayCaster(scene)
    except (InputError, ImportError, RuntimeError) as error:
        pytest.skip(f"no ray caster here: it needs mitsuba and libLLVM ({error})")
    return bake(scene, Framing((0.0, 0.0), 10.0), face_labels, 16, np.random.default_rng(0))


def test_labels_and_coordinates_are_those_of_the_place_that_is_seen(baked):
    assert baked.covered.all()
    label, uv = baked.scatter(baked.label), baked.scatter(baked.uv)
    np.testing.assert_array_equal(label[:8, :7], SKIN)
    np.testing.assert_array_equal(label[8:, :7], INDEX["lips"])
    np.testing.assert_array_equal(label[:, 10:], HAT)
    np.testing.assert_allclose(uv[3, 2], [2.5 / 16, 1 - 3.5 / 16], atol=1e-3)
    assert set(baked.material[baked.label == HAT]) == {Material.HAT}


def test_depth_counts_from_the_face_in_half_widths_and_normals_face_the_camera(baked):
    depth, normal = baked.scatter(baked.depth), baked.scatter(baked.normal)
    np.testing.assert_allclose(depth[:, :7], 0, atol=1e-3)
    np.testing.assert_allclose(depth[:, 10:], -0.5, atol=1e-3)
    np.testing.assert_allclose(normal[:, :7], np.broadcast_to([0, 0, 1], (16, 7, 3)), atol=1e-4)


def test_a_wall_hides_what_is_behind_it_and_nothing_else(baked):
    toward, visible = directions(16, 32).reshape(-1, 3), baked.visible()
    left, right = (np.arange(16) * 16 + column for column in (5, 11))
    for pixels, side in ((left, 1), (right, -1)):
        behind = (side * toward[:, 0] > 0.6) & (toward[:, 2] > 0.2)
        free = (side * toward[:, 0] < -0.2) & (toward[:, 2] > 0.2)
        assert visible[np.ix_(free, pixels)].all()
        assert visible[np.ix_(behind, pixels)].mean() < 0.05


@pytest.mark.parametrize(("rises", "leans"), [((1, 0), (-1, 0)), ((0, 1), (0, -1))], ids=["to the right", "upward"])
def test_a_relief_leans_away_from_where_it_rises_within_its_materials_alone(rises, leans):
    head = ball(32)
    across = np.nonzero(head.covered)[1]
    head = replace(head, material=np.where(across < 16, Material.FACE, Material.HAT).astype(np.uint8))
    slope = np.linspace(-1, 1, 64, dtype=np.float32)
    heights = slope[None].repeat(64, 0) if rises[0] else slope[::-1, None].repeat(64, 1)
    flat = np.zeros_like(head.normal) + np.float32([0, 0, 1])
    steep, gentle = (add_relief(head, flat, heights, strength) for strength in (100.0, 1.0))
    moved = np.abs(steep - flat).max(1) > 1e-3
    inner = head.scatter(moved)[10:22]
    assert inner[:, 8:14].all()
    assert not inner[:, 15:].any()
    # An outline's own step is no relief.
    assert not head.scatter(moved)[head.covered & ~np.pad(head.covered, 1)[2:, 1:-1]].any()
    np.testing.assert_allclose(steep[moved] * 1.16**0.5, [(0.4 * leans[0], 0.4 * leans[1], 1)] * moved.sum(), atol=0.01)
    np.testing.assert_allclose(gentle[moved][:, :2], [np.array(leans) * 2 / 32] * moved.sum(), atol=0.02)
    woven = np.abs(add_relief(head, flat, heights, 1.0, FABRIC, 3) - flat).max(1)
    assert woven[~moved].max() > 2.5 * np.abs(gentle - flat).max()
    assert woven[moved].max() == 0


def test_a_scene_turns_garments_with_the_head_and_tells_what_each_is_of():
    ball_model = ball_head()
    # What of the face lies beyond its tile is the back of the head.
    behind = ball_model.mean[:, 2] < 0
    model = replace(ball_model, uv=np.where(behind[:, None], [1.5, 0.5], 0.25).astype(np.float32))
    corners = np.array([[2, 0, 20], [3, 0, 20], [2, 1, 20]], np.float32)

    def worn(label, x=1, made_of=None):
        return Garment(corners * [x, 1, 1], np.array([[0, 1, 2]], np.int32), corners[:, :2] / 9, label, made_of=made_of)

    garments = [
        worn("brow", -1),
        worn("brow"),
        worn("hat", made_of="trim"),
        worn("cloth"),
        worn("neck"),
        worn("glasses"),
    ]
    quarter = np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]], np.float32)
    head, turned = (build_scene(model, model.mean, garments, rotation) for rotation in (np.eye(3), quarter))
    expected = [
        ("left_brow", Material.BROW),
        ("right_brow", Material.BROW),
        ("hat", Material.TRIM),
        ("cloth", Material.CLOTH),
        ("neck", Material.HEAD),
        ("glasses", Material.GLASSES),
    ]
    sides = {int(label): np.sign(head.vertices[head.triangles[n - 6, 0], 0]) for n, label in enumerate(head.label[-6:])}
    # Who looks into the camera has the left brow on the picture's right.
    assert (sides[INDEX["left_brow"]], sides[INDEX["right_brow"]]) == (1, -1)
    assert {(int(label), int(of)) for label, of in zip(head.label[-6:], head.material[-6:], strict=True)} == {
        (INDEX[label], int(material)) for label, material in expected
    }
    beyond = (model.uv[model.triangles][..., 0].max(1)) > 1
    np.testing.assert_array_equal(head.material[:-6], np.where(beyond, Material.HEAD, Material.FACE))
    np.testing.assert_array_equal(head.label[:-6] == INDEX["neck"], beyond)
    moved = turned.vertices[turned.triangles[-6:]].reshape(-1, 3) - head.vertices[head.triangles[-6:]].reshape(-1, 3)
    assert np.linalg.norm(moved, axis=1).min() > 10
