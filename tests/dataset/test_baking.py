"""Baking a small head model with the real ray caster, where there is one."""

import numpy as np
import pytest
from synthetic_heads import write_head_model

from relight_core.dataset.baking.scene import Scene
from relight_core.dataset.baking.shard import read_shard
from relight_core.dataset.recipe import Casting, bake_missing, shard_path
from relight_core.errors import InputError
from relight_core.imaging.file_lock import let_go, locked
from relight_core.lighting.sphere import directions


@pytest.fixture(scope="module")
def casting(tmp_path_factory):
    path = tmp_path_factory.mktemp("model") / "model.npz"
    write_head_model(path)
    try:
        from relight_core.dataset.baking.raycast import RayCaster

        corners = np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], np.float32)
        RayCaster(Scene(corners, np.array([[0, 1, 2]]), np.zeros((1, 3, 2)), np.zeros(1), np.zeros(1))).closest(
            np.array([0, 0, 5]), np.array([[0, 0, -1.0]], np.float32)
        )
    except (InputError, ImportError, RuntimeError) as error:
        pytest.skip(f"no ray caster here: it needs mitsuba and libLLVM ({error})")
    return Casting.load(path, None)


def test_rays_hit_what_lies_in_their_way(casting):
    from relight_core.dataset.baking.raycast import RayCaster

    corners = np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], np.float32)
    scene = Scene(corners, np.array([[0, 1, 2]]), np.zeros((1, 3, 2)), np.zeros(1), np.zeros(1))
    caster = RayCaster(scene)
    toward = np.array([[0, 0, -1], [0, 1, 0]], np.float32)
    triangle, barycentric, distance = caster.closest(np.array([0, 0, 5]), toward)
    assert triangle.tolist() == [0, -1]
    assert distance[0] == pytest.approx(5, abs=1e-4)
    np.testing.assert_allclose(barycentric[0], [0.25, 0.25, 0.5], atol=1e-3)
    origins = np.array([[0, 0, 1], [0, 0, 1], [5, 0, 1]], np.float32)
    blocked = caster.occluded(origins, np.array([[0, 0, -1], [0, 0, 1], [0, 0, -1]], np.float32))
    assert blocked.tolist() == [True, False, False]


def test_a_head_is_the_same_for_its_seed_and_another_for_another(casting):
    one, again, other = (casting.pose_head(seed).bake(32) for seed in (3, 3, 4))
    for name in ("covered", "normal", "depth", "uv", "label", "visibility"):
        np.testing.assert_array_equal(getattr(one, name), getattr(again, name))
    assert one.covered.shape != other.covered.shape or (one.covered != other.covered).any()


def test_a_baked_head_is_whole(casting):
    head = casting.pose_head(5).bake(32)
    count = int(head.covered.sum())
    assert 0.1 < count / 32**2 <= 1
    assert head.normal.shape == (count, 3)
    np.testing.assert_allclose(np.linalg.norm(head.normal, axis=1), 1, atol=1e-4)
    assert (head.normal[:, 2] > -0.3).all()
    assert ((head.uv >= 0) & (head.uv <= 1)).all()
    assert head.visibility.shape == (512, -(-count // 8))
    assert 0.3 < head.visible().mean() <= 1
    assert head.label.max() < 14


def test_below_their_horizon_pixels_repeat_the_texel_before(casting):
    head = casting.pose_head(6).bake(32)
    visible = head.visible()
    below = directions(16, 32).reshape(-1, 3) @ head.normal.T < -0.01
    for texel in range(1, 512):
        before = texel - 1 if texel % 32 else texel - 32
        np.testing.assert_array_equal(visible[texel][below[texel]], visible[before][below[texel]])
    assert 0.05 < below.mean() < 0.7


def test_baking_goes_on_where_it_stopped(casting, tmp_path):
    first = list(bake_missing(casting, tmp_path, range(10, 12), 32))
    stamps = [path.stat().st_mtime_ns for path in first]
    everything = list(bake_missing(casting, tmp_path, range(10, 13), 32))
    assert everything == [shard_path(tmp_path, seed) for seed in (10, 11, 12)]
    assert [path.stat().st_mtime_ns for path in first] == stamps
    assert read_shard(everything[-1]).size == 32


def test_what_a_killed_bake_was_writing_goes_when_its_head_is_baked(casting, tmp_path):
    left, other = (tmp_path / f".head-00000{seed}.npz-0123456789ab.part" for seed in (10, 11))
    lock = tmp_path / "head-0000010.lock"
    for file in (left, other, lock):
        file.touch()
    list(bake_missing(casting, tmp_path, range(10, 11), 32))
    assert {path.name for path in tmp_path.iterdir()} == {"head-0000010.npz", other.name}


def test_what_another_bake_is_writing_stays(casting, tmp_path):
    part, lock = tmp_path / ".head-0000010.npz-0123456789ab.part", tmp_path / "head-0000010.lock"
    part.touch()
    held = locked(lock)
    list(bake_missing(casting, tmp_path, range(10, 11), 32))
    assert part.exists()
    assert shard_path(tmp_path, 10).exists()
    let_go(held, lock)


def test_a_head_of_another_size_is_not_taken_for_the_one_asked_for(casting, tmp_path):
    list(bake_missing(casting, tmp_path, range(10, 11), 32))
    with pytest.raises(InputError, match="32 pixels wide and not 64"):
        list(bake_missing(casting, tmp_path, range(10, 11), 64))
