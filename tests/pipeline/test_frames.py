"""Glasses in the shadow that a relief casts: light passes around their frames."""

import numpy as np
import pytest
import torch

from relight_core.lighting.sphere import directions
from relight_core.pipeline.per_photo.frames import without_frames
from relight_core.pipeline.stages import Surface, at_surface_size, march

SIZE, SKIN, GLASSES = 128, 1, 12
HEIGHT = 0.1
TOWARD_LAMP = np.array([0.94, 0.0, 0.34])
LENS = slice(45, 83)


def hidden_beside(raised, label):
    """(S, S) share of a lamp's light from the right that a flat face loses.

    Args:
        raised: (S, S) bool, what stands out of the face.
        label: of it.
    """
    one = torch.ones(1, 1, SIZE, SIZE)
    relief = torch.from_numpy(HEIGHT * raised.astype(np.float32))[None, None]
    parsing = torch.zeros(1, 14, SIZE, SIZE)
    parsing[0, SKIN], parsing[0, label, raised] = torch.from_numpy(~raised).float(), 1
    normal = torch.cat([0 * one, 0 * one, one], 1)
    colour = one.repeat(1, 3, 1, 1)
    surface = Surface(colour, colour, normal, relief, parsing, one, torch.ones(1, 16, 32, 3))
    lamp = directions(16, 32) @ TOWARD_LAMP > 0.99
    light = 100 * torch.from_numpy(lamp[None, ..., None].repeat(3, -1).astype(np.float32))
    return at_surface_size(march(surface, SIZE // 2).shadow_fraction(light), surface)[0, 0].numpy()


def rim():
    """A frame of three pixels around a glass."""
    raised = dark_glass()
    raised[48:80, 48:80] = False
    return raised


def dark_glass():
    raised = np.zeros((SIZE, SIZE), bool)
    raised[LENS, LENS] = True
    return raised


def test_skin_behind_a_glass_is_not_in_the_shadow_of_its_frame():
    assert hidden_beside(rim(), SKIN)[64, 74:79].mean() > 0.5
    assert hidden_beside(rim(), GLASSES)[64, 48:80].max() < 0.02


def test_dark_glass_casts_the_shadow_that_as_much_skin_does():
    beside = slice(38, 43)
    by_skin = hidden_beside(dark_glass(), SKIN)[64, beside].mean()
    assert by_skin > 0.5
    assert hidden_beside(dark_glass(), GLASSES)[64, beside].mean() == pytest.approx(by_skin, rel=0.02)


def levelled(raised, glasses):
    """(S, S) heights of a flat face without frames; (S, S) bool each, what stands out of it, and what is glasses."""
    relief = torch.from_numpy(HEIGHT * raised.astype(np.float32))[None, None]
    parsing = torch.zeros(1, 14, SIZE, SIZE)
    parsing[0, GLASSES] = torch.from_numpy(glasses).float()
    return without_frames(relief, parsing)[0, 0].numpy()


def test_a_frame_goes_with_the_slopes_that_a_relief_has_beside_it():
    raised, glasses = np.zeros((2, SIZE, SIZE), bool)
    raised[60:64], glasses[61:63] = True, True
    assert levelled(raised, glasses).max() < 1e-6


def test_what_stands_out_of_dark_glass_and_of_skin_stays():
    raised = np.zeros((SIZE, SIZE), bool)
    raised[60:63, 50:80] = raised[10:13, 50:80] = True
    np.testing.assert_allclose(levelled(raised, dark_glass()), HEIGHT * raised, atol=1e-6)
