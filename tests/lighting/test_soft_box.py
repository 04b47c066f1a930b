"""Soft boxes under the mouse: across the seam, at the poles, by their corners, and placed on a face."""

import numpy as np
import pytest

from relight_core.lighting.soft_box import (
    SoftBox,
    box_title,
    contains,
    corners,
    lamp_direction,
    moved_to,
    outline,
    resized_to,
    soft_box_radiance,
)
from relight_core.lighting.sphere import direction_at, directions, solid_angles

PLACES = [(0, 0), (179, 10), (-180, -30), (45, 89), (10, -90), (90, 45)]


@pytest.mark.parametrize("place", PLACES)
def test_a_box_contains_its_middle_and_what_lies_inside_its_edge_only(place):
    box = SoftBox(*place, width_deg=30.0, height_deg=20.0)
    assert contains(box, box.direction)
    assert not contains(box, -box.direction)
    middle = box.direction
    for edge in outline(box):
        assert contains(box, 0.9 * edge + 0.1 * middle)
        assert not contains(box, 1.15 * edge - 0.15 * middle)


@pytest.mark.parametrize("place", PLACES)
def test_a_disc_is_as_wide_in_all_directions(place):
    disc = SoftBox(*place, width_deg=40.0, height_deg=7.0, form="disc")
    for edge in (*outline(disc), *corners(disc)):
        assert np.degrees(np.arccos(edge @ disc.direction)) == pytest.approx(20.0, abs=1e-4)
        assert contains(disc, 0.95 * edge + 0.05 * disc.direction)
        assert not contains(disc, 1.1 * edge - 0.1 * disc.direction)
    assert not contains(disc, -disc.direction)


@pytest.mark.parametrize("place", PLACES)
def test_dragging_the_edge_of_a_disc_makes_it_reach_there(place):
    wider = SoftBox(*place, width_deg=52.0, height_deg=52.0, form="disc")
    for edge in (*outline(wider), *corners(wider)):
        resized = resized_to(SoftBox(*place, form="disc"), edge)
        assert (resized.width_deg, resized.height_deg) == pytest.approx((52.0, 52.0), abs=1e-3)
    assert resized_to(wider, wider.direction).width_deg == 3.0
    assert resized_to(wider, -wider.direction).width_deg == 150.0


@pytest.mark.parametrize("hole", [0.0, 0.6, 0.9])
@pytest.mark.parametrize("place", [(0, 0), (179, 10), (45, 89)])
def test_a_disc_or_ring_gives_a_card_that_faces_it_what_a_square_does(place, hole):
    disc = SoftBox(*place, 40.0, 40.0, softness=0.1, intensity=2.0, form="disc", hole=hole)
    radiance = soft_box_radiance(disc, 128)[..., 1].astype(np.float64)
    toward, areas = directions(128, 256), solid_angles(128, 256)
    ahead = toward @ disc.direction.astype(np.float32)
    green = disc.rgb[1]
    assert np.sum(radiance * np.maximum(ahead, 0) * areas) == pytest.approx(np.pi * 2.0 * green, rel=1e-3)
    from_centre = np.degrees(np.arccos(np.clip(ahead, -1, 1)))
    assert radiance[from_centre > 24].max() == 0
    assert radiance[(from_centre > 18.5) & (from_centre < 19)].min() > 0
    middle = radiance[from_centre < max(20 * hole - 3, 2)]
    assert middle.min() > 0 if hole == 0 else middle.max() == 0


def test_the_seam_cuts_no_box_in_two():
    box = SoftBox(0.0, 0.0, 40.0, 40.0)
    for u in (0.96, 0.999, 0.0, 0.001, 0.04, 1.04):
        assert contains(box, direction_at(u, 0.5))
    assert not contains(box, direction_at(0.5, 0.5))


def test_a_box_over_the_pole_is_hit_at_every_azimuth():
    box = SoftBox(77.0, 90.0, 30.0, 30.0)
    assert all(contains(box, direction_at(u, 0.03)) for u in np.linspace(0, 1, 17))
    assert not any(contains(box, direction_at(u, 0.2)) for u in np.linspace(0, 1, 17))


@pytest.mark.parametrize("place", PLACES)
def test_dragging_a_corner_makes_the_box_reach_it(place):
    box = SoftBox(*place, width_deg=30.0, height_deg=20.0)
    wider = SoftBox(*place, width_deg=50.0, height_deg=12.0)
    for corner in corners(wider):
        resized = resized_to(box, corner)
        assert resized.width_deg == pytest.approx(50.0, abs=1e-3)
        assert resized.height_deg == pytest.approx(12.0, abs=1e-3)
    tiny = resized_to(box, box.direction)
    assert (tiny.width_deg, tiny.height_deg) == (3.0, 3.0)


@pytest.mark.parametrize("place", [*PLACES, (30, 90)])
def test_a_moved_box_lies_where_it_was_put(place):
    target = SoftBox(*place).direction
    assert moved_to(SoftBox(12.0, 5.0), 3.0 * target).direction @ target == pytest.approx(1.0, abs=1e-6)


def test_a_box_that_is_moved_straight_up_keeps_its_azimuth():
    moved = moved_to(SoftBox(12.0, 5.0), np.array([0.0, 2.0, 0.0]))
    assert (moved.azimuth_deg, moved.elevation_deg) == (12.0, pytest.approx(90.0))


def test_a_box_that_is_switched_off_radiates_nothing():
    assert soft_box_radiance(SoftBox(), 16).max() > 0
    assert soft_box_radiance(SoftBox(off=True), 16).max() == 0


def test_a_lamp_for_the_bright_side_stands_on_the_normal_and_one_for_a_highlight_where_it_mirrors():
    tilted = np.array([np.sin(0.4), 0.0, np.cos(0.4)])
    assert np.allclose(lamp_direction(2 * tilted, "bright"), tilted)
    assert np.allclose(lamp_direction(tilted, "highlight"), [np.sin(0.8), 0.0, np.cos(0.8)])
    assert np.allclose(lamp_direction([0, 0, 1], "highlight"), [0, 0, 1])
    with pytest.raises(ValueError, match="lamp"):
        lamp_direction([0, 0, 0], "bright")


def test_the_users_boxes_are_numbered_and_a_lights_own_lamps_have_names():
    boxes = (SoftBox(name="key"), SoftBox(), SoftBox(name="pink tube"), SoftBox())
    assert [box_title(boxes, index) for index in range(4)] == ["Key", "Soft box 1", "Pink tube", "Soft box 2"]


def test_a_form_that_is_none_is_refused():
    with pytest.raises(ValueError, match="rectangle"):
        SoftBox(form="ring")
