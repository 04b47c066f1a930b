"""Samples seen through a warp stay true: a lit ball stays a lit ball."""

import numpy as np
import pytest

from relight_core.dataset.warp import Warp, sample_warp, warped
from relight_core.lighting.sphere import directions, solid_angles

SIZE = 64


def ball(light):
    """A white matt ball of half the image's half-width, under a light (16, 32, 3)."""
    axis = (np.arange(SIZE) + 0.5) / SIZE * 2 - 1
    x, y = np.meshgrid(axis / 0.5, -axis / 0.5)
    inside = x**2 + y**2 < 1
    z = np.sqrt(np.maximum(1 - x**2 - y**2, 0))
    normal = np.where(inside[..., None], np.dstack([x, y, z]), 0).astype(np.float32)
    weight = (light * solid_angles(16, 32)[..., None]).reshape(-1, 3) / np.pi
    shading = np.maximum(normal.reshape(-1, 3) @ directions(16, 32).reshape(-1, 3).T, 0) @ weight
    return {
        "image": shading.reshape(SIZE, SIZE, 3).astype(np.float32),
        "normal": normal,
        "relief": (0.5 * z * inside).astype(np.float32),
        "covered": inside.astype(np.float32),
        "label": inside.astype(np.uint8) * 3,
        "light": light,
    }


def lamp(rng):
    light = np.full((16, 32, 3), 0.1, np.float32)
    light[rng.integers(3, 12), rng.integers(0, 32)] = 60
    return light


def similarity(turn_deg, zoom, shift=(0.0, 0.0)):
    angle = np.radians(turn_deg)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return Warp(turn_deg, zoom * turn, np.array(shift))


def test_no_warp_changes_nothing():
    sample = ball(lamp(np.random.default_rng(0)))
    for name, value in warped(sample, similarity(0, 1)).items():
        np.testing.assert_allclose(value, sample[name], atol=1e-5, err_msg=name)


@pytest.mark.parametrize("turn_deg", [20.0, -25.0])
def test_a_turned_ball_is_a_ball_under_the_turned_light(turn_deg):
    """What `warped` says of normals and light must explain what it shows."""
    for seed in range(4):
        turned = warped(ball(lamp(np.random.default_rng(seed))), similarity(turn_deg, 1.0))
        again = ball(turned["light"])
        core = again["normal"][..., 2] > 0.3
        np.testing.assert_allclose(turned["normal"][core], again["normal"][core], atol=0.04)
        np.testing.assert_allclose(turned["relief"][core], again["relief"][core], atol=0.02)
        assert set(np.unique(turned["label"])) == {0, 3}, "a label is none in between"
        # The light's texels are 11 degrees wide.
        assert np.abs(turned["image"] - again["image"])[core].mean() < 0.06 * again["image"][core].mean() + 0.02


def test_an_enlarged_ball_is_as_much_higher_and_has_its_normals():
    sample = ball(lamp(np.random.default_rng(1)))
    large = warped(sample, similarity(0, 1.4))
    assert large["relief"].max() == pytest.approx(1.4 * sample["relief"].max(), rel=0.02)
    assert large["covered"].sum() == pytest.approx(1.4**2 * sample["covered"].sum(), rel=0.05)
    middle = slice(SIZE // 2 - 1, SIZE // 2 + 1)
    np.testing.assert_allclose(large["normal"][middle, middle, 2], 1, atol=0.01)


def test_a_shift_goes_right_and_up():
    moved = warped(ball(lamp(np.random.default_rng(2))), similarity(0, 1, (0.25, 0.125)))
    rows, columns = np.nonzero(moved["covered"])
    assert columns.mean() - (SIZE - 1) / 2 == pytest.approx(8, abs=0.5)
    assert (SIZE - 1) / 2 - rows.mean() == pytest.approx(4, abs=0.5)


def test_normals_of_a_stretched_plane_are_those_of_its_slope():
    """A slope of 1 along x, twice as wide and half as high as the mean scale asks: 1 / 2 of it per width."""
    sample = ball(lamp(np.random.default_rng(3)))
    sample["normal"] = np.broadcast_to(np.float32([-1, 0, 1]) / np.sqrt(2), (SIZE, SIZE, 3)).copy()
    wide = warped(sample, Warp(0.0, np.diag([2.0, 0.5]), np.zeros(2)))["normal"][SIZE // 2, SIZE // 2]
    assert -wide[0] / wide[2] == pytest.approx(0.5, rel=1e-4)


def test_what_comes_from_beyond_the_border_is_not_covered():
    sample = ball(lamp(np.random.default_rng(4))) | {"covered": np.ones((SIZE, SIZE), np.float32)}
    moved = warped(sample, similarity(0, 1, (0.5, 0)))
    assert moved["covered"][:, : SIZE // 4 - 1].max() == 0
    assert moved["covered"][:, SIZE // 4 + 1 :].min() == 1


def test_random_warps_turn_enlarge_stretch_and_move_and_turn_by_what_they_say():
    warps = [sample_warp(np.random.default_rng(seed)) for seed in range(300)]
    columns = np.array([warp.linear.T for warp in warps])
    turned_deg = np.degrees(np.arctan2(columns[:, 0, 1], columns[:, 0, 0]))
    np.testing.assert_allclose([warp.turn_deg for warp in warps], turned_deg, atol=1e-6)
    assert np.std(turned_deg) == pytest.approx(8, rel=0.15)
    wide, high = np.log(np.linalg.norm(columns, axis=2)).T
    assert np.std(wide + high) / 2 == pytest.approx(0.09, rel=0.15)
    assert np.std(wide - high) / 2 == pytest.approx(0.031, rel=0.15)
    assert np.std([warp.shift for warp in warps], axis=0) == pytest.approx([0.04, 0.04], rel=0.15)


def test_random_warps_are_small_and_keep_types():
    sample = ball(lamp(np.random.default_rng(5)))
    for seed in range(50):
        warp = sample_warp(np.random.default_rng(seed))
        assert abs(warp.turn_deg) <= 25
        assert 0.75 < warp.scale < 1.3
    changed = warped(sample, warp)
    assert {name: (value.dtype, value.shape) for name, value in changed.items()} == {
        name: (value.dtype, value.shape) for name, value in sample.items()
    }


@pytest.mark.parametrize("hidden", [False, True])
def test_an_outline_has_the_channels_of_its_head_and_not_of_the_nothing_beside_it(hidden):
    """A level disc far behind the face's mean height stays level up to its edge, turned and enlarged."""
    sample = ball(lamp(np.random.default_rng(6)))
    inside = sample["covered"]
    sample |= {"relief": -0.5 * inside, "albedo": np.float32([0.6, 0.4, 0.2]) * inside[..., None]}
    if hidden:
        beside = inside * (np.arange(SIZE) < SIZE // 2)
        sample |= {"silhouette": inside, "covered": beside.astype(np.float32)}
    turned = warped(sample, similarity(17.0, 1.2))
    covered = turned["covered"] > 0
    assert covered.sum() > 500
    np.testing.assert_allclose(turned["relief"][covered], -0.6, atol=1e-5)
    np.testing.assert_allclose(
        turned["albedo"][covered], np.tile(np.float32([[0.6, 0.4, 0.2]]), (covered.sum(), 1)), atol=1e-5
    )
