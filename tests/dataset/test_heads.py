"""What a head model is posed by: expressions by name, eyes about their own middles, turns in the paper's ranges."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_heads import write_head_model

from relight_core.dataset.heads import (
    expression_weights,
    load_head_model,
    pose,
    rotation_matrix,
    sample_pose,
    turn_eyes,
)
from relight_core.errors import InputError


@pytest.fixture
def model(tmp_path):
    write_head_model(tmp_path / "model.npz")
    return load_head_model(tmp_path / "model.npz")


def spoiled(path, name, change):
    """A head model with one of its arrays changed in place, or replaced by what `change` returns."""
    write_head_model(path)
    with np.load(path) as data:
        arrays = dict(data)
    changed = change(arrays[name])
    np.savez(path, **(arrays | ({name: changed} if changed is not None else {})))
    return path


@pytest.mark.parametrize(("name", "value"), [("mean", np.nan), ("identity", np.inf), ("uv", np.nan)])
def test_a_model_with_what_is_no_number_is_refused_by_its_name(name, value, tmp_path):
    path = spoiled(tmp_path / "model.npz", name, lambda array: array.reshape(-1).__setitem__(5, value))
    with pytest.raises(InputError, match=f"model.npz.*'{name}'"):
        load_head_model(path)


@pytest.mark.parametrize("name", ["faces", "faces_uv", "face_region", "vertex_region", "landmarks68"])
@pytest.mark.parametrize("index", [-1, 100_000])
def test_a_model_that_names_what_it_has_not_is_refused(name, index, tmp_path):
    path = spoiled(tmp_path / "model.npz", name, lambda array: replaced(array.astype(np.int64), index))
    with pytest.raises(InputError, match=f"model.npz: its '{name}' name others than its [0-9]+ "):
        load_head_model(path)


def replaced(array, last):
    array.reshape(-1)[-1] = last
    return array


@pytest.mark.parametrize(
    ("name", "change", "told"),
    [
        ("mean", lambda array: array[:, :2], "'mean' is of shape"),
        ("identity", lambda array: array[:, :-1], "'identity' is of shape"),
        ("expression", lambda array: array[0], "'expression' is of shape"),
        ("expression_names", lambda array: array[:-1], "'expression_names' is of shape"),
        ("faces_uv", lambda array: array[:-1], "'faces_uv' is of shape"),
        ("faces", lambda array: array.astype(float), "'faces' name others"),
        ("uv", lambda array: array.astype(str), "'uv' are finite"),
        ("region_names", lambda array: np.where(array == "teeth", "tooth", array), "lack 'teeth'"),
    ],
)
def test_a_model_whose_arrays_do_not_fit_each_other_is_refused(name, change, told, tmp_path):
    with pytest.raises(InputError, match=told):
        load_head_model(spoiled(tmp_path / "model.npz", name, change))


def test_a_name_without_a_side_means_both_and_no_other(model):
    sided = replace(model, expression_names=("jawOpen", "mouthSmile_L", "mouthSmile_R", "mouthSmileWide"))
    assert expression_weights(sided, {"mouthSmile": 0.5}).tolist() == [0, 0.5, 0.5, 0]
    assert expression_weights(sided, {"mouthSmile_L": 0.5, "jawOpen": 1}).tolist() == [1, 0.5, 0, 0]


def test_eyes_turn_to_the_images_right_about_their_own_middles_and_nothing_else_moves(model):
    right = np.concatenate([model.vertices_of("sclera_R"), model.vertices_of("iris_R")])
    left = np.concatenate([model.vertices_of("sclera_L"), model.vertices_of("iris_L")])
    vertices = model.mean.copy()
    vertices[right] += [3, 0, 0]
    turned = turn_eyes(model, vertices, 90, 0)
    for ball in (left, right):
        before, after = vertices[ball], turned[ball]
        np.testing.assert_allclose(after.min(0) + after.max(0), before.min(0) + before.max(0), atol=1e-5)
        assert after[before[:, 2].argmax(), 0] == pytest.approx(after[:, 0].max())
    rest = np.setdiff1d(np.arange(len(vertices)), np.concatenate([left, right]))
    np.testing.assert_array_equal(turned[rest], vertices[rest])


@pytest.mark.parametrize(
    ("angles", "point", "there"),
    [
        ((90, 0, 0), (0, 0, 1), (1, 0, 0)),
        ((0, 90, 0), (0, 0, 1), (0, -1, 0)),
        ((0, 0, 90), (1, 0, 0), (0, 1, 0)),
        ((90, 0, 90), (1, 0, 0), (0, 1, 0)),
        ((90, 90, 0), (0, 1, 0), (1, 0, 0)),
    ],
)
def test_a_head_is_rolled_then_nodded_then_turned(angles, point, there):
    np.testing.assert_allclose(rotation_matrix(*angles) @ np.array(point), there, atol=1e-6)


def test_poses_stay_in_the_papers_ranges_but_for_one_in_eight_that_turns_farther():
    ahead = np.array([sample_pose(np.random.default_rng(seed))[:, 2] for seed in range(400)])
    yaw_deg, pitch_deg = np.degrees(np.arctan2(ahead[:, 0], ahead[:, 2])), np.degrees(np.arcsin(-ahead[:, 1]))
    assert 30 < np.abs(yaw_deg).max() <= 60.01
    assert 10 < np.abs(pitch_deg).max() <= 15.01
    # Of those that may turn by up to 60 degrees half do by more than 30.
    assert 0.03 < (np.abs(yaw_deg) > 30).mean() < 0.1


def test_a_posed_head_keeps_its_shape_and_turns_about_its_neck():
    head = np.random.default_rng(0).uniform(-10, 10, (40, 3)).astype(np.float32)
    nodded = pose(head, rotation_matrix(0, 15, 0))
    apart = [np.linalg.norm(points[1:] - points[:-1], axis=1) for points in (head, nodded)]
    np.testing.assert_allclose(*apart, rtol=1e-4)
    crown = np.float32([[0, 12, 0]])
    assert pose(crown, rotation_matrix(0, 15, 0))[0, 2] > 3, "a nod brings the crown forward"
