"""Local means of image tensors."""

import torch

from relight_core.imaging.tensor_means import local_means


def test_what_does_not_count_has_no_say_in_a_mean_nor_has_the_border():
    image, weight = torch.full((1, 2, 64, 64), 3.0), torch.ones(1, 1, 64, 64)
    image[..., 32:], weight[..., 32:] = 90.0, 0.0
    means = local_means(image, weight)
    torch.testing.assert_close(means[..., :33], torch.full((1, 2, 64, 33), 3.0))
    assert means[..., 40:].max() == 0
