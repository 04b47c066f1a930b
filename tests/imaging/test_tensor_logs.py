"""Logarithms of linear images, and what is left of them without brightness."""

import math

import torch

from relight_core.imaging.tensor_logs import exact_logs, log_ratios, logs, without_mean


def test_exact_logarithms_are_exact_down_to_a_thousandth():
    told = exact_logs(torch.tensor([0.0, 0.0005, 0.001, 0.002, 0.01, 1.0, 5.0]))
    expected = [math.log(value) for value in (0.001, 0.001, 0.001, 0.002, 0.01, 1.0, 5.0)]
    torch.testing.assert_close(told, torch.tensor(expected))


def test_black_has_a_logarithm_and_next_to_black_ratios_vanish():
    torch.testing.assert_close(logs(torch.tensor([0.0, 0.995])), torch.tensor([math.log(0.005), 0.0]))
    black, less, twice = torch.zeros(1), torch.tensor([0.5]), torch.tensor([1.0])
    assert log_ratios(black, black) == 0
    torch.testing.assert_close(log_ratios(twice, less), torch.tensor([math.log(1.005 / 0.505)]))
    assert log_ratios(black, black + 1e-4).abs() < 0.03


def test_without_its_mean_each_pixel_has_colour_and_no_brightness():
    images = torch.arange(24.0).reshape(2, 3, 2, 2) ** 2
    colours = without_mean(images)
    torch.testing.assert_close(colours.mean(1), torch.zeros(2, 2, 2), atol=1e-4, rtol=0)
    torch.testing.assert_close(colours[:, 1] - colours[:, 0], images[:, 1] - images[:, 0])
