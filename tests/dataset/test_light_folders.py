"""A folder of panoramas in place of a light library."""

import cv2
import numpy as np
import pytest

from relight_core.dataset.lighting.light_folder import read_light_folder, write_light_library
from relight_core.dataset.lighting.lights import load_lights
from relight_core.errors import InputError


def write_panorama(path, value, height=4):
    path.parent.mkdir(parents=True, exist_ok=True)
    picture = np.full((height, 2 * height, 3), value, np.float32)
    assert cv2.imwrite(str(path), picture)


@pytest.fixture
def folder(tmp_path):
    places = tmp_path / "places"
    for place in range(6):
        for number in range(2):
            write_panorama(places / f"place {place}" / f"{number}.hdr", 1.0 + place)
    write_panorama(places / "kitchen_01_1k.hdr", 0.5)
    write_panorama(places / "kitchen_02_4k.HDR", 0.5)
    write_panorama(places / "place 1" / "at night" / "0.hdr", 2.0)
    (places / "notes.txt").write_text("bought in spring")
    (places / "more.hdr").mkdir()
    return places


def test_panoramas_of_a_place_share_a_group(folder):
    arrays = read_light_folder(folder)
    groups = dict(zip(arrays["names"].tolist(), arrays["group"].tolist(), strict=True))
    assert groups["place 3/0"] == groups["place 3/1"] == "place 3"
    assert groups["kitchen_01_1k"] == groups["kitchen_02_4k"] == "kitchen"
    assert groups["place 1/at night/0"] == "place 1"
    assert list(groups)[:3] == ["kitchen_01_1k", "kitchen_02_4k", "place 0/0"]
    assert list(groups) == sorted(groups)
    assert arrays["env64"].shape == (15, 64, 128, 3)
    at = arrays["names"].tolist().index("place 4/1")
    np.testing.assert_allclose(arrays["env64"][at], 5.0, rtol=0.02)


@pytest.mark.parametrize(
    ("one", "other"),
    [("2019 kitchen 01", "2019 kitchen 02"), ("4k_studio_1", "8k_studio_2"), ("2019-05 hall", "2020-01 hall 2")],
)
def test_numbers_before_a_places_name_do_not_set_its_views_apart(one, other, tmp_path):
    for name in (one, other, "garden"):
        write_panorama(tmp_path / f"{name}.hdr", 1.0)
    groups = read_light_folder(tmp_path)["group"].tolist()
    assert len(set(groups)) == 2


def test_names_that_are_only_numbers_are_places_of_their_own(tmp_path):
    for name in ("001", "002", "2019-05"):
        write_panorama(tmp_path / f"{name}.hdr", 1.0)
    assert len(set(read_light_folder(tmp_path)["group"].tolist())) == 3


def test_a_library_with_values_that_are_no_numbers_is_refused(folder, tmp_path):
    arrays = read_light_folder(folder)
    arrays["env64"][:, 3, 5] = np.nan
    write_light_library(tmp_path / "lights.npz", arrays)
    with pytest.raises(InputError, match="no numbers"):
        load_lights(tmp_path / "lights.npz", "train")


def test_a_black_panorama_is_refused_by_its_name(folder):
    write_panorama(folder / "place 4" / "0.hdr", 0.0)
    for split in ("train", "validation", "test"):
        with pytest.raises(InputError, match="'place 4/0' is black"):
            load_lights(folder, split)


def test_a_folder_is_split_by_place_and_every_split_has_light(folder):
    names = {split: load_lights(folder, split).names for split in ("train", "validation", "test")}
    assert sorted(sum(names.values(), ())) == sorted(read_light_folder(folder)["names"].tolist())
    assert all(names.values())
    places = [{name.split("/")[0].split("_")[0] for name in names[split]} for split in names]
    assert not places[0] & places[1] | places[0] & places[2] | places[1] & places[2]


def test_a_packed_folder_is_the_same_library(folder, tmp_path):
    write_light_library(tmp_path / "lights.npz", read_light_folder(folder))
    packed, loose = load_lights(tmp_path / "lights.npz", "train"), load_lights(folder, "train")
    assert packed.names == loose.names
    np.testing.assert_array_equal(packed.panoramas, loose.panoramas)


def test_folders_that_are_no_library(tmp_path, folder):
    empty = tmp_path / "empty"
    empty.mkdir()
    with pytest.raises(InputError, match="no .hdr"):
        load_lights(empty, "train")
    write_panorama(empty / "one.hdr", 1.0)
    assert load_lights(empty, "test").names == ("one",)
    with pytest.raises(InputError, match="too few places"):
        load_lights(empty, "train")
    cv2.imwrite(str(folder / "portrait.hdr"), np.ones((8, 8, 3), np.float32))
    with pytest.raises(InputError, match=r"portrait\.hdr"):
        load_lights(folder, "train")
    (folder / "portrait.hdr").write_bytes(b"#?RADIANCE\n")
    with pytest.raises(InputError, match=r"portrait\.hdr"):
        load_lights(folder, "train")
