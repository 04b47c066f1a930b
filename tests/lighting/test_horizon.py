"""Hard shadows of a height field under one small lamp."""

import numpy as np
import pytest

from relight_core.lighting.horizon import Horizon

SIZE = 64


def toward(azimuth_deg, elevation_deg):
    """Azimuth 0 is the right of the image, 90 its top; elevation 90 is the camera."""
    a, e = np.radians([azimuth_deg, elevation_deg])
    return float(np.cos(a) * np.cos(e)), float(np.sin(a) * np.cos(e)), float(np.sin(e))


def horizon(relief, covered=None):
    covered = np.ones((SIZE, SIZE), bool) if covered is None else covered
    return Horizon(relief.astype(np.float32), covered)


def wall(height):
    relief = np.zeros((SIZE, SIZE))
    relief[:, 31:35] = height
    return relief


@pytest.mark.parametrize("elevation_deg", [30.0, 45.0])
def test_a_wall_throws_a_shadow_as_long_as_its_height_asks_for(elevation_deg):
    seen = horizon(wall(0.25)).visibility(toward(0, elevation_deg), 1.0)[SIZE // 2]
    length_px = 0.25 / np.tan(np.radians(elevation_deg)) * SIZE / 2
    dark = np.flatnonzero(seen < 0.5)
    assert dark.max() <= 34
    assert 31 - dark.min() == pytest.approx(length_px, abs=2)
    assert seen[35:].min() > 0.99


@pytest.mark.parametrize(
    ("azimuth_deg", "axis", "flip"), [(0, 1, False), (180, 1, True), (90, 0, False), (270, 0, True)]
)
def test_the_shadow_lies_away_from_the_lamp(azimuth_deg, axis, flip):
    relief = wall(0.3) if axis == 1 else wall(0.3).T
    seen = horizon(relief).visibility(toward(azimuth_deg, 40), 1.0).mean(1 - axis)
    before, behind = seen[11:31].mean(), seen[35:55].mean()
    # Rows run downward: a lamp at the top throws the shadow to higher rows.
    lamp_is_at_high_index = (axis == 1) != flip
    assert (before < behind) == lamp_is_at_high_index


def test_a_larger_lamp_has_a_wider_penumbra():
    widths = []
    for radius_deg in (1.0, 3.0, 6.0):
        seen = horizon(wall(0.4)).visibility(toward(0, 40), radius_deg)[SIZE // 2]
        widths.append(int(((seen > 0.02) & (seen < 0.98)).sum()))
    assert widths[0] < widths[1] < widths[2]


def test_planes_and_the_border_throw_none():
    slope = np.linspace(-0.5, 0.5, SIZE)[None].repeat(SIZE, 0)
    assert horizon(np.full((SIZE, SIZE), 7.0)).visibility(toward(30, 20), 1.0).min() > 0.99
    assert horizon(slope).visibility(toward(0, 60), 1.0).min() > 0.99


def test_what_is_not_covered_throws_none():
    covered = np.ones((SIZE, SIZE), bool)
    covered[:, 31:35] = False
    assert horizon(wall(0.5), covered).visibility(toward(0, 40), 1.0)[:, :30].min() > 0.99


def test_the_shadow_moves_evenly_with_the_lamp():
    seen = horizon(wall(0.3))
    shares = [float((1 - seen.visibility(toward(turn, 40), 2.0)).mean()) for turn in np.linspace(0, 12, 25)]
    assert np.abs(np.diff(shares)).max() < 0.01


def lamp_passing_a_post(elevation_deg, turns_deg):
    """How much of a lamp of 12 degrees is seen from one side of an upright post, at each azimuth of it."""
    relief = np.zeros((SIZE, SIZE))
    relief[:32, 40:44] = 4.0
    at = horizon(relief)
    return np.array([at.visibility(toward(turn, elevation_deg), 6.0)[32, 10] for turn in turns_deg])


def test_an_upright_edge_is_as_soft_as_a_level_one():
    """What a post hides comes back as a lamp of 12 degrees across moves aside, not at once."""
    seen = lamp_passing_a_post(20, np.linspace(-20, 20, 161))
    assert seen[0] == 1
    assert seen[-1] == 0
    assert np.abs(np.diff(seen)).max() < 0.08


def test_the_shadow_of_a_thin_brim_far_off_has_no_stripes():
    brim = np.zeros((128, 128))
    brim[20:22] = 0.6
    seen = Horizon(brim.astype(np.float32), np.ones((128, 128), bool)).visibility(toward(90, 30), 1.0)[:, 64]
    shadow = seen[30:80]
    assert shadow.max() < 0.01


@pytest.mark.parametrize(("azimuth_deg", "leans_deg"), [(70, 17), (90, 0), (90, 17), (250, 17), (270, 17)])
@pytest.mark.parametrize("elevation_deg", [30, 48])
def test_no_ray_steps_over_a_brim_that_is_a_pixel_wide(azimuth_deg, leans_deg, elevation_deg):
    """However far behind it: its shadow would be striped."""
    rows, columns = np.indices((128, 128)) - 63.5
    facing = np.radians(azimuth_deg + leans_deg)
    beyond = columns * np.cos(facing) - rows * np.sin(facing)
    brim = np.where(np.abs(beyond - 20) <= 0.6, np.float32(0.3), np.float32(0))
    seen = Horizon(brim, np.ones((128, 128), bool)).visibility(toward(azimuth_deg, elevation_deg), 0.5)
    behind_px = (20 - beyond) / np.cos(np.radians(leans_deg))
    ends_px = 0.3 * 64 / np.tan(np.radians(elevation_deg))
    within = np.maximum(np.abs(rows), np.abs(columns)) < 30
    assert seen[within & (behind_px > 2) & (behind_px < ends_px - 2)].max() == 0
    assert seen[within & (behind_px > ends_px + 2)].min() == 1


def test_steps_of_a_relief_as_low_as_a_lattices_hide_no_lamp():
    steps = np.zeros((SIZE, SIZE))
    steps[:, ::2] = 0.0015
    assert horizon(steps).visibility(toward(0, 2), 0.5).min() == 1


def test_a_lamp_near_the_camera_is_as_wide_across_a_post_as_one_at_the_side():
    """Twelve degrees across are twenty-four of azimuth at an elevation of 60."""
    seen = lamp_passing_a_post(60, np.linspace(-40, 40, 81))
    assert seen[0] == 1
    assert 16 < ((seen > 0.02) & (seen < 0.98)).sum() < 32


@pytest.mark.parametrize("azimuth_deg", [15.0, 100.0, 199.0, 283.0, 352.0])
def test_a_post_throws_its_shadow_straight_away_from_a_lamp_at_any_azimuth(azimuth_deg):
    post = np.zeros((128, 128), np.float32)
    post[61:67, 61:67] = 0.6
    seen = Horizon(post, np.ones((128, 128), bool)).visibility(toward(azimuth_deg, 35), 1.0)
    around = np.radians(azimuth_deg + 180 + np.array([0.0, 25.0, -25.0, 180.0]))
    columns, rows = (np.rint(63.5 + 32 * side(around)).astype(int) for side in (np.cos, lambda turn: -np.sin(turn)))
    behind, *beside = seen[rows, columns]
    assert behind < 0.05
    assert min(beside) > 0.95


@pytest.mark.parametrize("azimuth_deg", [20.0, 47.0, 88.0])
def test_a_turned_relief_has_turned_shadows(azimuth_deg):
    bumps = np.random.default_rng(3).random((8, 8)).repeat(8, 0).repeat(8, 1) * 0.3
    straight = horizon(bumps).visibility(toward(azimuth_deg, 30), 2.0)
    for quarters in (1, 2, 3):
        turned = horizon(np.rot90(bumps, quarters).copy()).visibility(toward(azimuth_deg + 90 * quarters, 30), 2.0)
        assert np.abs(np.rot90(turned, -quarters) - straight).mean() < 0.005


@pytest.mark.parametrize(("risen", "share"), [(-1.2, 0.0), (-0.5, 0.1955), (0.0, 0.5), (0.5, 0.8045), (1.2, 1.0)])
def test_of_a_disc_that_rises_over_a_slope_that_share_is_seen_which_is_above_it(risen, share):
    """By the area of a disc's segment; a slope's horizon is itself."""
    slope = (np.arange(SIZE) + 0.5)[None].repeat(SIZE, 0) / SIZE
    elevation_deg = np.degrees(np.arctan(0.5)) + risen * 4.0
    seen = horizon(slope).visibility(toward(0, elevation_deg), 4.0)
    assert seen[20:44, 4:20].mean() == pytest.approx(share, abs=0.03)
