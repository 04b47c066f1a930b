"""Integers that compress well, and what rounding to them costs; shards of the first version."""

import numpy as np
import pytest
from synthetic_heads import ball

from relight_core.dataset.baking import shard_coding as coding
from relight_core.dataset.baking.shard import read_shard, write_shard
from relight_core.errors import InputError


def differences(codes):
    """Version 2's coding: each code less the one before, the sign in the lowest bit, high bytes first."""
    step = np.diff(codes.astype(np.int64), axis=0, prepend=np.zeros_like(codes[:1]))
    step = (step + 32768) % 65536 - 32768
    folded = np.where(step < 0, -2 * step - 1, 2 * step)
    return np.stack([folded // 256, folded % 256]).astype(np.uint8)


@pytest.mark.parametrize(("steps", "most_deg"), [(4095, 0.06), (2047, 0.12)])
def test_normals_of_every_direction_come_back(steps, most_deg):
    normals = np.random.default_rng(0).standard_normal((20_000, 3))
    normals = np.concatenate([normals / np.linalg.norm(normals, axis=1, keepdims=True), np.eye(3), -np.eye(3)])
    back = coding.decode_normals(coding.code_normals(normals, steps), steps)
    np.testing.assert_allclose(np.linalg.norm(back, axis=1), 1, atol=1e-6)
    assert np.degrees(np.linalg.norm(back - normals, axis=1)).max() < most_deg


def test_coordinates_and_depth_come_back():
    uv = np.random.default_rng(1).random((500, 2))
    np.testing.assert_allclose(coding.decode_uv(coding.code_uv(uv)), uv, atol=0.5 / 4000)
    depth = np.random.default_rng(2).uniform(-7.5, 7.5, 500)
    np.testing.assert_allclose(coding.decode_depth(coding.code_depth(depth)), depth, atol=0.5 / 2000)
    assert np.abs(coding.decode_depth(coding.code_depth(np.array([-1e9, 1e9])))).max() < 8


@pytest.mark.parametrize("shape", [(0,), (1,), (7, 2), (300,)])
def test_differences_of_version_2_are_undone(shape):
    codes = np.random.default_rng(3).integers(0, 65536, shape).astype(np.uint16)
    np.testing.assert_array_equal(coding.from_differences(differences(codes)), codes)


@pytest.mark.parametrize("channels", [1, 2])
@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_prediction_is_undone_whatever_is_covered(channels, share):
    rng = np.random.default_rng(4)
    covered = rng.random((9, 9)) < share
    codes = rng.integers(0, 65536, (covered.sum(), channels)).astype(np.uint16)
    planes = coding.prediction_residuals(codes, covered)
    assert planes.dtype == np.uint8
    back = coding.from_residuals(planes, covered)
    assert back.dtype == np.uint16
    np.testing.assert_array_equal(back, codes)


def test_a_slope_is_predicted_but_at_its_edges():
    row, column = np.mgrid[:12, :12]
    covered = (row > 2) & (column > 3)
    codes = (2000 + 30 * row - 17 * column)[covered][:, None].astype(np.uint16)
    planes = coding.prediction_residuals(codes, covered)
    assert (planes[:, 0, 4:, 5:] == 0).all()
    assert (planes != 0).any()


def test_blocks_of_pixels_stay_together():
    order = coding.morton_order(np.ones((8, 8), bool))
    assert sorted(order.tolist()) == list(range(64))
    assert sorted(order[:4].tolist()) == [0, 1, 8, 9]
    assert sorted(order[:16].tolist()) == [8 * y + x for y in range(4) for x in range(4)]


def test_a_shard_of_the_first_version_is_still_read(tmp_path):
    head = ball(16, dark_side="right")
    path = tmp_path / "head-0000000.npz"
    np.savez_compressed(
        path,
        version=np.int32(1),
        covered=np.packbits(head.covered),
        size=np.int32(16),
        normal=head.normal.astype(np.float16),
        depth=head.depth.astype(np.float16),
        uv=np.round(head.uv * 65535).astype(np.uint16),
        material=head.material,
        label=head.label,
        visibility=head.visibility,
    )
    back = read_shard(path)
    np.testing.assert_array_equal(back.visibility, head.visibility)
    np.testing.assert_allclose(back.normal, head.normal, atol=2e-3)
    np.testing.assert_allclose(back.depth, head.depth, atol=2e-3)
    assert back.albedo is None
    with np.load(path) as data:
        np.savez(path, **dict(data) | {"normal": data["normal"][:-1]})
    with pytest.raises(InputError, match="pixels are missing"):
        read_shard(path)


def test_a_shard_of_the_second_version_is_still_read(tmp_path):
    head = ball(16, dark_side="right")
    order = coding.morton_order(head.covered)
    np.savez_compressed(
        tmp_path / "head-0000000.npz",
        version=np.int32(2),
        covered=np.packbits(head.covered),
        size=np.int32(16),
        normal=differences(coding.code_normals(head.normal, 4095)),
        depth=differences(np.round((head.depth + 8) * 4096).astype(np.uint16)),
        uv=differences(np.round(head.uv * 8191).astype(np.uint16)),
        material=head.material,
        label=head.label,
        visibility=coding.reorder_bits(head.visibility, len(order), order),
        albedo=np.empty((0, 3), np.uint8),
    )
    back = read_shard(tmp_path / "head-0000000.npz")
    np.testing.assert_array_equal(back.visibility, head.visibility)
    np.testing.assert_allclose(back.normal, head.normal, atol=1.1e-3)
    np.testing.assert_allclose(back.depth, head.depth, atol=2e-4)
    np.testing.assert_allclose(back.uv, head.uv, atol=1e-4)


def test_a_scans_albedo_comes_back(tmp_path):
    head = ball(16)
    own = np.random.default_rng(0).random((len(head.normal), 3)).astype(np.float32)
    write_shard(tmp_path / "head-0000000.npz", type(head)(**{**head.__dict__, "albedo": own}))
    back = read_shard(tmp_path / "head-0000000.npz")
    np.testing.assert_allclose(back.albedo, own, atol=0.006)
    np.testing.assert_array_equal(back.visibility, head.visibility)
