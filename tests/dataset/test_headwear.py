"""Hats of every kind: well formed, on the head and not before the face."""

import numpy as np
import pytest
from ball_heads import CENTRE, RADIUS, assert_well_formed, ball_head, surface

from relight_core.dataset.garments.hair_shell import ScalpGrid, grow_hair, sample_style
from relight_core.dataset.garments.headwear.drapes import sample_drape, wrap_head
from relight_core.dataset.garments.headwear.ring import fit_ring
from relight_core.dataset.garments.headwear.stiff_hats import STIFF_HATS, HatShape, make_stiff_hat
from relight_core.dataset.garments.headwear.wardrobe import HEADWEAR, put_on, sample_kind

EARS = np.array([[-RADIUS - 1.5, 2.0, 0.0], [RADIUS + 1.5, 2.0, 0.0]]) + CENTRE * [1, 0, 1]
OPEN = ("sun visor", "headband", "crown", "wreath", "headphones", "feathers", "bandana")


@pytest.fixture(scope="module")
def model():
    return ball_head()


@pytest.fixture(scope="module")
def grid(model):
    return ScalpGrid(model)


@pytest.fixture(scope="module")
def skin(model):
    return surface(model, model.mean)


@pytest.fixture(scope="module")
def wear(model, grid, skin):
    """One piece of headwear of each kind, made once."""
    made = {}

    def of(kind):
        if kind not in made:
            made[kind] = put_on(kind, model.mean, EARS, grid, skin, np.random.default_rng(3))
        return made[kind]

    return of


def vertices_of(garments):
    return np.concatenate([garment.vertices for garment in garments])


@pytest.mark.parametrize("kind", HEADWEAR)
def test_headwear_is_well_formed_and_outside_the_head(wear, kind):
    worn = wear(kind)
    assert worn.garments
    for garment in worn.garments:
        assert_well_formed(garment)
        assert garment.label == "hat" or (garment.label, garment.made_of) == ("cloth", "hat")
        assert garment.made_of in (None, "trim", "hat")
    vertices = vertices_of(worn.garments)
    assert (np.linalg.norm(vertices - CENTRE, axis=1) > RADIUS - 0.1).mean() > 0.97
    assert len(vertices) < 120_000


@pytest.mark.parametrize("kind", [kind for kind in HEADWEAR if kind not in OPEN])
def test_hats_cover_the_crown(wear, kind):
    worn = wear(kind)
    vertices = vertices_of(worn.garments)
    assert vertices[:, 1].max() > CENTRE[1] + RADIUS + 0.2
    toward = vertices - CENTRE
    toward /= np.linalg.norm(toward, axis=1, keepdims=True)
    # Whatever way the upper skull looks, some of the hat is near.
    for x, z in ((0, 0), (0.3, 0.3), (-0.3, 0.3), (0.3, -0.4), (-0.3, -0.4)):
        up = np.array([x, np.sqrt(1 - x * x - z * z), z])
        assert (toward @ up).max() > 0.97


@pytest.mark.parametrize("kind", [kind for kind in HEADWEAR if kind != "face helmet"])
def test_headwear_leaves_nose_and_eyes_free(wear, kind):
    worn = wear(kind)
    for garment in worn.garments:
        toward = garment.vertices[garment.faces].mean(1) - CENTRE
        ahead = (np.abs(toward[:, 0]) < 1.5) & (toward[:, 2] > 0) & (np.abs(toward[:, 1] + 1) < 0.7)
        assert not ahead.any()


def test_every_kind_is_drawn_and_the_same_seed_draws_the_same():
    drawn = {sample_kind(np.random.default_rng(seed)) for seed in range(2500)}
    assert drawn == set(HEADWEAR)
    assert sample_kind(np.random.default_rng(9)) == sample_kind(np.random.default_rng(9))


def test_a_ring_fits_the_head_and_tilts_with_its_roll(model, grid):
    level = fit_ring(grid, model.mean, 60, 90, 0.0, 0.5)
    tilted = fit_ring(grid, model.mean, 60, 90, 15.0, 0.5)
    assert np.linalg.norm(level.place(level.radius - 0.5, 0.0) - CENTRE, axis=-1) == pytest.approx(RADIUS, abs=1.0)
    assert tilted.axes[0][1] == pytest.approx(np.sin(np.radians(15)), abs=0.06)
    np.testing.assert_allclose(tilted.axes @ tilted.axes.T, np.eye(3), atol=1e-6)
    points = np.random.default_rng(0).normal(size=(20, 3))
    back = tilted.middle + tilted.local(points) @ tilted.axes
    np.testing.assert_allclose(back, points, atol=1e-9)


def test_a_wider_head_gets_a_wider_hat(model, grid):
    narrow = fit_ring(grid, model.mean, 60, 90, 0, 0.5)
    wide = fit_ring(grid, model.mean * np.array([1.2, 1, 1], np.float32), 60, 90, 0, 0.5)
    assert wide.radius.max() > narrow.radius.max() + 1


def test_a_brim_reaches_as_far_and_falls_as_much_as_its_shape_says(model, grid, skin):
    ring = fit_ring(grid, model.mean, 60, 90, 0, 0.5)
    lowest = {}
    for dip in (0.0, 1.0):
        shape = HatShape(10, 3, front_cm=8, side_cm=8, back_cm=8, dip=dip, slump_cm=0)
        hat = make_stiff_hat(ring, skin, shape, np.random.default_rng(0))[0]
        local = ring.local(hat.vertices)
        assert np.hypot(local[:, 0], local[:, 2]).max() == pytest.approx(ring.radius.max() + 8, abs=0.3)
        lowest[dip] = local[:, 1].min()
    assert lowest[0.0] == pytest.approx(0, abs=0.1)
    assert lowest[1.0] == pytest.approx(-8, abs=0.1)


def test_hair_under_a_hat_lies_flat_and_stays_below_it(model, grid, skin):
    rng = np.random.default_rng(2)
    worn = put_on("top hat", model.mean, EARS, grid, skin, rng)
    hair = grow_hair(grid, model.mean, skin, sample_style(rng), rng).vertices
    flat = skin.press_down(hair, worn.ceiling_cm(hair))
    height = np.linalg.norm(flat - CENTRE, axis=1) - RADIUS
    above = worn.ring.local(flat)[:, 1] > 0.5
    assert height[above].max() < 0.5
    assert worn.presses
    loose = put_on("headband", model.mean, EARS, grid, skin, rng)
    assert not loose.presses
    assert loose.ceiling_cm(np.array([[0.0, 40.0, 0.0]]))[0] > 5


def test_a_headscarf_is_hat_above_the_chin_and_cloth_of_the_same_stuff_below(model, skin):
    body = np.concatenate([model.mean, model.mean * [1.2, 0.3, 1] + [0, -12, 0]])
    for seed in range(4):
        shape = sample_drape("headscarf", np.random.default_rng(seed))
        parts = wrap_head(body, skin, shape, np.random.default_rng(seed))
        upper, lower = parts
        assert (upper.label, lower.label, lower.made_of) == ("hat", "cloth", "hat")
        assert upper.vertices[:, 1].min() == pytest.approx(lower.vertices[:, 1].max(), abs=0.05)
        assert lower.vertices[:, 1].min() > shape.lowest_cm - 0.05


@pytest.mark.parametrize("name", STIFF_HATS)
def test_a_hat_has_no_holes_from_brim_to_top(wear, name):
    hat = wear(name).garments[0]
    sides = np.sort(np.concatenate([hat.faces[:, [0, 1]], hat.faces[:, [1, 2]], hat.faces[:, [2, 0]]]), 1)
    edges, count = np.unique(sides, axis=0, return_counts=True)
    assert count.max() == 2
    # Only the outer edge, the middle of the top and the seam at the back are open.
    lone = hat.vertices[edges[count == 1].ravel()]
    ring_edges = 181 * 2 + 2 * 60
    assert len(lone) // 2 <= ring_edges + 4


def test_a_mortarboard_leans_back_so_that_its_underside_shows(model, grid, skin):
    leans_deg = []
    for seed in range(8):
        worn = put_on("mortarboard", model.mean, EARS, grid, skin, np.random.default_rng(seed))
        board = next(part for part in worn.garments if part.name == "board").vertices
        along = board[board[:, 2].argmax()] - board[board[:, 2].argmin()]
        leans_deg.append(np.degrees(np.arctan2(along[1], along[2])))
    assert min(leans_deg) > 10
    assert np.mean(leans_deg) > 22
