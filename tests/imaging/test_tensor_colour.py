"""The sRGB curve and luminance of tensors."""

import pytest
import torch

from relight_core.imaging.tensor_colour import as_bright_as, grey, srgb_decode, srgb_encode


def test_known_points_of_the_srgb_curve():
    linear = torch.tensor([0.0, 0.002, 0.18, 0.5, 1.0, 4.0])
    encoded = torch.tensor([0.0, 0.02584, 0.46136, 0.73536, 1.0, 1.8248])
    torch.testing.assert_close(srgb_encode(linear), encoded, atol=2e-4, rtol=0)
    torch.testing.assert_close(srgb_decode(encoded), linear, atol=1e-3, rtol=0)


def test_decoding_takes_encoding_back_in_the_dark_as_in_the_light():
    linear = torch.cat([torch.linspace(0, 0.01, 50), torch.linspace(0.01, 3, 50)])
    torch.testing.assert_close(srgb_decode(srgb_encode(linear)), linear, rtol=1e-4, atol=1e-6)


def test_what_is_below_black_decodes_to_black():
    assert srgb_decode(torch.tensor([-0.5, -1e-4, 0.0])).tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("curve", [srgb_encode, srgb_decode])
def test_gradients_at_black_are_finite_and_not_none(curve):
    black = torch.zeros(3, requires_grad=True)
    curve(black).sum().backward()
    assert black.grad.isfinite().all()
    assert black.grad.min() > 0


def test_grey_is_rec709s_luminance_of_each_pixel():
    colours = torch.eye(3)[:, :, None, None]
    torch.testing.assert_close(grey(colours).flatten(), torch.tensor([0.2126, 0.7152, 0.0722]))
    assert grey(torch.ones(2, 3, 4, 5)).shape == (2, 1, 4, 5)


def test_dark_colours_are_made_as_bright_as_others_and_stay_colours():
    dark = torch.tensor([0.004, 0.001, 0.002])[None, :, None, None]
    bright = as_bright_as(dark, torch.full((1, 3, 1, 1), 0.5))
    torch.testing.assert_close(grey(bright), torch.full((1, 1, 1, 1), 0.5))
    torch.testing.assert_close(bright[:, 0], 4 * bright[:, 1])
    assert as_bright_as(torch.zeros(1, 3, 1, 1), torch.ones(1, 3, 1, 1)).isfinite().all()
