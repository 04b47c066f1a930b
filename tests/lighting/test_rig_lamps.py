"""The lamps of a bundled light as soft boxes: the same light until somebody moves one."""

from dataclasses import replace

import numpy as np
import pytest

from relight_core.errors import InputError
from relight_core.lighting.environment import network_light
from relight_core.lighting.light_edit import LightEdit, edit_light
from relight_core.lighting.rig_lamps import apart, has_lamps, together
from relight_core.lighting.rigs import load_rig, rig_names
from relight_core.lighting.soft_box import SoftBox

ADDED = SoftBox(azimuth_deg=120.0, kelvin=3000.0)
OF_LAMPS = {"butterfly", "clamshell", "hard-side", "loop", "neon", "rembrandt", "rim", "ring", "soft-window", "split"}


def radiance(light):
    return network_light(light).astype(np.float64) * light.level


def names(edit):
    return [box.name for box in edit.boxes]


def test_rigs_have_lamps_and_skies_have_none():
    assert {name for name in rig_names() if has_lamps(name)} == OF_LAMPS
    with pytest.raises(InputError):
        has_lamps("candle")


@pytest.mark.parametrize("name", sorted(OF_LAMPS))
def test_a_light_that_was_taken_apart_is_the_same_light(name):
    light = load_rig(name)
    parts = edit_light(light, apart(name, LightEdit()))
    assert parts.level == pytest.approx(light.level, rel=1e-3)
    np.testing.assert_allclose(radiance(parts), radiance(light), atol=3e-3 * radiance(light).max())


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
    edit = apart("split", LightEdit())
    moved = replace(edit, boxes=(replace(edit.boxes[0], azimuth_deg=-90.0),))
    before, after = (radiance(edit_light(load_rig("split"), changed)).sum(2) for changed in (edit, moved))
    np.testing.assert_allclose(after, before[:, ::-1], atol=1e-2 * before.max())


def test_put_back_it_is_the_very_same_light():
    light = load_rig("clamshell")
    edit = apart("clamshell", LightEdit())
    changed = replace(edit, boxes=(replace(edit.boxes[0], kelvin=2500.0),))
    assert edit_light(light, together(changed)) is light
    assert together(replace(edit, boxes=(*edit.boxes, ADDED))) == LightEdit(boxes=(ADDED,))


def test_a_light_without_lamps_can_not_be_taken_apart():
    sky = load_rig("overcast")
    np.testing.assert_allclose(radiance(edit_light(sky, LightEdit(apart=True))), radiance(sky), rtol=1e-5)


def test_temperatures_stay_temperatures_where_white_is_daylight():
    assert [(box.kelvin, box.colour) for box in apart("rim", LightEdit()).boxes] == [
        (5800.0, None),
        (5800.0, None),
        (5200.0, None),
    ]
    assert apart("soft-window", LightEdit()).boxes[0].colour is not None
    ring = apart("ring", LightEdit()).boxes[0]
    assert (ring.form, ring.hole) == ("disc", pytest.approx(20 / 34))
