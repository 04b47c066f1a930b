"""What lies on disk: the split of the lights, heads that come back, files that are refused."""

import numpy as np
import pytest
from synthetic_heads import ball, write_balls, write_lights

from relight_core.dataset.baking.shard import read_shard, shard_size, write_shard
from relight_core.dataset.lighting.lights import (
    LightLibrary,
    backlit,
    load_lights,
    sample_light,
    sample_panorama,
    sample_rig,
)
from relight_core.dataset.recipe import data_mark, load_split, shard_path
from relight_core.errors import InputError
from relight_core.lighting.panorama import normalise_light

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def level(light):
    edges = np.cos(np.pi * np.arange(len(light) + 1) / len(light))
    return float((((light @ LUMINANCE).mean(1)) * (edges[:-1] - edges[1:]) / 2).sum())


def test_splits_share_no_light_and_no_place(library):
    names = {split: load_lights(library, split).names for split in ("train", "validation", "test")}
    assert sorted(sum(names.values(), ())) == sorted(f"light {i}" for i in range(60))
    places = {split: {int(name.split()[1]) % 21 for name in names[split]} for split in names}
    assert not places["train"] & places["test"]
    assert not places["train"] & places["validation"]
    assert not places["test"] & places["validation"]


def test_test_and_validation_have_about_the_wanted_number(library):
    assert 18 <= len(load_lights(library, "test").names) <= 20
    assert 6 <= len(load_lights(library, "validation").names) <= 8


@pytest.mark.parametrize(("lights", "test", "validation"), [(6, 2, 1), (12, 4, 2), (20, 6, 3)])
def test_of_few_lights_most_are_learnt_from(tmp_path, lights, test, validation):
    write_lights(tmp_path / "few.npz", lights)
    counts = [len(load_lights(tmp_path / "few.npz", split).names) for split in ("test", "validation", "train")]
    assert counts == [test, validation, lights - test - validation]


def test_what_was_held_out_once_stays_so(library):
    """Else weights would be measured on lights that they have seen."""
    names = {f"light {number}" for number in (3, 24, 45, 18, 39, 15, 36, 57)}
    assert set(load_lights(library, "validation").names) == names


@pytest.mark.parametrize("content", [None, b"", b"PK\x03\x04 not really", b"\x93NUMPY", b"text" * 100])
def test_a_bad_library_is_an_input_error(tmp_path, content):
    path = tmp_path / "lights.npz"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=r"lights\.npz"):
        load_lights(path, "train")


def test_a_truncated_library_and_one_of_other_arrays(tmp_path, library):
    cut, other = tmp_path / "cut.npz", tmp_path / "other.npz"
    cut.write_bytes(library.read_bytes()[:5000])
    np.savez(other, pictures=np.zeros(3))
    for path in (cut, other):
        with pytest.raises(InputError):
            load_lights(path, "train")


@pytest.mark.parametrize(
    "places", [np.array([0, 1, np.nan, 2, 3, np.nan]), np.array(["2026-01-01"] * 5 + ["NaT"], "datetime64[D]")]
)
def test_a_library_of_places_that_no_split_could_hold_out_is_an_input_error(tmp_path, places):
    path = tmp_path / "lights.npz"
    write_lights(path, 6)
    with np.load(path) as data:
        arrays = dict(data) | {"group": places}
    np.savez(path, **arrays)
    with pytest.raises(InputError, match="a place in group is no number"):
        load_lights(path, "train")


@pytest.mark.parametrize(
    ("name", "shape"), [("env64", (6, 50, 100, 3)), ("env64", (4, 64, 128, 3)), ("names", ()), ("group", (5,))]
)
def test_a_library_of_other_shapes_is_an_input_error_and_no_fault(tmp_path, name, shape):
    path = tmp_path / "lights.npz"
    write_lights(path, 6)
    with np.load(path) as data:
        arrays = dict(data) | {name: np.zeros(shape, np.float16 if name == "env64" else "<U9")}
    np.savez(path, **arrays)
    with pytest.raises(InputError, match=name):
        load_lights(path, "train")


@pytest.mark.parametrize("kind", ["<U9", complex])
def test_a_library_whose_panoramas_are_no_real_numbers_is_an_input_error(tmp_path, kind):
    path = tmp_path / "lights.npz"
    write_lights(path, 6)
    with np.load(path) as data:
        arrays = dict(data) | {"env64": np.ones((6, 64, 128, 3), kind)}
    np.savez(path, **arrays)
    with pytest.raises(InputError, match="no real numbers"):
        load_lights(path, "train")


def test_normalised_lights_have_a_mean_luminance_of_one(library):
    light = np.random.default_rng(0).gamma(0.3, 1, (16, 32, 3)) * [3.0, 1.0, 0.2]
    assert level(normalise_light(light)) == pytest.approx(1, rel=1e-4)
    assert np.abs(normalise_light(np.zeros((16, 32, 3)))).max() == 0


def test_sampled_lights_are_lights(library):
    lights = load_lights(library, "train")
    rng = np.random.default_rng(1)
    for _ in range(30):
        light = sample_light(lights, rng)
        assert light.shape == (64, 128, 3)
        assert light.dtype == np.float32
        assert np.isfinite(light).all()
        assert (light >= 0).all()
        assert level(light) == pytest.approx(1, rel=1e-3)
    assert (sample_panorama(lights, rng) >= 0).all()
    assert (sample_rig(rng, 3, 0.1) >= 0).all()


def test_panoramas_are_turned_and_mirrored_but_never_stand_on_their_heads():
    sky = np.ones((1, 64, 128, 3), np.float32)
    sky[:, :32] = 3.0
    sky[:, :32, :20], sky[:, :32, 20:40] = 9.0, 30.0
    lights = [sample_panorama(LightLibrary(sky, ("sky",)), np.random.default_rng(seed)) for seed in range(12)]
    assert all(light[:32].min() > light[32:].max() for light in lights)
    # The sun stands right of the brighter cloud, or left of it in a mirror.
    rises = [np.roll(light[16, :, 1], 64 - int(light[16, :, 1].argmax())) for light in lights]
    rises = [row[20:60].sum() > row[84:124].sum() for row in rises]
    assert 2 < sum(rises) < 10


def test_what_is_below_nothing_in_a_library_is_nothing(tmp_path):
    path = tmp_path / "lights.npz"
    write_lights(path, 6)
    with np.load(path) as data:
        arrays = dict(data)
    arrays["env64"][:, 5] = -2
    np.savez(path, **arrays)
    assert load_lights(path, "train").panoramas.min() == 0


def test_half_of_a_backlit_light_or_more_is_new_and_none_of_that_comes_from_the_cameras_side():
    rng, before = np.random.default_rng(2), np.ones((64, 128, 3), np.float32)
    before[:, :64] = 0.5
    camera_side = np.s_[20:44, :16]
    for _ in range(20):
        after = backlit(before, rng)
        assert level(after) > 1.99
        np.testing.assert_allclose(after[camera_side], before[camera_side] / level(before), rtol=1e-4)


def test_a_shard_comes_back(tmp_path):
    head = ball(16, dark_side="right")
    write_shard(tmp_path / "head-0000000.npz", head)
    back = read_shard(tmp_path / "head-0000000.npz")
    for name in ("covered", "material", "label", "visibility"):
        np.testing.assert_array_equal(getattr(back, name), getattr(head, name))
    np.testing.assert_allclose(back.normal, head.normal, atol=2e-3)
    np.testing.assert_allclose(np.linalg.norm(back.normal, axis=1), 1, atol=1e-5)
    np.testing.assert_allclose(back.depth, head.depth, atol=2e-3)
    np.testing.assert_allclose(back.uv, head.uv, atol=1.3e-4)
    assert [p.name for p in tmp_path.iterdir()] == ["head-0000000.npz"]


@pytest.mark.parametrize("kept", [0, 1, 40, 300, -1, -30, -400])
def test_a_cut_shard_is_an_input_error(tmp_path, kept):
    path = tmp_path / "head-0000000.npz"
    write_shard(path, ball())
    path.write_bytes(path.read_bytes()[:kept])
    with pytest.raises(InputError, match="head-0000000"):
        read_shard(path)


def test_a_flipped_byte_anywhere_is_noticed_or_harmless(tmp_path):
    """The zip's checksums guard every array; a flip in its bookkeeping may also do no harm."""
    path, head = tmp_path / "head-0000000.npz", ball()
    write_shard(path, head)
    whole = path.read_bytes()
    noticed = 0
    for at in np.linspace(0, len(whole) - 1, 60).astype(int):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 0x5A]) + whole[at + 1 :])
        try:
            back = read_shard(path)
        except InputError:
            noticed += 1
        else:
            np.testing.assert_array_equal(back.visibility, head.visibility)
            np.testing.assert_array_equal(back.label, head.label)
    assert noticed > 30


def test_another_version_and_other_arrays_are_refused(tmp_path):
    path = tmp_path / "head-0000000.npz"
    np.savez(path, version=np.int32(99))
    with pytest.raises(InputError, match="version"):
        read_shard(path)
    np.savez(path, version=np.int32(1), size=np.int32(4))
    with pytest.raises(InputError):
        read_shard(path)
    with pytest.raises(InputError):
        read_shard(tmp_path / "gone.npz")


@pytest.mark.parametrize("number", [[3, 3], "3", []])
@pytest.mark.parametrize("name", ["version", "size"])
def test_a_shard_that_has_no_number_where_one_should_be_is_damaged(tmp_path, name, number):
    path = tmp_path / "head-0000000.npz"
    np.savez(path, **{name: number})
    with pytest.raises(InputError, match=f"its {name} is no number"):
        (read_shard if name == "version" else shard_size)(path)


def test_heads_belong_to_the_split_of_their_seed(tmp_path):
    for first in (0, 1_000_000, 2_000_000):
        write_balls(tmp_path, first, 2)
    for stray in ("head-0000003 (1).npz", "head-copy.npz"):
        (tmp_path / stray).touch()
    found = {split: [p.stem for p in load_split(tmp_path, split)] for split in ("train", "validation", "test")}
    assert found == {
        "train": ["head-0000000", "head-0000001"],
        "validation": ["head-1000000", "head-1000001"],
        "test": ["head-2000000", "head-2000001"],
    }


def test_heads_come_in_the_order_of_their_seeds_however_a_disk_lists_them(tmp_path):
    seeds = [(37 * number) % 101 for number in range(101)]
    for seed in seeds:
        shard_path(tmp_path, seed).touch()
    assert [path.name for path in load_split(tmp_path, "train")] == [f"head-{seed:07d}.npz" for seed in range(101)]


@pytest.mark.parametrize("added", ["heads/skins.npz", "lights/SNOW.HDR", "lights/yard/snow.exr", "lights/sky.hdr"])
def test_painted_skins_and_all_panoramas_tell_one_set_of_data_from_another(tmp_path, added):
    for place in ("heads/head-0000007.npz", "lights/sky.hdr", "lights/yard/sky.hdr"):
        (tmp_path / place).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / place).write_bytes(b"one")
    before = data_mark(tmp_path / "heads", tmp_path / "lights")
    assert data_mark(tmp_path / "heads", tmp_path / "lights") == before
    (tmp_path / added).write_bytes(b"another")
    assert data_mark(tmp_path / "heads", tmp_path / "lights") != before
