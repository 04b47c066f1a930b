"""Local means, medians and ranges of image tensors."""

import torch

from relight_core.imaging.tensor_means import local_means, local_medians, local_range


def test_what_does_not_count_has_no_say_in_a_mean_nor_has_the_border():
    image, weight = torch.full((1, 2, 64, 64), 3.0), torch.ones(1, 1, 64, 64)
    image[..., 32:], weight[..., 32:] = 90.0, 0.0
    means = local_means(image, weight)
    torch.testing.assert_close(means[..., :33], torch.full((1, 2, 64, 33), 3.0))
    assert means[..., 40:].max() == 0


def test_the_range_about_a_pixel_is_that_of_the_square_whose_median_is_taken():
    image = torch.zeros(1, 1, 50, 50)
    image[..., 20:] = 1.0
    image[..., 10, 40] = 5.0
    least, most = local_range(image, 0.06)
    assert least[0, 0, 25].tolist() == [0.0] * 23 + [1.0] * 27
    assert most[0, 0, 25].tolist() == [0.0] * 17 + [1.0] * 33
    assert (most[0, 0, 7:14, 37:44] == 5.0).all()
    assert int((most == 5.0).sum()) == 49
    medians = local_medians(image, torch.ones(1, 1, 50, 50), 0.06)
    assert medians[0, 0, 25].tolist() == [0.0] * 20 + [1.0] * 30
