"""Edges of small lamps' shadows, finer than the networks' pixels."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from relight_core.imaging.joint_upsampling import JointUpsampler
from relight_core.imaging.light_change import LightChange
from relight_core.lighting.horizon import Horizon
from relight_core.lighting.lamps import Lamp
from relight_core.pipeline.per_light.fine_edges import FineEdges, LampEdge, ShadowEdges, draw_finely
from relight_core.pipeline.results.channels import enlarge_change

SIZE, TIMES = 64, 8
SIDE = (0.7660, 0.0, 0.6428)
LAMP = Lamp(SIDE, 1.0, 3.0, 1.0)
BAR, HEIGHT = slice(31, 35), 0.25
ENDS_AT = 31 - HEIGHT * SIDE[0] / SIDE[2] * SIZE / 2
"""Column, in pixels of the networks, at which the bar's shadow ends."""
STEEPEST = 2 / np.pi / np.radians(1.0) * SIDE[0] * SIDE[2] / (31 - ENDS_AT) / TIMES
"""Share of the lamp's disc by which two pixels of the picture differ where half of it is hidden."""


def edges(share=0.9, counts=1.0, lamp=LAMP):
    """Of the shadow of an upright bar before a wall; all light but a tenth is the lamp's."""
    relief = np.zeros((SIZE, SIZE), np.float32)
    relief[:, BAR] = HEIGHT
    horizon = Horizon(relief, np.ones((SIZE, SIZE), bool))
    lost = 1 - horizon.visibility(lamp.toward, lamp.radius_deg)
    one = np.ones((SIZE, SIZE), np.float32)
    of_lamp = LampEdge(lamp, np.float32(share * counts) * one, lost)
    return ShadowEdges(horizon, [of_lamp], np.float32(share) * lost, 0.5 * one)


def larger(maps):
    enlarged = cv2.resize(maps, (SIZE * TIMES,) * 2, interpolation=cv2.INTER_LINEAR)
    return enlarged.reshape(SIZE * TIMES, SIZE * TIMES, -1)


def row(image):
    """From the wall in the light to the foot of the bar."""
    return image[SIZE * TIMES // 2, : BAR.start * TIMES]


def blurred(share):
    return cv2.GaussianBlur(share, (0, 0), 3.0)


def test_a_shadow_ends_as_abruptly_as_the_lamp_is_small_and_where_geometry_says():
    fine = draw_finely(edges(), larger)
    coarse_row, fine_row = row(fine.coarse), row(fine.fine)
    assert np.diff(fine_row).max() > 1.5 * np.diff(coarse_row).max()
    assert np.diff(fine_row).max() == pytest.approx(0.9 * STEEPEST, rel=0.15)
    halfway = np.flatnonzero(fine_row > 0.45)[0] / TIMES
    assert halfway == pytest.approx(ENDS_AT, abs=1.0)
    assert (np.diff(fine_row) > -0.02).all()


def test_a_larger_lamp_has_wider_edges():
    narrow, wide = (row(draw_finely(edges(lamp=replace(LAMP, radius_deg=deg)), larger).fine) for deg in (1.0, 6.0))
    width = [((of_lamp > 0.1) & (of_lamp < 0.8)).sum() for of_lamp in (narrow, wide)]
    assert width[1] > 2 * width[0] > 0


def test_far_from_edges_nothing_changes():
    fine = draw_finely(edges(), larger)
    away = np.ones(BAR.start * TIMES, bool)
    for column in (ENDS_AT, BAR.start):
        away[round((column - 4) * TIMES) : round((column + 4) * TIMES)] = False
    np.testing.assert_array_equal(row(fine.fine)[away], row(fine.coarse)[away])
    np.testing.assert_allclose(row(fine.gain(1.0, 0.0))[away], 1, atol=1e-6)


def test_where_geometry_has_no_say_edges_stay():
    for how in ((), (blurred,)):
        fine = draw_finely(edges(counts=0.0), larger, *how)
        np.testing.assert_array_equal(fine.fine, fine.coarse)


def test_of_two_lamps_each_moves_its_own_edge_where_both_shadows_end_too():
    """Lamps a little apart on one side: their shadows of the bar end within each other's."""
    other = replace(LAMP, toward=(0.7880, 0.0, 0.6157), radius_deg=2.0)
    one, two = edges(counts=0.2), edges(counts=0.2, lamp=other)
    hidden = (one.hidden + two.hidden) / 2
    each = [replace(one, hidden=hidden, of_lamps=lamps) for lamps in (one.of_lamps, two.of_lamps)]
    both = replace(one, hidden=hidden, of_lamps=[*one.of_lamps, *two.of_lamps])
    moved = [of_lamps.fine - of_lamps.coarse for of_lamps in (draw_finely(shadow, larger) for shadow in (*each, both))]
    assert min(np.abs(change).max() for change in moved) > 0.03
    assert (moved[0] * moved[1] != 0).any()
    np.testing.assert_allclose(moved[2], moved[0] + moved[1], atol=1e-5)


def test_edges_move_as_far_as_geometry_has_a_say():
    quarter, half = (draw_finely(edges(counts=counts), larger) for counts in (0.25, 0.5))
    assert np.abs(half.fine - half.coarse).max() > 0.05
    np.testing.assert_allclose(half.fine - half.coarse, 2 * (quarter.fine - quarter.coarse), atol=1e-5)


def test_no_place_is_darker_or_brighter_than_all_around():
    shallow = edges()
    shallow = replace(shallow, hidden=0.3 * shallow.hidden)
    fine = draw_finely(shallow, larger).fine
    around = [larger(change(shallow.hidden, np.ones((5, 5), np.uint8)))[..., 0] for change in (cv2.erode, cv2.dilate)]
    assert (fine >= around[0] - 1e-6).all()
    assert (fine <= around[1] + 1e-6).all()


def test_where_the_picture_was_evened_the_edge_is_drawn_anew():
    """Over an eye the light is a mean; a nose's shadow that crosses it is none the less one."""
    fine = draw_finely(edges(), larger, blurred)
    step = lambda image: np.diff(row(image)).max()  # noqa: E731
    assert step(fine.fine) > 4 * step(fine.coarse)


def test_an_edge_that_is_drawn_anew_is_the_one_that_was_evened_away():
    evened, plain = (row(draw_finely(edges(), larger, *how).fine) for how in ((blurred,), ()))
    np.testing.assert_allclose(evened, plain, atol=0.02)


class TestGain:
    FINE = draw_finely(edges(), larger)

    def test_it_is_brighter_where_less_is_hidden_and_darker_where_more_is(self):
        gain, more = self.FINE.gain(1.0, 0.0)[..., 0], self.FINE.fine - self.FINE.coarse
        assert gain[more < -0.1].min() > 1.1
        assert gain[more > 0.1].max() < 0.95

    def test_no_shadow_and_a_soft_one_have_no_fine_edge(self):
        for shadow, softness in ((0.0, 0.0), (1.0, 0.1), (2.0, 1.0)):
            np.testing.assert_allclose(self.FINE.gain(shadow, softness), 1, atol=1e-6)

    def test_it_fades_evenly_with_both_sliders(self):
        by_shadow = [np.abs(self.FINE.gain(shadow, 0.0) - 1).max() for shadow in (0.0, 0.25, 0.5, 1.0)]
        by_softness = [np.abs(self.FINE.gain(1.0, softness) - 1).max() for softness in (0.1, 0.06, 0.03, 0.0)]
        assert sorted(by_shadow) == by_shadow
        assert sorted(by_softness) == by_softness
        assert by_softness[1] > 0.1

    def test_light_that_is_thrown_back_stays_where_all_becomes_hidden(self):
        """Three hundredths of it, so that an edge is drawn into no picture as black, and none is brightened by more."""
        one = np.ones((4, 4), np.float32)
        np.testing.assert_allclose(FineEdges(0 * one, one, one).gain(1.0, 0.0), 0.03 / 1.03, rtol=1e-5)
        np.testing.assert_allclose(FineEdges(0.9 * one, 0.8 * one, one).gain(1.0, 0.0), 0.23 / 0.13, rtol=1e-5)

    @pytest.mark.parametrize(("before", "after"), [(0.0, 1.0), (1.0, 0.0), (0.5, 0.5), (1.0, 1.0)])
    @pytest.mark.parametrize("shadow", [0.0, 0.5, 1.0, 2.0])
    def test_it_stays_within_bounds(self, before, after, shadow):
        one = np.ones((4, 4), np.float32)
        gain = FineEdges(before * one, after * one, one).gain(shadow, 0.0)
        assert gain.shape == (4, 4, 3)
        assert np.isfinite(gain).all()
        assert gain.min() > 0
        assert gain.max() <= 4


def test_where_the_diffuse_light_is_brighter_more_of_it_is_hidden():
    falling = np.linspace(1, 0.1, SIZE, dtype=np.float32)[:, None].repeat(SIZE, 1)
    fine = draw_finely(replace(edges(), diffuse=falling), larger)
    np.testing.assert_allclose(fine.more_shadow(), larger(falling)[..., 0] * (fine.fine - fine.coarse), atol=1e-5)


def test_the_shadow_channel_changes_by_the_light_that_is_hidden():
    fine = draw_finely(edges(), larger)
    np.testing.assert_allclose(fine.more_shadow(), 0.5 * (fine.fine - fine.coarse), atol=1e-6)
    assert np.abs(fine.more_shadow()).max() > 0.05


def test_finer_edges_are_those_of_gloss_too():
    one = np.ones((4, 4, 3), np.float32)
    change = enlarge_change(LightChange(one, 0.3 * one, one, one), None, JointUpsampler(one, one), 2.0, 0.5 * one)
    np.testing.assert_allclose(change.gain, 1.0)
    np.testing.assert_allclose(change.offset, 0.3)
