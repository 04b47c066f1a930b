"""Comparing ways to carry a relit view to the photo's size, on balls."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_heads import ball, write_balls, write_lights

from relight_core.dataset.baking.shard import write_shard
from relight_core.errors import InputError
from relight_core.evaluation import detail
from relight_core.evaluation.detail_methods import METHODS, DetailTask
from relight_core.evaluation.held_out import held_out_lights
from relight_core.face.parsing import INDEX
from relight_core.imaging.resampling import resize_area
from relight_core.imaging.view_of_photo import Materials


@pytest.mark.parametrize("name", METHODS)
def test_every_method_finds_a_uniform_change_of_a_smooth_photo(name):
    x = np.linspace(0.2, 0.6, 64, dtype=np.float32)
    photo = np.repeat((x[:, None] * x[None, :])[..., None], 3, axis=2)
    small = resize_area(photo, (32, 32))
    task = DetailTask(photo, small, 1.5 * small, np.zeros_like(small), Materials.plain(32))
    result = METHODS[name](task)
    assert result.shape == photo.shape
    np.testing.assert_allclose(result, 1.5 * photo, atol=0.02)


def test_the_comparison_names_every_method_and_region(tmp_path, monkeypatch):
    monkeypatch.setattr(detail, "_NETWORK_SIZE", 16)
    write_balls(tmp_path / "heads", 2_000_000, 1, size=32)
    write_lights(tmp_path / "lights.npz", 3)
    scores = detail.compare_detail(tmp_path / "heads", tmp_path / "lights.npz", "test", 1)
    assert scores.size == 32
    assert scores.pictures == 8
    assert set(scores.errors) == set(METHODS)
    assert all(np.isfinite(errors["head"]) for errors in scores.errors.values())
    table = detail.detail_table(scores)
    assert all(name in table for name in METHODS)


def test_heads_smaller_than_what_the_networks_see_are_refused_for_they_have_no_detail(tmp_path):
    write_balls(tmp_path / "heads", 2_000_000, 2, size=64)
    write_lights(tmp_path / "lights.npz", 3)
    with pytest.raises(InputError, match=r"head-2000000.npz: a head of 64 pixels is smaller than the 128.*--size 1024"):
        detail.compare_detail(tmp_path / "heads", tmp_path / "lights.npz", "test", 2)
    write_lights(tmp_path / "more.npz", 20)
    with pytest.raises(InputError, match="no heads of the validation split"):
        detail.compare_detail(tmp_path / "heads", tmp_path / "more.npz", "validation", 2)
    with pytest.raises(InputError, match="validation"):
        detail.compare_detail(tmp_path / "heads", tmp_path / "lights.npz", "validation", 2)


@pytest.mark.parametrize("name", ["fast global smoother", "joint bilateral, gain and gloss"])
def test_gloss_lies_over_the_photos_pattern_and_takes_nothing_of_it(name):
    x = np.linspace(0, 1, 64, dtype=np.float32)
    pattern = 0.3 + 0.1 * np.sign(np.sin(200 * x))[None] * np.ones((64, 1), np.float32)
    photo = np.repeat(pattern[..., None], 3, axis=2)
    gloss = np.repeat((0.2 * np.sin(np.pi * x)[:, None] * np.ones((1, 64), np.float32))[..., None], 3, axis=2)
    small, small_gloss = (resize_area(image, (32, 32)) for image in (photo, gloss))
    task = DetailTask(photo, small, 1.4 * small + small_gloss, small_gloss, Materials.plain(32))
    np.testing.assert_allclose(METHODS[name](task)[8:-8, 8:-8], (1.4 * photo + gloss)[8:-8, 8:-8], atol=0.04)


@pytest.fixture(scope="module")
def compared(tmp_path_factory):
    """Errors of methods of one's own on a ball, at the size of the photo itself, the tasks they were given, and what
    shadows the regions were found by."""
    folder = tmp_path_factory.mktemp("compared")
    (folder / "heads").mkdir()
    write_shard(folder / "heads" / "head-2000000.npz", ball(32, dark_side="right"))
    write_lights(folder / "lights.npz", 3)
    tasks, shadows, masks = [], [], detail._masks
    methods = {
        "truth": lambda task: tasks.append(task) or task.relit_small,
        "black": lambda task: 0 * task.photo,
    }
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(detail, "_NETWORK_SIZE", 32)
        patch.setattr(detail, "METHODS", methods)
        patch.setattr(detail, "_masks", lambda *given: shadows.append(given[2:]) or masks(*given))
        return detail.compare_detail(folder / "heads", folder / "lights.npz", "test", 1), tasks, shadows


def test_a_small_picture_that_is_as_large_as_the_photo_is_the_truth_unless_its_albedo_is_blurred(compared):
    scores, *_ = compared
    for region in ("head", "outline, head", "outline, background"):
        assert scores.errors["truth"][region] == pytest.approx(0, abs=1e-3)
        assert 0.5 < scores.blurred["truth"][region] < 60
    # 45 % of white.
    assert scores.errors["black"]["outline, background"] == pytest.approx(178.6, abs=0.5)
    assert 60 < scores.errors["black"]["head"] < 220
    assert np.isnan(scores.errors["truth"]["hair"])


def test_photo_and_truth_are_as_bright_as_a_meter_has_them_before_the_same_grey(compared):
    scores, tasks, _ = compared
    covered = ball(32).covered
    # With a perfect small picture and with a blurred one, and no method is run again for every region.
    assert len(tasks) == 2 * scores.pictures
    for task in tasks[::2]:
        for image in (task.photo, task.relit_small):
            np.testing.assert_allclose(image[~covered], 0.45, atol=1e-6)
        photo, truth = (float(np.clip(image[covered], 0, 1).mean()) for image in (task.photo, task.relit_small))
        assert 0.5 < truth / photo < 2
        luminance = task.relit_small @ np.float32([0.2126, 0.7152, 0.0722])
        assert (task.gloss_small[..., 0] <= luminance + 1e-4).all()
        assert task.gloss_small[covered].max() > 0
        assert task.gloss_small[~covered].max() == 0
    # The first photo is under the light that the lamps' photos are relit with at the end.
    np.testing.assert_allclose(np.clip(tasks[-2].relit_small, 0, 1)[covered], tasks[0].photo[covered], atol=1e-5)


def test_the_shadow_that_is_cast_is_of_the_new_light_and_the_photo_s_of_its_own(compared):
    *_, shadows = compared
    (first_cast, first_photo), (last_cast, _) = shadows[0], shadows[-1]
    # The first photo is under the light that the lamps' photos are relit with at the end.
    np.testing.assert_array_equal(first_photo, last_cast)
    assert not np.allclose(first_photo, first_cast, atol=0.01)


def test_a_table_has_every_region_under_its_name_of_perfect_pictures_and_then_of_blurred():
    perfect, blurred = ({"ratio": dict(zip(detail.REGIONS, range(at, at + 7), strict=True))} for at in (0, 10))
    blurred["ratio"]["hair"] = float("nan")
    lines = detail.detail_table(detail.DetailScores(perfect, blurred, 1, 64)).splitlines()
    titles = "head | eyes | hair | cast shadow | photo's shadow | outline, head | outline, background |"
    assert lines[0] == f"| perfect | {titles}"
    assert lines[2] == "| ratio | 0.00 | 1.00 | 2.00 | 3.00 | 4.00 | 5.00 | 6.00 |"
    assert lines[4] == f"| albedo blurred | {titles}"
    assert lines[6] == "| ratio | 10.00 | 11.00 | – | 13.00 | 14.00 | 15.00 | 16.00 |"
    assert lines[-1] == "RMS in sRGB codes, 1 relighting at 64 pixels."


def test_regions_are_where_they_are_called_and_edges_of_shadows_lie_within_the_head():
    covered = np.zeros((128, 128), bool)
    covered[:, 16:112] = True
    labels = np.where(covered, 1, 0)
    labels[:20, 16:112], labels[60:64, 40:44] = INDEX["hair"], INDEX["left_eye"]
    shadow, photos = np.zeros((2, 128, 128), np.float32)
    shadow[:, 64:], photos[90:] = 1, 1
    masks = dict(zip(detail.REGIONS, detail._masks(covered, labels, shadow, photos), strict=True))
    np.testing.assert_array_equal(masks["head"], covered)
    np.testing.assert_array_equal(masks["hair"], labels == INDEX["hair"])
    assert 16 < masks["eyes"].sum() <= 49
    assert set(np.nonzero(masks["cast shadow"])[1]) < set(range(56, 73))
    assert set(np.nonzero(masks["photo's shadow"])[0]) < set(range(82, 99))
    for name, columns in (("outline, head", (16, 111)), ("outline, background", (15, 112))):
        assert np.abs(np.subtract.outer(np.nonzero(masks[name])[1], columns)).min(1).max() <= 1
        assert not (masks[name] & masks["photo's shadow"]).any()


def test_a_region_that_some_heads_lack_is_the_mean_over_the_others():
    rows = [[1.0] * 6 + [np.nan], [4.0, np.nan] + [3.0] * 4 + [np.nan], [7.0] * 6 + [np.nan]]
    means = list(detail._means(rows).values())
    assert means[:3] == pytest.approx([4, 4, 11 / 3])
    assert np.isnan(means[6])


def test_every_head_is_under_other_lights(tmp_path):
    write_lights(tmp_path / "lights.npz", 3)
    panoramas = held_out_lights(tmp_path / "lights.npz", "test")[:3]
    lamps = [light for light in held_out_lights(tmp_path / "lights.npz", "test") if light.lamp]
    library = [*panoramas, *(replace(light, name=f"other {light.name}") for light in panoramas), *lamps]
    first, second = ([light.name for light in detail._chosen(library, number)] for number in (0, 1))
    assert not set(first[:3]) & set(second[:3])
    assert first[3:] == [lamps[0].name, lamps[1].name]
    assert second[3:] == [lamps[1].name, lamps[2].name]


@pytest.mark.parametrize("count", [1, 2, 3])
def test_no_photo_is_relit_with_its_own_light(tmp_path, count):
    write_lights(tmp_path / "lights.npz", 3)
    lights = held_out_lights(tmp_path / "lights.npz", "test")
    few = [*lights[:count], *(light for light in lights if light.lamp)]
    chosen = detail._chosen(few, 0)
    pairs = [(chosen[source].name, chosen[target].name) for source, target in detail._pairs(chosen)]
    assert len(pairs) >= 4
    assert all(source != target for source, target in pairs)
