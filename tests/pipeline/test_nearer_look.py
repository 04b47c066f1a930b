"""Two looks at one surface: where they agree nothing changes, where they don't the nearer one is believed of faces."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from tiny_relighter import some_photo

from relight_core.face.crop import Crop
from relight_core.face.find import FaceBox
from relight_core.pipeline.nearer_look import nearer_view, with_nearer_look
from relight_core.pipeline.portrait import Portrait
from relight_core.pipeline.stages import Surface

SIZE = 64
VIEW = Crop(100.0, 90.0, 160.0)
NEARER = Crop(110.0, 80.0, 80.0)
FACE = (slice(24, 32), slice(36, 44))
"""Rows and columns of the view that lie in the middle of the nearer one."""


def surface_seen_in(view, albedo=0.5, lift=0.0):
    """A slope of 0.3 in both directions of the photo, skin everywhere."""
    places = (np.arange(SIZE) + 0.5) / SIZE * view.side
    x, y = np.meshgrid(view.centre_x - view.side / 2 + places, view.centre_y - view.side / 2 + places)
    height_px = 0.3 * (x + y) + lift
    parsing = torch.zeros(1, 14, SIZE, SIZE)
    parsing[:, 1] = 1
    return Surface(
        photo=torch.full((1, 3, SIZE, SIZE), 0.4),
        albedo=torch.full((1, 3, SIZE, SIZE), albedo),
        normal=torch.tensor([0.6, 0.0, 0.8])[None, :, None, None].expand(1, 3, SIZE, SIZE).contiguous(),
        relief=torch.from_numpy(height_px / (view.side / 2)).float()[None, None],
        parsing=parsing,
        person=torch.ones(1, 1, SIZE, SIZE),
        source_light=torch.ones(1, 16, 32, 3),
    )


def test_looks_that_agree_change_nothing():
    """A nearer look's relief has no level of its own, and counts in half-widths of another view."""
    wide = surface_seen_in(VIEW)
    both = with_nearer_look(wide, surface_seen_in(NEARER, lift=17.0), VIEW, NEARER)
    for name in ("albedo", "normal", "relief", "parsing", "source_light"):
        torch.testing.assert_close(getattr(both, name), getattr(wide, name), atol=2e-3, rtol=0)


def test_a_face_is_as_the_nearer_look_has_it_and_the_rest_as_the_view():
    wide, near = surface_seen_in(VIEW), surface_seen_in(NEARER)
    near = replace(near, normal=torch.tensor([0.0, 0.6, 0.8])[None, :, None, None].expand(1, 3, SIZE, SIZE))
    normal = with_nearer_look(wide, near, VIEW, NEARER).normal
    rows, columns = FACE
    torch.testing.assert_close(normal[..., rows, columns], near.normal[..., :8, :8])
    torch.testing.assert_close(normal[..., 48:, :], wide.normal[..., 48:, :])
    torch.testing.assert_close(normal.norm(dim=1), torch.ones(1, SIZE, SIZE))


def test_the_whole_albedo_takes_the_level_of_the_nearer_look():
    albedo = with_nearer_look(surface_seen_in(VIEW, 0.5), surface_seen_in(NEARER, 0.4), VIEW, NEARER).albedo
    torch.testing.assert_close(albedo, torch.full_like(albedo, 0.4), atol=1e-4, rtol=0)


def test_a_view_without_a_person_stays_finite():
    wide = replace(surface_seen_in(VIEW), person=torch.zeros(1, 1, SIZE, SIZE))
    both = with_nearer_look(wide, surface_seen_in(NEARER), VIEW, NEARER)
    assert both.albedo.isfinite().all()
    assert both.relief.isfinite().all()


@pytest.mark.parametrize(("side", "looks"), [(100.0, False), (120.0, False), (150.0, True)])
def test_only_a_small_face_is_looked_at_again(side, looks):
    box, crop = FaceBox(60, 50, 140, 130), Crop(100.0, 90.0, 100.0)
    nearer = nearer_view(Portrait(some_photo(), box, box, crop, Crop(100.0, 90.0, side)))
    assert (nearer is not None) == looks
