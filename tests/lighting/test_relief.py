"""Cast shadow by marching a relief."""

import numpy as np
import pytest
import torch

from relight_core.imaging.tensor_colour import grey
from relight_core.lighting.reflection import ReflectionTable
from relight_core.lighting.relief import horizon_slopes, march_relief, march_reliefs
from relight_core.lighting.sphere import directions

SIZE = 32


def facing_camera():
    normal = torch.zeros(3, SIZE, SIZE)
    normal[2] = 1
    return normal


def covered():
    return torch.ones(SIZE, SIZE)


def lamp(side):
    """A lamp 45 degrees to a side ("left" or "right" in the image) of the camera."""
    radiance = torch.zeros(1, 16, 32, 3)
    # u = 3/4 lies on the right of the image, u = 1 behind the camera: 7/8 lies between.
    column = {"right": 28, "left": 3}[side]
    radiance[:, 7:9, column] = 50
    return radiance


def wall():
    """A plane with an upright bar in the middle, half as high as the image's half-width."""
    relief = torch.zeros(SIZE, SIZE)
    relief[:, 15:17] = 0.5
    return relief


def shadow(relief, light, where=None):
    where = covered() if where is None else where
    return march_relief(relief, facing_camera(), where).shadow_fraction(light)[0, 0]


def test_reliefs_marched_together_are_marched_as_each_alone():
    reliefs = torch.stack([wall(), wall().T])
    normals, where = facing_camera().expand(2, -1, -1, -1), torch.stack([covered(), covered().tril()])
    together = march_reliefs(reliefs, normals, where)
    for number, transport in enumerate(together):
        alone = march_relief(reliefs[number], facing_camera(), where[number])
        torch.testing.assert_close(transport.shadowed, alone.shadowed, atol=1e-6, rtol=1e-4)
        torch.testing.assert_close(transport.unshadowed, alone.unshadowed)
    assert not torch.equal(together[0].shadowed, together[1].shadowed)


def test_a_plane_casts_no_shadow():
    light = torch.from_numpy(np.random.default_rng(0).gamma(1, 1, (1, 16, 32, 3)).astype(np.float32))
    assert shadow(torch.zeros(SIZE, SIZE), light).max() < 0.02


@pytest.mark.parametrize("height", [0.4, -0.4])
@pytest.mark.parametrize("side", ["left", "right"])
def test_height_of_a_plane_does_not_matter(height, side):
    """Least of all at the image's border, where there is nothing to see beyond."""
    assert shadow(torch.full((SIZE, SIZE), height), lamp(side)).max() < 0.02


@pytest.mark.parametrize(
    ("side", "lit", "dark"), [("right", slice(19, 26), slice(11, 14)), ("left", slice(6, 13), slice(18, 21))]
)
def test_a_wall_shades_the_side_away_from_the_lamp_only(side, lit, dark):
    cast = shadow(wall(), lamp(side))
    assert cast[8:24, dark].min() > 0.8
    assert cast[8:24, lit].max() < 0.05


def test_a_lower_wall_casts_a_shorter_shadow():
    high, low = (shadow(wall() * part, lamp("right"))[16, :14].sum() for part in (1.0, 0.4))
    assert 0 < low < 0.8 * high


def test_mirrored_relief_and_light_give_the_mirrored_shadow():
    rng = np.random.default_rng(1)
    relief = torch.from_numpy(rng.random((SIZE, SIZE)).astype(np.float32)) * 0.3
    light = torch.from_numpy(rng.gamma(0.3, 1, (1, 16, 32, 3)).astype(np.float32))
    straight = shadow(relief, light)
    in_mirror = shadow(relief.flip(1), light.flip(2))
    torch.testing.assert_close(in_mirror.flip(1), straight, rtol=1e-3, atol=1e-3)


def test_what_is_not_covered_casts_no_shadow_and_takes_none():
    where = covered()
    where[:, 14:18] = 0
    cast = shadow(wall(), lamp("right"), where)
    assert cast[:, 18:].max() < 0.05
    assert cast[:, :14].max() < 0.05
    assert cast[:, 14:18].max() == 0


def test_black_light_and_no_light_on_the_surface_give_no_nan():
    transport = march_relief(wall(), facing_camera(), covered())
    behind = torch.zeros(1, 16, 32, 3)
    behind[:, 8, 16] = 5
    for light in (torch.zeros(1, 16, 32, 3), behind):
        assert transport.shadow_fraction(light).abs().max() == 0


def test_fractions_do_not_depend_on_the_level_and_stay_in_range():
    light = torch.from_numpy(np.random.default_rng(2).gamma(0.3, 1, (2, 16, 32, 3)).astype(np.float32))
    transport = march_relief(wall(), facing_camera(), covered())
    fraction = transport.shadow_fraction(light)
    assert fraction.shape == (2, 1, SIZE, SIZE)
    assert ((fraction >= 0) & (fraction <= 1)).all()
    torch.testing.assert_close(transport.shadow_fraction(light * 7), fraction, rtol=1e-3, atol=1e-4)


def test_visibility_is_what_the_shadow_leaves():
    transport, light = march_relief(wall(), facing_camera(), covered()), lamp("right")
    lost = transport.shadow_fraction(light)
    seen = transport.visibility(light[..., 0], SIZE)
    torch.testing.assert_close(seen, 1 - lost, atol=1e-4, rtol=0)
    assert transport.visibility(light[..., 0].repeat(2, 1, 1), 3 * SIZE).shape == (2, 1, 3 * SIZE, 3 * SIZE)


def test_light_from_behind_hides_nothing():
    behind = torch.zeros(1, 16, 32)
    behind[:, 8, 15] = 100
    assert march_relief(wall(), facing_camera(), covered()).visibility(behind, SIZE).min() == 1


@pytest.mark.parametrize(("turns", "azimuth_deg"), [(0, 0.0), (1, 90.0), (2, 180.0), (3, 270.0)])
def test_a_terrace_hides_the_sky_on_its_side_up_to_its_rim(turns, azimuth_deg):
    """Half a half-width high, and as far to the right of a point in the middle, or above it: up to 45 degrees."""
    relief = torch.zeros(1, 64, 64)
    relief[:, :, 48:] = 0.5
    around = torch.deg2rad(torch.tensor([0.0, 90.0, 180.0, 270.0]) + azimuth_deg)
    slopes = horizon_slopes(relief.rot90(turns, (1, 2)), torch.ones(1, 64, 64), around)
    assert slopes[:, 0, 32, 32].tolist() == pytest.approx([1.0, 0.0, 0.0, 0.0], abs=0.15)


def test_gloss_of_a_lamp_that_is_hidden_is_lost_though_most_of_the_irradiance_is_not():
    slanting = torch.zeros(3, SIZE, SIZE)
    slanting[0], slanting[2] = 0.5, 0.75**0.5
    key, behind = torch.zeros(2, 1, 16, 32, 3)
    key[:, 7:9, 31] = 50
    # 17 degrees behind the plane of the image, on its right, where the wall stands before it.
    behind[:, 7:9, 22] = 50
    transport = march_relief(wall(), slanting, covered())

    def lost(fraction):
        return fraction[0, 0, SIZE // 2, 10:14].mean()

    assert lost(transport.shadow_fraction(behind)) > 0.95
    assert lost(transport.gloss_fraction(behind)) > 0.95
    assert lost(transport.shadow_fraction(key)) < 0.1
    assert lost(transport.gloss_fraction(key)) < 0.1
    assert lost(transport.shadow_fraction(key + behind)) < 0.25
    assert lost(transport.gloss_fraction(key + behind)) > 0.5


def test_of_two_lamps_each_loses_its_share_of_the_gloss():
    """The texels of one that stands high are small."""
    upward = torch.zeros(3, SIZE, SIZE)
    upward[0], upward[1], upward[2] = 0.3, 0.6, 0.55**0.5
    transport, table = march_relief(wall(), upward, covered()), ReflectionTable()
    beside, above = torch.zeros(2, 1, 16, 32, 3)
    beside[:, 7:9, 26:28], above[:, :2, 2:10] = 50, 50
    lights = beside, above, beside + above
    lost = [transport.gloss_fraction(light)[0, 0, SIZE // 2, 10:14] for light in lights]
    gloss = [grey(table(light, upward[None])[:, 3:])[0, 0, SIZE // 2, 10:14] for light in lights]
    assert (lost[0] - lost[1]).min() > 0.5
    both = (lost[0] * gloss[0] + lost[1] * gloss[1]) / gloss[2]
    torch.testing.assert_close(lost[2], both, atol=0.03, rtol=0)


def test_gloss_is_lost_in_no_light_and_off_the_surface_nowhere():
    half = covered()
    half[:, : SIZE // 2] = 0
    transport = march_relief(wall(), facing_camera(), half)
    assert not transport.gloss_fraction(torch.zeros(1, 16, 32, 3)).any()
    assert not transport.gloss_fraction(lamp("left"))[..., : SIZE // 2].any()


def test_under_an_even_light_of_one_a_white_wall_that_faces_the_camera_sends_out_one():
    transport = march_relief(torch.zeros(SIZE, SIZE), facing_camera(), covered())
    torch.testing.assert_close(transport.unshadowed.sum(1), torch.ones(SIZE**2), rtol=0.02, atol=0)


def test_where_there_is_no_surface_nothing_is_hidden_behind_a_wall():
    where = covered()
    where[:, :15] = 0
    transport = march_relief(wall(), facing_camera(), where)
    seen = transport.visibility(lamp("right")[..., 0], SIZE)[0, 0]
    assert seen[:, :14].min() == 1
    assert not transport.shadow_fraction(lamp("right"))[..., :15].any()


def test_of_lamps_of_two_colours_each_counts_by_its_luminance():
    """Left of the wall the right one is hidden: pure blue it takes little of the light, pure green nearly all."""
    white, blue, green = torch.ones(3), torch.tensor([0.0, 0.0, 1.0]), torch.tensor([0.0, 1.0, 0.0])
    lost = [
        float(shadow(wall(), lamp("left") * other + lamp("right") * hidden)[16, 11:14].mean())
        for hidden, other in ((blue, green), (green, blue), (white, white))
    ]
    luminances = 0.0722 / 0.7874, 0.7152 / 0.7874, 0.5
    assert lost == pytest.approx(luminances, abs=0.05)


def test_where_a_lamp_gives_next_to_nothing_its_shadow_is_none():
    strong, faint = lamp("right"), lamp("right") * 2e-3
    irradiance = (march_relief(wall(), facing_camera(), covered()).unshadowed @ faint[0, ..., 0].flatten()).max()
    assert 1e-3 < irradiance < 0.01
    assert shadow(wall(), strong)[16, 11:14].min() > 0.8
    assert shadow(wall(), faint)[16, 11:14].max() < 0.2


@pytest.mark.parametrize(("row", "column"), [(4, 29), (6, 27), (11, 29), (12, 2), (4, 3), (9, 5)])
def test_a_post_throws_its_shadow_straight_away_from_a_lamp(row, column):
    size = 64
    post, normal = torch.zeros(size, size), torch.zeros(3, size, size)
    post[28:36, 28:36], normal[2] = 0.6, 1.0
    light = torch.zeros(1, 16, 32, 3)
    light[0, row, column] = 200.0
    x, y, _ = directions(16, 32)[row, column]
    lost = march_relief(post, normal, torch.ones(size, size)).shadow_fraction(light)[0, 0].numpy()
    away = np.arctan2(-y, -x) + np.radians([0.0, 40.0, -40.0, 180.0])
    columns, rows = (np.rint(31.5 + 12 * along).astype(int) for along in (np.cos(away), -np.sin(away)))
    behind, *beside = lost[rows, columns]
    assert behind > 0.8
    assert max(beside) < 0.1
