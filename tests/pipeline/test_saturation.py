"""What of a change of colour is taken for a camera's doing."""

import pytest
import torch

from relight_core.pipeline.per_photo.saturation import log_colours, middle_colour, of_camera, recoloured, saturation

SKIN = torch.tensor([0.5, -0.1, -0.4])
YELLOWER = torch.tensor([0.0, 0.04, -0.04])
"""About across the skin's own colour."""


def kept(change, saturated):
    return of_camera(change, SKIN, torch.tensor(saturated))


def test_more_of_a_surfaces_own_colour_is_the_cameras_as_far_as_it_saturates():
    torch.testing.assert_close(kept(0.3 * SKIN, 0.3), 0.3 * SKIN, rtol=0.05, atol=0.005)
    torch.testing.assert_close(kept(0.5 * SKIN, 0.2), 0.2 * SKIN, rtol=0.1, atol=0.01)


def test_with_it_goes_the_hue_that_curves_give_skin():
    change = 0.3 * SKIN + YELLOWER
    torch.testing.assert_close(kept(change, 0.3), change, rtol=0.1, atol=0.01)


@pytest.mark.parametrize("colour", [(-0.3, 0.6, -0.3), (0.3, -0.6, 0.3)])
def test_of_a_green_or_purple_lights_colour_little_goes_with_it(colour):
    across = torch.tensor(colour)
    assert (kept(0.2 * SKIN + across, 0.2) - 0.2 * SKIN).norm() < 0.1 * across.norm()


def test_a_camera_that_does_not_saturate_adds_no_colour_at_all():
    assert kept(torch.tensor([-0.3, 0.5, -0.2]), 0.0).abs().max() < 1e-6
    assert kept(torch.zeros(3), 0.0).isfinite().all()


def test_what_is_nearly_black_has_next_to_no_colour_and_brighter_the_same_colour_has_one():
    red = torch.tensor([0.002, 0.0005, 0.0005])[None, :, None, None]
    black, dark, bright = (float(log_colours(red * times)[0, 0, 0]) for times in (1, 10, 200))
    assert 0 < black < 0.2
    assert 0.5 < dark < 0.7
    assert 0.8 < bright < 0.93


def test_what_is_given_another_colour_stays_as_bright_as_it_is():
    albedo = torch.tensor([0.5, 0.3, 0.2])[None, :, None, None].expand(1, 3, 4, 4)
    blue = torch.tensor([-0.6, -0.2, 0.8]).expand(4, 4, 3)
    share = torch.tensor([0.0, 0.5, 1.0, 1.0]).expand(1, 1, 4, 4)
    given = recoloured(albedo, blue, share)
    luminance = torch.tensor([0.2126, 0.7152, 0.0722])
    torch.testing.assert_close(given[0, :, 0].T @ luminance, (albedo[0, :, 0].T @ luminance), rtol=1e-3, atol=0)
    torch.testing.assert_close(given[0, :, 0, 0], albedo[0, :, 0, 0])
    torch.testing.assert_close((given[0, 2] / given[0, 0])[0, 2:].log(), torch.full((2,), 1.4), rtol=1e-3, atol=0)


def test_of_what_is_as_good_as_grey_no_change_is_a_multiple():
    nearly_grey = torch.tensor([0.02, -0.01, -0.01])
    assert abs(float(saturation(10 * nearly_grey, nearly_grey))) < 1
    assert float(saturation(0.2 * SKIN, SKIN)) == pytest.approx(0.2, rel=0.05)


def test_a_middle_colour_is_that_of_most_of_a_part_and_says_nothing_of_brightness():
    image = torch.tensor([0.5, 0.3, 0.2])[None, :, None, None].repeat(1, 1, 10, 10)
    image[0, :, :4] = torch.tensor([0.1, 0.2, 0.6])[:, None, None]
    image[0, 1, 4:7] = 0.32
    middle = middle_colour(image, torch.ones(1, 1, 10, 10))
    logarithm = torch.tensor([0.5, 0.3, 0.2]).log()
    torch.testing.assert_close(middle, logarithm - logarithm.mean(), rtol=0, atol=0.05)
    assert abs(float(middle.mean())) < 1e-6
    assert middle_colour(image, torch.full((1, 1, 10, 10), 0.5)) is None
