"""What a light changes, enlarged from the networks' size: skin, and a hard shadow that it takes out of the photo."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from relight_core.face.parsing import CLASSES, INDEX
from relight_core.imaging.light_change import LightChange
from relight_core.imaging.resampling import resize_area
from relight_core.imaging.tensor_images import as_tensor
from relight_core.pipeline.per_light.sliders import SliderChange
from relight_core.pipeline.results.channels import enlarge_change, upsampler_for
from relight_core.pipeline.stages import Surface

DOWN, ACROSS = np.mgrid[:512, :512]
LIT = np.clip((ACROSS + 0.6 * DOWN - 400) / 5, 0, 1)
PHOTO = np.float32(0.05 + 0.55 * LIT)[..., None].repeat(3, -1)
SMALL, VIEW = resize_area(PHOTO, (16, 16)), resize_area(PHOTO, (128, 128))
NONE, ONE = np.zeros_like(SMALL), np.ones_like(SMALL)


def upsampler(label="skin"):
    colour, one = as_tensor(SMALL), torch.ones(1, 1, 16, 16)
    parsing = torch.zeros(1, len(CLASSES), 16, 16)
    parsing[:, INDEX[label]] = 1
    surface = Surface(colour, colour, 0 * colour, 0 * one, parsing, one, torch.ones(1, 16, 32, 3))
    return upsampler_for(VIEW, SMALL, surface)


def moved(kept):
    return SliderChange(as_tensor(kept), as_tensor(NONE), as_tensor(NONE))


def relit(change):
    return change.apply(PHOTO)[32:-32, 32:-32]


EVEN = LightChange(0.5 / SMALL, NONE, ONE, NONE)


def test_no_line_stays_of_a_shadow_on_skin_and_one_does_elsewhere():
    on_skin, on_cloth = (relit(enlarge_change(EVEN, None, upsampler(label), 1.0)) for label in ("skin", "cloth"))
    np.testing.assert_allclose(on_skin, 0.5, rtol=0.4)
    assert on_skin.std() < 0.015
    assert on_cloth.std() > 0.05


def test_edges_of_a_lamps_shadow_fall_on_it_too():
    half = np.full((128, 128, 3), 0.5, np.float32)
    whole, halved = (relit(enlarge_change(EVEN, None, upsampler(), 1.0, edges)) for edges in (None, half))
    np.testing.assert_allclose(halved, 0.5 * whole, rtol=1e-4)


@pytest.mark.parametrize("untouched_from", [0.4, 0.5, 0.54, 0.58])
def test_more_shadow_is_nowhere_brighter_though_the_gain_loses_its_step(untouched_from):
    """More shadow where the photo is darker than that, so much that it comes out as it was."""
    kept = np.minimum(SMALL / untouched_from, 1)
    less, more = (relit(enlarge_change(EVEN, change, upsampler(), 1.0)) for change in (None, moved(kept)))
    assert (more <= less + 1e-4).all()
    assert more.min() < 0.08


def test_a_slider_that_is_where_it_was_changes_nothing():
    upsample = upsampler()
    still, again = (enlarge_change(EVEN, change, upsample, 1.0) for change in (None, moved(ONE)))
    np.testing.assert_allclose(again.gain, still.gain, rtol=1e-4, atol=1e-5)
    np.testing.assert_allclose(again.offset, still.offset, atol=1e-5)


def test_gloss_lies_over_it():
    glossy = replace(EVEN, offset=NONE + 0.25)
    without, plus = (relit(enlarge_change(change, None, upsampler(), 1.0)) for change in (EVEN, glossy))
    np.testing.assert_allclose(plus - without, 0.25, atol=1e-5)
