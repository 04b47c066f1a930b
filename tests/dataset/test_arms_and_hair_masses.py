"""Raised arms and great hair, as meshes on a head: closed, of believable size, in the right place."""

from collections import Counter

import numpy as np
import pytest
from ball_heads import assert_well_formed, ball_head, surface
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from relight_core.dataset.garments.field_mesh import enclosed, grid_between
from relight_core.dataset.garments.garment import Garment
from relight_core.dataset.garments.garment_mesh import vertex_normals
from relight_core.dataset.garments.hair_mass import grow_mass
from relight_core.dataset.garments.raised_arm import raise_arm


@pytest.fixture(scope="module")
def head():
    return ball_head()


def is_closed(garment):
    """Whether every edge has two triangles."""
    faces = garment.faces
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), 1)
    return set(Counter(map(tuple, edges.tolist())).values()) == {2}


def volume(garment):
    a, b, c = (garment.vertices[garment.faces[:, corner]].astype(np.float64) for corner in range(3))
    return float(np.einsum("fc,fc->f", a, np.cross(b, c)).sum() / 6)


def test_a_field_encloses_its_ball_where_it_is():
    low, middle = np.array([10.0, -4.0, 1.0]), np.array([13.0, -1.0, 4.0])
    inside = 2 - np.linalg.norm(grid_between(low, low + 6, 0.25) - middle, axis=-1)
    ball = Garment(*enclosed(inside, low, 0.25), "hair")
    assert_well_formed(ball)
    assert is_closed(ball)
    assert volume(ball) == pytest.approx(4 / 3 * np.pi * 8, rel=0.02)
    np.testing.assert_allclose(np.linalg.norm(ball.vertices - middle, axis=1), 2, atol=0.02)


@pytest.fixture(scope="module", params=range(4))
def arm(request, head):
    return raise_arm(surface(head, head.mean), np.random.default_rng(request.param))


class TestRaisedArm:
    def test_its_parts_are_closed_and_face_outward(self, arm):
        for part in arm:
            assert_well_formed(part)
            assert is_closed(part)
            assert volume(part) > 0

    def test_a_hand_is_as_large_as_a_hand(self, arm):
        hand = arm[0]
        assert hand.label == "neck"
        assert 150 < volume(hand) < 500
        assert 10 < np.linalg.norm(np.ptp(hand.vertices, axis=0)) < 33

    def test_the_hand_is_at_the_head_and_the_arm_goes_on_from_it(self, head, arm):
        hand, rest = arm[0].vertices, np.concatenate([part.vertices for part in arm[1:]])
        assert np.linalg.norm(hand[:, None] - head.mean[None, ::50], axis=2).min() < 4
        assert np.linalg.norm(hand[:, None, :] - rest[None, ::20], axis=2).min() < 1.5

    def test_only_sleeves_are_cloth(self, arm):
        assert {part.label for part in arm} <= {"neck", "cloth"}
        assert arm[1].label == "neck"


@pytest.fixture(scope="module", params=range(4))
def mass(request):
    return grow_mass(np.random.default_rng(request.param))


class TestHairMass:
    def test_covers_the_skull_and_leaves_the_face_free(self, mass):
        assert_well_formed(mass)
        assert mass.label == "hair"
        x, y, z = mass.vertices.T
        assert y.max() > 16
        assert np.ptp(x) > 20
        before_the_face = (np.abs(x) < 4) & (np.abs(y + 2) < 5) & (z > 8)
        assert not before_the_face.any()

    def test_is_in_one_piece(self, mass):
        faces, count = mass.faces, len(mass.vertices)
        links = coo_matrix(
            (np.ones(2 * len(faces)), (faces[:, [0, 1]].T.ravel(), faces[:, [1, 2]].T.ravel())), (count,) * 2
        )
        pieces, of = connected_components(links, directed=False)
        # Hollows within it are surfaces of their own; nothing is outside the largest.
        largest = mass.vertices[of == np.bincount(of).argmax()]
        assert (mass.vertices >= largest.min(0)).all()
        assert (mass.vertices <= largest.max(0)).all()

    def test_faces_outward(self, mass):
        assert volume(mass) > 2000
        normals = vertex_normals(mass.vertices, mass.faces)
        away = mass.vertices - [0, 6.5, -1]
        assert (np.einsum("vc,vc->v", normals, away) > 0).mean() > 0.6


def test_arms_and_masses_differ_by_their_random_stream(head):
    skin = surface(head, head.mean)
    hands = [raise_arm(skin, np.random.default_rng(seed))[0].vertices.mean(0) for seed in range(4)]
    assert np.ptp(hands, axis=0).max() > 3
