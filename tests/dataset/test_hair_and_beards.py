"""Haircuts and beards by their own measures: how thick, where they end, what they leave free."""

from dataclasses import replace

import numpy as np
import pytest
from ball_heads import CENTRE, RADIUS, ball_head, surface

from relight_core.dataset.garments.beard_shell import BeardPatch
from relight_core.dataset.garments.garment_mesh import vertex_normals
from relight_core.dataset.garments.hair_shell import ScalpGrid, ShellStyle, grow_hair

PLAIN = ShellStyle(2.0, 0.5, 1.0, 0.0, 0.0, 0.0, relief=0.0, strand_cm=1.0, comb=1.0, ragged_deg=0.0, sweep_cm=0.0)


@pytest.fixture(scope="module")
def model():
    return ball_head()


@pytest.fixture(scope="module")
def cut(model):
    """Where the hair of a style begins on the scalp, and where it is: azimuths and polar angles (V,) and (V, 3)."""
    grid, skin, made = ScalpGrid(model), surface(model, model.mean), {}

    def of(**changed):
        style = replace(PLAIN, **changed)
        if style not in made:
            hair = grow_hair(grid, model.mean, skin, style, np.random.default_rng(0))
            made[style] = (hair.uv[:, 0] - 0.5) * 360, (1 - hair.uv[:, 1]) * 150, hair.vertices
        return made[style]

    return of


def height(vertices):
    return np.linalg.norm(vertices - CENTRE, axis=1) - RADIUS


@pytest.mark.parametrize(
    ("place", "azimuth_deg", "polar_deg", "expected_cm"),
    [("crown", (0, 180), (5, 30), 2.0), ("sides", (80, 95), (78, 82), 0.5), ("back", (170, 180), (80, 94), 1.0)],
)
def test_hair_is_as_thick_as_its_style_says(cut, place, azimuth_deg, polar_deg, expected_cm):
    azimuth, polar, vertices = cut()
    there = (np.abs(azimuth) > azimuth_deg[0]) & (np.abs(azimuth) < azimuth_deg[1])
    there &= (polar > polar_deg[0]) & (polar < polar_deg[1])
    assert np.median(height(vertices[there])) == pytest.approx(expected_cm, abs=0.2), place


def hairline_deg(hair, azimuth_deg):
    azimuth, polar, _ = hair
    return polar[np.abs(np.abs(azimuth) - azimuth_deg) < 2].max()


@pytest.mark.parametrize(
    ("changed", "azimuth_deg", "moved_deg"),
    [
        ({"peak_deg": 8.0}, 0, 8),
        ({"peak_deg": 8.0}, 90, 0),
        ({"recede_deg": 12.0}, 38, -12.8),
        ({"recede_deg": 12.0}, 0, -4.8),
        ({"recede_deg": 12.0}, 120, 0),
    ],
)
def test_a_hairline_dips_in_the_middle_and_is_drawn_back_at_the_temples(cut, changed, azimuth_deg, moved_deg):
    moved = hairline_deg(cut(**changed), azimuth_deg) - hairline_deg(cut(), azimuth_deg)
    assert moved == pytest.approx(moved_deg, abs=1.5)


def test_a_bald_crown_is_bare_and_what_is_around_it_is_not(cut):
    _, polar, _ = cut(bare_crown_deg=40.0)
    assert polar.min() == pytest.approx(40, abs=1)
    assert polar.max() > 120
    assert cut()[1].min() < 2


@pytest.mark.parametrize("sweep_cm", [1.5, -1.5])
def test_a_swept_top_lies_to_its_side_and_forward(cut, sweep_cm):
    def top(changed):
        _, polar, vertices = cut(**changed)
        return vertices[polar < 20].mean(0)

    np.testing.assert_allclose(top({"sweep_cm": sweep_cm}) - top({}), [sweep_cm, 0, 0.75], atol=0.1)


def test_hair_is_closed_at_the_back_of_the_head(cut):
    azimuth, polar, vertices = cut()
    left, right = (vertices[seam][np.argsort(polar[seam])] for seam in (azimuth < -179.9, azimuth > 179.9))
    assert len(left) > 20
    np.testing.assert_allclose(left, right, atol=1e-3)


def test_tufts_are_no_spines_however_strong_a_relief_is_asked_for(cut):
    _, polar, vertices = cut(top_cm=5.0, relief=1.0, strand_cm=0.5)
    rough = np.std(height(vertices[polar < 25]))
    assert 0.05 < rough < 0.3


@pytest.fixture(scope="module")
def beards(model):
    """By kind, the places of all vertices of some beards of it."""
    patch, normals, found = BeardPatch(model), vertex_normals(model.mean, model.triangles), {}
    for seed in range(40):
        beard = patch.grow(model.mean, normals, np.random.default_rng(seed))
        found.setdefault(beard.name, []).append(beard.vertices)
    return {name: np.concatenate(places) for name, places in found.items()}


def share_of(vertices, where):
    return where(*vertices.T).mean()


def test_beards_of_every_kind_leave_the_mouth_free_and_lie_on_the_skin(beards):
    assert set(beards) == {"beard_full", "beard_goatee", "beard_moustache", "beard_circle"}
    for name, vertices in beards.items():
        assert height(vertices).min() > -0.1, name
        assert share_of(vertices, lambda x, y, z: np.hypot(x / 2.75, (y + 3.45) / 1.1) < 0.4) == 0, name


@pytest.mark.parametrize(
    ("name", "beside_mouth", "below_mouth"),
    [
        ("beard_full", True, True),
        ("beard_circle", False, True),
        ("beard_goatee", False, True),
        ("beard_moustache", False, False),
    ],
)
def test_a_beard_grows_where_its_kind_does_and_nowhere_else(beards, name, beside_mouth, below_mouth):
    def grows(where):
        return share_of(beards[name], where) > 0.02

    assert grows(lambda x, y, z: (np.abs(x) > 5) & (y > -4)) == beside_mouth
    assert grows(lambda x, y, z: (np.abs(x) < 2) & (y < -5) & (z > 4)) == below_mouth


def test_a_long_beard_is_longest_at_the_chin(beards):
    full = beards["beard_full"]
    chin, cheek = full[(full[:, 1] < -5.5) & (np.abs(full[:, 0]) < 3)], full[(full[:, 1] > -1) & (full[:, 1] < 1)]
    assert np.percentile(height(chin), 90) > 2 * np.percentile(height(cheek), 90)
