"""The lamps of a bundled light as soft boxes: the same light until somebody moves one."""

from dataclasses import replace

import numpy as np
import pytest

from relight_core.lighting.environment import Environment, network_light
from relight_core.lighting.lamps import bright_places
from relight_core.lighting.light_edit import LightEdit, edit_light, put_together, taken_apart
from relight_core.lighting.own_lamps import own_lamps, room_of
from relight_core.lighting.rig_description import parse_rig
from relight_core.lighting.rig_render import Drawn, render_rig
from relight_core.lighting.rigs import load_rig, rig_names
from relight_core.lighting.soft_box import SoftBox
from relight_core.lighting.sphere import directions, solid_angles
from relight_core.lighting.summary import meter_reading

NOTHING = LightEdit()
ADDED = SoftBox(azimuth_deg=120.0, kelvin=3000.0)
OF_LAMPS = {"butterfly", "clamshell", "hard-side", "loop", "neon", "rembrandt", "rim", "ring", "soft-window", "split"}


def radiance(light):
    return network_light(light).astype(np.float64) * light.level


def apart(name, edit=NOTHING):
    return taken_apart(edit, own_lamps(load_rig(name)))


def names(edit):
    return [box.name for box in edit.boxes]


def test_rigs_have_lamps_and_skies_have_none():
    assert {name for name in rig_names() if own_lamps(load_rig(name))} == OF_LAMPS


@pytest.mark.parametrize("name", sorted(OF_LAMPS))
def test_a_light_that_was_taken_apart_is_the_same_light(name):
    light = load_rig(name)
    parts = edit_light(light, apart(name))
    assert parts.level == pytest.approx(light.level, rel=1e-3)
    np.testing.assert_allclose(radiance(parts), radiance(light), atol=3e-3 * radiance(light).max())


@pytest.mark.parametrize(("width_deg", "as_box_deg"), [(1.0, 3.0), (160.0, 150.0)])
def test_a_lamp_of_a_rig_becomes_the_nearest_that_a_soft_box_may_be(width_deg, as_box_deg):
    room = {"kelvin": 5600, "intensity": 0.1}
    lamp = {"azimuth_deg": 220.0, "elevation_deg": 50.0, "width_deg": width_deg, "height_deg": 20.0}
    rig = parse_rig({"room": room, "area_light": [lamp | {"kelvin": 5600, "intensity": 1.0}]})
    light = Environment.from_radiance(render_rig(rig, 256), "rig")
    light = replace(light, drawn=Drawn(rig, light.level))
    (box,) = own_lamps(light)
    assert (box.azimuth_deg, box.width_deg, box.height_deg) == (-140.0, as_box_deg, 20.0)
    # One without a name would be taken for a box that was added.
    assert box.name == "lamp"
    parts = edit_light(light, taken_apart(NOTHING, (box,)))
    np.testing.assert_allclose(card(parts, box), card(light, box), rtol=0.03)


@pytest.mark.parametrize("base", [0.5, 0.0])
def test_what_is_left_of_a_light_is_left_of_its_lamps(base):
    light, edit = load_rig("neon"), LightEdit(base=base)
    before, after = (radiance(edit_light(light, changed)) for changed in (edit, apart("neon", edit)))
    np.testing.assert_allclose(after, before, atol=2e-3 * radiance(light).max())


def test_lamps_come_before_what_was_added_and_backdrops_stay():
    edit = apart("rembrandt", LightEdit(boxes=(ADDED,), level_ev=1.0))
    assert names(edit) == ["key", "fill", ""]
    assert (edit.level_ev, edit.boxes[2]) == (1.0, ADDED)
    room = radiance(edit_light(load_rig("rembrandt"), replace(edit, boxes=())))
    behind, aside = room[8, 16].sum(), room[8, 4].sum()
    assert behind > 1.2 * aside > 0


def test_a_lamp_that_is_moved_takes_its_light_along():
    edit = apart("split")
    moved = replace(edit, boxes=(replace(edit.boxes[0], azimuth_deg=-90.0),))
    before, after = (radiance(edit_light(load_rig("split"), changed)).sum(2) for changed in (edit, moved))
    np.testing.assert_allclose(after, before[:, ::-1], atol=1e-2 * before.max())


def test_put_back_it_is_the_very_same_light():
    light = load_rig("clamshell")
    edit = apart("clamshell")
    changed = replace(edit, boxes=(replace(edit.boxes[0], kelvin=2500.0),))
    assert edit_light(light, put_together(changed)) is light
    assert put_together(replace(edit, boxes=(*edit.boxes, ADDED))) == LightEdit(boxes=(ADDED,))


def test_put_back_all_of_a_light_is_there_whose_room_was_dark():
    edit = apart("rembrandt")
    assert put_together(replace(edit, base=0.0)).base == 1.0


def test_a_light_without_lamps_can_not_be_taken_apart():
    sky = load_rig("overcast")
    np.testing.assert_allclose(radiance(edit_light(sky, LightEdit(apart=True))), radiance(sky), rtol=1e-5)


def test_temperatures_stay_temperatures_where_white_is_daylight():
    assert [(box.kelvin, box.colour) for box in apart("rim").boxes] == [
        (5800.0, None),
        (5800.0, None),
        (5200.0, None),
    ]
    assert apart("soft-window").boxes[0].colour is not None
    ring = apart("ring").boxes[0]
    assert (ring.form, ring.hole) == ("disc", pytest.approx(20 / 34))


# Suns and bulbs of panoramas


def sky_with(*suns, height=256):
    """A blue sky over a dull ground, with discs of (azimuth, elevation, radius in degrees, radiance)."""
    toward = directions(height, 2 * height)
    radiance = np.where(toward[..., 1:2] > 0, [0.3, 0.5, 1.0], [0.2, 0.15, 0.1])
    for azimuth_deg, elevation_deg, radius_deg, brightness in suns:
        cosine = toward @ SoftBox(azimuth_deg, elevation_deg).direction.astype(np.float32)
        radiance = radiance + (cosine > np.cos(np.radians(radius_deg)))[..., None] * brightness * WARM
    return Environment.from_radiance(radiance, "sky")


WARM = np.array([1.0, 0.8, 0.5])


def card(light, box):
    """What a white card that faces the box reflects."""
    height, width = light.shape.shape[:2]
    facing = np.maximum(directions(height, width) @ box.direction.astype(np.float32), 0.0) * solid_angles(height, width)
    return np.einsum("hw,hwc->c", facing.astype(np.float64), light.shape) * light.level / np.pi


@pytest.mark.parametrize("radius_deg", [2.0, 4.0])
def test_the_sun_of_a_panorama_becomes_a_disc_of_its_size_place_and_colour(radius_deg):
    sky = sky_with((40.0, 35.0, radius_deg, 3000.0))
    (sun,) = own_lamps(sky)
    assert (sun.name, sun.form) == ("lamp", "disc")
    assert (sun.azimuth_deg, sun.elevation_deg) == pytest.approx((40.0, 35.0), abs=0.3)
    assert sun.width_deg == pytest.approx(2 * radius_deg, abs=0.8)
    np.testing.assert_allclose(sun.rgb / sun.rgb[0], WARM, rtol=0.01)


def test_a_panorama_that_was_taken_apart_gives_the_same_light_and_its_room_has_no_sun():
    sky, bare = sky_with((40.0, 35.0, 2.0, 3000.0)), sky_with()
    edit = taken_apart(LightEdit(), own_lamps(sky))
    parts = edit_light(sky, edit)
    assert parts.level == pytest.approx(sky.level, rel=2e-3)
    for facing in (edit.boxes[0], SoftBox(-30.0, 10.0), SoftBox(90.0, 80.0)):
        np.testing.assert_allclose(card(parts, facing), card(sky, facing), rtol=5e-3)
    room = edit_light(sky, replace(edit, boxes=()))
    np.testing.assert_allclose(room.shape * room.level, bare.shape * bare.level, rtol=1e-4)


def test_what_is_dark_beside_a_sun_stays_dark_without_it():
    sky = sky_with((40.0, 35.0, 2.0, 3000.0))
    toward = directions(256, 512) @ SoftBox(48.0, 35.0).direction.astype(np.float32)
    tower = toward > np.cos(np.radians(2.0))
    shape = np.where(tower[..., None], 0.0, sky.shape)
    light = Environment.from_radiance(shape)
    room = edit_light(light, replace(taken_apart(LightEdit(), own_lamps(light)), boxes=()))
    assert room.shape[tower].max() == 0


def sun_in(sky):
    """A white sun at (40, 35) in a sky of (256, 512) radiance; what its room shows, of one channel, and how far off."""
    toward = directions(256, 512) @ SoftBox(40.0, 35.0).direction.astype(np.float32)
    off_deg = np.degrees(np.arccos(np.minimum(toward, 1)))
    light = Environment.from_radiance(sky(off_deg) + np.where(off_deg < 2.0, 3000.0, 0.0))
    return room_of(light)[..., 0] * light.level, off_deg


def test_a_sky_that_is_brighter_on_one_side_stays_so_without_its_sun():
    across = 1 + 0.8 * directions(256, 512)[..., 0]
    room, _ = sun_in(lambda off_deg: across)
    np.testing.assert_allclose(room, across, rtol=0.015)


def test_the_glow_about_a_sun_shows_no_edge_where_the_sun_was():
    room, off_deg = sun_in(lambda off_deg: 0.2 + 10 * np.exp2(-off_deg / 4))
    rings = [room[(off_deg > least) & (off_deg <= least + 1)].mean() for least in range(8, 16)]
    assert np.abs(np.diff(rings)).max() < 0.25


@pytest.mark.parametrize("apart_deg", [10.0, 12.0, 14.0])
def test_lamps_that_are_close_together_each_keep_their_light_and_leave_none_behind(apart_deg):
    places = [(40.0, 35.0, 2.0, 3000.0), (40.0, 35.0 + apart_deg, 1.5, 3000.0)]
    sky, bare = sky_with(*places), sky_with()
    alone = [own_lamps(sky_with(place))[0] for place in places]
    lamps = own_lamps(sky)
    given, expected = (
        [box.intensity * meter_reading(light) * light.level for box, light in pairs]
        for pairs in (((box, sky) for box in lamps), zip(alone, map(sky_with, places), strict=True))
    )
    assert given == pytest.approx(expected, rel=0.02)
    room = edit_light(sky, replace(taken_apart(LightEdit(), lamps), boxes=()))
    np.testing.assert_allclose(room.shape * room.level, bare.shape * bare.level, rtol=1e-3)


def test_lamps_of_a_panorama_are_taken_out_one_after_the_other():
    sky = sky_with((40.0, 35.0, 2.0, 3000.0), (-120.0, 20.0, 3.0, 1000.0))
    edit = taken_apart(LightEdit(), own_lamps(sky))
    assert names(edit) == ["lamp 1", "lamp 2"]
    np.testing.assert_allclose([box.azimuth_deg for box in edit.boxes], [40.0, -120.0], atol=0.5)
    without = edit_light(sky, replace(edit, boxes=edit.boxes[1:]))
    other = sky_with((-120.0, 20.0, 3.0, 1000.0))
    np.testing.assert_allclose(card(without, SoftBox(-120.0, 20.0)), card(other, SoftBox(-120.0, 20.0)), rtol=5e-3)


def test_a_sun_over_the_horizon_leaves_the_sky_behind_it_and_not_half_of_the_ground():
    light = sky_with((40.0, 5.0, 2.0, 3000.0))
    toward = directions(256, 512) @ SoftBox(40.0, 5.0).direction.astype(np.float32)
    room = room_of(light)[toward > np.cos(np.radians(1.5))] * light.level
    np.testing.assert_allclose(room, np.broadcast_to([0.3, 0.5, 1.0], room.shape), rtol=0.2)


def test_of_many_lamps_the_four_that_give_most_can_be_moved():
    azimuths_deg = (-150.0, -90.0, -30.0, 30.0, 90.0, 150.0)
    light = sky_with(*((azimuth_deg, 30.0, 2.0, 1000.0 + 3 * azimuth_deg) for azimuth_deg in azimuths_deg))
    assert len(bright_places(light)) == 6
    lamps = own_lamps(light)
    assert [lamp.name for lamp in lamps] == ["lamp 1", "lamp 2", "lamp 3", "lamp 4"]
    assert [lamp.azimuth_deg for lamp in lamps] == pytest.approx([150.0, 90.0, 30.0, -30.0], abs=0.5)


def test_what_gives_next_to_nothing_beside_a_sun_is_no_lamp():
    sky = sky_with((40.0, 35.0, 2.0, 3000.0), (40.0, 46.0, 2.0, 100.0))
    assert len(bright_places(sky)) == 2
    assert [lamp.name for lamp in own_lamps(sky)] == ["lamp"]


def test_a_panorama_without_a_sun_has_no_lamps():
    sky = sky_with()
    assert own_lamps(sky) == ()
    np.testing.assert_allclose(edit_light(sky, LightEdit(apart=True)).shape, sky.shape, rtol=1e-5)
    assert own_lamps(Environment.from_radiance(np.zeros((16, 32, 3)))) == ()


@pytest.mark.parametrize("height", [64, 512])
def test_the_size_of_a_panorama_does_not_matter_much(height):
    (sun,), (other,) = (own_lamps(sky_with((0.0, 50.0, 4.0, 800.0), height=rows)) for rows in (height, 256))
    assert other.intensity == pytest.approx(sun.intensity, rel=0.1)
    assert other.elevation_deg == pytest.approx(sun.elevation_deg, abs=1.5)
