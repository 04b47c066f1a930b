"""Channels as they are shown: what is surface, and what is nothing."""

import numpy as np
import pytest
import torch

from relight_core.pipeline.results.channel_view import channel_to_srgb
from relight_core.pipeline.results.channels import of_person
from relight_core.pipeline.stages import Surface


def surface_of(person: np.ndarray) -> Surface:
    size = len(person)
    nothing = torch.zeros(1, 3, size, size)
    parsing, light = torch.zeros(1, 14, size, size), torch.ones(1, 16, 32, 3)
    share = torch.from_numpy(person.astype(np.float32))[None, None]
    return Surface(nothing, nothing, nothing, nothing[:, :1], parsing, share, light)


@pytest.mark.parametrize(
    ("normal", "shown"),
    [
        ((0.0, 0.0, 1.0), (0.5, 0.5, 1.0)),
        ((-1.0, 0.0, 0.0), (0.0, 0.5, 0.5)),
        ((0.6, 0.8, 0.0), (0.8, 0.9, 0.5)),
        ((0.0, 0.0, 0.5), (0.25, 0.25, 0.5)),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ((np.nan, np.inf, 0.0), None),
    ],
)
def test_normals_are_shown_in_colours_and_no_surface_as_black(normal, shown):
    picture = channel_to_srgb("normal", np.full((2, 3, 3), normal, np.float32))
    assert picture.shape == (2, 3, 3)
    assert np.isfinite(picture).all()
    assert picture.min() >= 0
    assert picture.max() <= 1
    if shown is not None:
        np.testing.assert_allclose(picture[1, 2], shown, atol=1e-6)


def test_channels_keep_the_person_and_nothing_behind():
    person = np.zeros((8, 8))
    person[:, 4:] = 1
    kept = of_person(np.full((32, 32, 3), (0.2, 0.4, 0.6), np.float32), surface_of(person))
    np.testing.assert_allclose(kept[:, 20:], np.broadcast_to(np.float32([0.2, 0.4, 0.6]), (32, 12, 3)), rtol=1e-6)
    assert not kept[:, :12].any()
    fading = kept[16, 12:20, 0]
    assert (np.diff(fading) >= 0).all()
    assert 0 < fading[3] < 0.2


def test_a_light_of_any_brightness_is_shown_short_of_white():
    light = np.float32([[[1.0, 0.0, 0.0], [3.0, 3.0, 3.0], [1e6, 1e6, 1e6]]])
    shown = channel_to_srgb("target_light", light)
    np.testing.assert_allclose(shown[0, :2], [[0.7354, 0.0, 0.0], [0.8808] * 3], atol=1e-3)
    assert shown.max() <= 1
