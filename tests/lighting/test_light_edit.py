"""Edited lights: energy that is kept, soft boxes that add what they say, blur alike everywhere."""

from dataclasses import replace

import numpy as np
import pytest

from relight_core.errors import InputError
from relight_core.lighting import light_edit
from relight_core.lighting.colour_temperature import kelvin_to_rgb
from relight_core.lighting.environment import Environment, network_light
from relight_core.lighting.lamps import lamps_of
from relight_core.lighting.light_blur import blur_light
from relight_core.lighting.light_edit import LightEdit, colour_gain, edit_light
from relight_core.lighting.panorama import shrink
from relight_core.lighting.soft_box import SoftBox, soft_box_radiance
from relight_core.lighting.sphere import directions, solid_angles
from relight_core.lighting.summary import meter_reading

REC709 = np.array([0.2126, 0.7152, 0.0722])


def random_light(height=32, seed=1):
    radiance = np.random.default_rng(seed).gamma(0.3, 1.0, (height, 2 * height, 3))
    return Environment.from_radiance(radiance * [3.0, 2.0, 1.0], "noise")


def radiance_of(light):
    return light.shape.astype(np.float64) * light.level


def energy(radiance):
    return np.einsum("hwc,hw->c", radiance.astype(np.float64), solid_angles(*radiance.shape[:2]))


def irradiance(radiance, normal):
    height, width = radiance.shape[:2]
    cosine = np.maximum(directions(height, width) @ np.asarray(normal, np.float32), 0.0)
    return np.einsum("hwc,hw->c", radiance.astype(np.float64), cosine * solid_angles(height, width))


@pytest.mark.parametrize("height", [16, 24, 32, 48, 50, 64, 100, 256, 300])
@pytest.mark.parametrize("draft", [False, True])
def test_a_faint_soft_box_leaves_the_rest_of_the_light_as_it_was(height, draft):
    light = random_light(height)
    before = network_light(edit_light(light, LightEdit(saturation=0.9), draft), 17.0)
    box = SoftBox(azimuth_deg=40.0, elevation_deg=10.0, width_deg=20.0, height_deg=20.0, intensity=1e-6)
    after = network_light(edit_light(light, LightEdit(saturation=0.9, boxes=(box,)), draft), 17.0)
    np.testing.assert_allclose(after, before, rtol=1e-3, atol=1e-3)


def brightest_direction(radiance):
    height, width = radiance.shape[:2]
    return directions(height, width).reshape(-1, 3)[radiance.sum(axis=2).argmax()]


def test_a_soft_box_makes_no_lamp_of_another_lights_coarse_texels():
    """A light found in a portrait can't tell a sun from a window, with soft boxes as without."""
    texels = np.full((16, 32, 3), 0.3, np.float32)
    texels[5, 20] = 200
    found = Environment.from_radiance(texels)
    assert lamps_of(edit_light(found, LightEdit(boxes=(SoftBox(azimuth_deg=-120, intensity=0.01),)))) == ()
    small = SoftBox(azimuth_deg=-120, width_deg=4, height_deg=4, softness=0, intensity=2)
    (lamp,) = lamps_of(edit_light(found, LightEdit(boxes=(small,))))
    assert lamp.hardness > 0.9
    assert lamp.toward[0] < -0.5


def test_an_edit_of_nothing_is_the_same_light():
    light = random_light()
    assert edit_light(light, LightEdit()) is light


def test_the_level_scales_and_leaves_the_shape_alone():
    light = random_light()
    brighter = edit_light(light, LightEdit(level_ev=2.0))
    assert brighter.shape is light.shape
    assert brighter.level == 4.0 * light.level


def test_a_metered_light_reads_one_and_a_half_and_its_own_level_is_on_top():
    light = random_light()
    metered = edit_light(light, LightEdit(metered=True))
    assert metered.shape is light.shape
    assert metered.level * meter_reading(metered) == pytest.approx(1.5)
    assert edit_light(light, LightEdit(metered=True, level_ev=1.0)).level == pytest.approx(2.0 * metered.level)
    assert edit_light(metered, LightEdit(metered=True)).level == pytest.approx(metered.level)


@pytest.mark.parametrize("factor", [2.0, 1e-3])
def test_the_units_of_a_metered_light_do_not_matter(factor):
    light = random_light()
    other = replace(light, level=light.level * factor)
    edit = LightEdit(metered=True, level_ev=-1.0, base=0.5, warmth=0.4, blur_deg=20.0, boxes=(SoftBox(),))
    np.testing.assert_allclose(
        radiance_of(edit_light(other, edit)), radiance_of(edit_light(light, edit)), rtol=1e-6, atol=1e-9
    )
    plain = replace(edit, metered=False)
    assert edit_light(other, plain).level == pytest.approx(factor * edit_light(light, plain).level)


def test_metering_no_light_leaves_none():
    dark = Environment.from_radiance(np.zeros((16, 32, 3)))
    assert edit_light(dark, LightEdit(metered=True)).level == 0.0


@pytest.mark.parametrize("place", [(0, 0), (-45, 35), (180, 0), (120, 88), (30, -90)])
@pytest.mark.parametrize("size", [(4, 4), (40, 15), (120, 90)])
def test_a_box_adds_exactly_its_irradiance(place, size):
    box = SoftBox(*place, *size, intensity=2.5, kelvin=3200.0)
    added = irradiance(soft_box_radiance(box, 64), box.direction)
    assert added @ REC709 == pytest.approx(np.pi * 2.5, rel=1e-4)
    assert added[0] > added[1] > added[2]


def test_an_intensity_of_one_doubles_the_brightest_side_of_a_lone_lamp():
    lamp = soft_box_radiance(SoftBox(50.0, 20.0, 24.0, 24.0, softness=0.0), 128)
    light = Environment.from_radiance(lamp * 7.0, "lamp")
    doubled = edit_light(light, LightEdit(boxes=(SoftBox(50.0, 20.0, 24.0, 24.0),)))
    normal = SoftBox(50.0, 20.0).direction
    before, after = (irradiance(radiance_of(each), normal) @ REC709 for each in (light, doubled))
    assert after / before == pytest.approx(2.0, rel=0.03)


def test_boxes_survive_without_a_base_and_over_a_black_one():
    boxes = (SoftBox(intensity=0.5),)
    alone = edit_light(random_light(), LightEdit(base=0.0, boxes=boxes))
    assert brightest_direction(alone.shape) @ boxes[0].direction > 0.95
    black = Environment.from_radiance(np.zeros((16, 32, 3)), "black")
    lit = edit_light(black, LightEdit(boxes=boxes))
    assert irradiance(radiance_of(lit), boxes[0].direction) @ REC709 == pytest.approx(np.pi * 0.5, rel=1e-3)


def test_turning_the_light_moves_its_boxes():
    light = edit_light(random_light(), LightEdit(base=0.0, boxes=(SoftBox(0.0, 0.0, 20.0, 20.0),)))
    quarter = network_light(light, 90.0)
    assert brightest_direction(quarter) @ [-1.0, 0.0, 0.0] > 0.9


@pytest.mark.parametrize("draft", [False, True])
def test_colour_and_blur_keep_the_mean_luminance(draft):
    light = random_light()
    edit = LightEdit(saturation=1.8, warmth=0.7, tint=-0.5, blur_deg=12.0)
    edited = edit_light(light, edit, draft)
    assert edited.level == pytest.approx(light.level, rel=1e-4)
    assert edited.shape.min() >= 0


def test_no_saturation_is_grey_and_warmth_is_warm():
    grey = edit_light(random_light(), LightEdit(saturation=0.0)).shape
    assert np.allclose(grey, grey[..., :1], rtol=1e-4)
    warm, cool, magenta = colour_gain(1.0, 0.0), colour_gain(-1.0, 0.0), colour_gain(0.0, 1.0)
    assert warm[0] > 1 > warm[2]
    assert cool[0] < 1 < cool[2]
    assert magenta[1] < 1 < magenta[0]
    assert all(gain @ REC709 == pytest.approx(1.0) for gain in (warm, cool, magenta))


@pytest.mark.parametrize("saturation", [0.0, 0.5, 2.0])
def test_saturation_leaves_every_texel_as_bright_as_it_was(saturation):
    light = random_light()
    edited = edit_light(light, LightEdit(saturation=saturation))
    np.testing.assert_allclose(radiance_of(edited) @ REC709, radiance_of(light) @ REC709, rtol=1e-4, atol=1e-6)


def test_a_tint_is_seven_tenths_of_a_stop_and_full_warmth_an_octave_of_temperature():
    magenta, warm = colour_gain(0.0, 1.0), colour_gain(1.0, 0.0)
    assert np.log2(magenta[[0, 2]] / magenta[1]) == pytest.approx([0.7, 0.7])
    np.testing.assert_allclose(colour_gain(0.0, -1.0) * magenta / (colour_gain(0.0, -1.0) * magenta)[0], 1.0, rtol=1e-6)
    np.testing.assert_allclose(warm, kelvin_to_rgb(2800.0, 5600.0), rtol=1e-6)


@pytest.mark.parametrize("blur_deg", [0.5, 5.0, 30.0, 90.0])
def test_blur_keeps_the_energy_and_an_even_light(blur_deg):
    radiance = random_light(24).shape
    assert np.allclose(energy(blur_light(radiance, blur_deg)), energy(radiance), rtol=1e-4)
    even = blur_light(np.ones((24, 48, 3), np.float32), blur_deg)
    assert np.abs(even - 1.0).max() < 2e-3


@pytest.mark.parametrize("height", [16, 128, 256])
def test_no_step_of_the_blur_is_a_leap(height):
    lamp = np.zeros((height, 2 * height, 3), np.float32)
    lamp[height // 3 : height // 3 + height // 8, height // 4 : height // 2] = 1.0
    before, steps = lamp, []
    for hundredths in range(2, 100, 2):
        after = shrink(blur_light(lamp, hundredths / 100), height)
        steps.append(float(np.abs(after - before).max()))
        before = after
    assert min(steps) > 0
    assert max(steps) < 0.06


def test_a_blur_of_less_than_a_texel_spreads_light_by_its_square():
    """As any blur does; half a texel of 64 rows is 1.4 degrees."""
    toward, areas = directions(64, 128).astype(np.float64), solid_angles(64, 128)
    lamp = np.zeros((64, 128, 1), np.float32)
    lamp[32, 40] = 1.0
    off_deg = np.degrees(np.arccos(np.clip(toward @ toward[32, 40], -1, 1)))
    spread = [float((off_deg**2 * areas * blur_light(lamp, blur)[..., 0]).sum()) for blur in (0.3, 0.6, 1.2, 2.4)]
    ratios = np.array(spread[1:]) / spread[:-1]
    np.testing.assert_allclose(ratios[:2], 4.0, rtol=0.02)
    assert 2.5 < ratios[2] < 6


@pytest.mark.parametrize("row", [6, 64])
def test_a_blurs_degrees_are_its_standard_deviation_in_each_direction(row):
    toward, areas = directions(128, 256).astype(np.float64), solid_angles(128, 256)
    lamp = np.zeros((128, 256, 1), np.float32)
    lamp[row, 40] = 1.0
    blurred = blur_light(lamp, 8.0)[..., 0]
    off_deg = np.degrees(np.arccos(np.clip(toward @ toward[row, 40], -1, 1)))
    deviation_deg = np.sqrt((off_deg**2 * areas * blurred).sum() / (areas * blurred).sum() / 2)
    assert deviation_deg == pytest.approx(8.0, rel=0.03)
    assert blurred.min() >= 0


def test_a_fine_light_is_blurred_on_128_rows():
    assert blur_light(np.ones((256, 512, 3), np.float32), 5.0).shape == (128, 256, 3)


@pytest.mark.parametrize("row", [1, 16, 30])
def test_blur_spreads_alike_in_all_directions_at_the_poles_too(row):
    lamp = np.zeros((32, 64, 1), np.float32)
    lamp[row, 63] = 1.0
    spread = blur_light(lamp, 15.0)[..., 0] * 1.0
    toward = directions(32, 64)
    angles = np.degrees(np.arccos(np.clip(toward @ toward[row, 63], -1, 1)))
    ring = spread[(angles > 14) & (angles < 17)]
    assert ring.std() / ring.mean() < 0.15
    assert spread[angles > 75].max() < 1e-3 * spread.max()


def test_blur_refuses_what_is_no_angle():
    for wrong in (-1.0, 91.0, np.nan):
        with pytest.raises(ValueError, match="blur"):
            blur_light(np.ones((4, 8, 3), np.float32), wrong)


def test_a_soft_box_that_is_switched_off_gives_nothing_and_comes_back_as_it_was():
    light, box = random_light(256), SoftBox(30.0, 20.0, intensity=2.0)
    off = edit_light(light, LightEdit(base=0.5, boxes=(replace(box, off=True),)))
    np.testing.assert_allclose(radiance_of(off), radiance_of(edit_light(light, LightEdit(base=0.5))), rtol=1e-5)
    on = edit_light(light, LightEdit(base=0.5, boxes=(box, replace(box, azimuth_deg=-90.0, off=True))))
    alone = edit_light(light, LightEdit(base=0.5, boxes=(box,)))
    np.testing.assert_allclose(radiance_of(on), radiance_of(alone), rtol=1e-5)
    dark = edit_light(light, LightEdit(base=0.0, boxes=(replace(box, off=True),)))
    assert dark.level == 0.0


@pytest.mark.parametrize("dark", [SoftBox(off=True), SoftBox(intensity=0.0)])
def test_a_soft_box_that_gives_no_light_changes_nothing(dark):
    coarse = random_light(16)
    edited = edit_light(coarse, LightEdit(boxes=(dark,)))
    assert edited.height == 16
    assert np.allclose(radiance_of(edited), radiance_of(coarse), rtol=1e-5)


@pytest.mark.parametrize("apart", [False, True])
def test_a_fine_light_is_shrunk_for_a_moving_hand_once(monkeypatch, apart):
    light, shrunk = random_light(128), []
    monkeypatch.setattr(light_edit, "shrink", lambda shape, height: shrunk.append(height) or shrink(shape, height))
    warmer = [edit_light(light, LightEdit(warmth=warmth, apart=apart), draft=True) for warmth in (0.2, 0.4)]
    assert shrunk == [64]
    assert warmer[0].fingerprint != warmer[1].fingerprint
    assert edit_light(light, LightEdit(warmth=0.2, apart=apart)).height == 128


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("level_ev", (-2000.0, 2000.0, np.nan)),
        ("base", (-1.0, 5.0)),
        ("saturation", (-3.0, 9.0)),
        ("warmth", (-5.0, 5.0)),
        ("tint", (-1.1, 9.0)),
        ("blur_deg", (-5.0, 91.0)),
    ],
)
def test_settings_out_of_their_ranges_are_refused_by_name(name, wrong):
    for value in wrong:
        with pytest.raises(InputError, match=name):
            edit_light(random_light(), LightEdit(**{name: value}))


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("azimuth_deg", (-181.0, np.inf)),
        ("elevation_deg", (-90.5, 91.0)),
        ("width_deg", (2.0, 151.0, np.nan)),
        ("height_deg", (0.0, 400.0)),
        ("softness", (-0.1, 1.1)),
        ("kelvin", (1000.0, 30000.0)),
        ("intensity", (-1.0, 17.0)),
        ("hole", (-0.1, 0.95)),
    ],
)
def test_a_soft_box_out_of_its_ranges_is_refused_by_name(name, wrong):
    for value in wrong:
        with pytest.raises(InputError, match=f"soft box's {name}"):
            edit_light(random_light(), LightEdit(boxes=(SoftBox(), SoftBox(**{name: value}))))
