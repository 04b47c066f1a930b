"""Local means, medians and ranges of image tensors."""

import torch

from relight_core.imaging.tensor_means import local_means, local_medians, local_range, middle_values, with_neighbours


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


def test_a_mean_reaches_as_far_as_it_is_told_and_a_cheek_otherwise():
    spot, weight = torch.zeros(1, 1, 100, 100), torch.ones(1, 1, 100, 100)
    spot[..., 50, 50] = 1.0
    for means, reach_px in ((local_means(spot, weight), 6), (local_means(spot, weight, 0.2), 20)):
        rows, columns = torch.nonzero(means[0, 0] > 0, as_tuple=True)
        assert (int(rows.min()), int(rows.max())) == (50 - reach_px, 50 + reach_px)
        assert (int(columns.min()), int(columns.max())) == (50 - reach_px, 50 + reach_px)
        assert means[0, 0, 50, 50] == means.max()


def test_what_counts_little_all_over_has_its_mean_all_the_same():
    means = local_means(torch.full((1, 3, 40, 40), 3.0), torch.full((1, 1, 40, 40), 0.02))
    torch.testing.assert_close(means, torch.full((1, 3, 40, 40), 3.0))


def test_what_does_not_count_is_filled_before_medians_and_beyond_the_border_its_edge_goes_on():
    image, weight = torch.full((1, 2, 50, 50), 5.0), torch.ones(1, 1, 50, 50)
    image[..., :25], weight[..., :25] = 90.0, 0.0
    medians = local_medians(image, weight, 0.06)
    torch.testing.assert_close(medians[..., 24:], torch.full((1, 2, 50, 26), 5.0))


def test_middle_values_are_each_channels_own():
    image = torch.tensor([[1.0, 2.0, 9.0], [30.0, 10.0, 20.0]]).reshape(1, 2, 1, 3)
    assert middle_values(image, torch.ones(1, 3, dtype=torch.bool)).tolist() == [[[[2.0]], [[20.0]]]]
    assert middle_values(image, torch.tensor([[False, False, True]])).tolist() == [[[[9.0]], [[20.0]]]]


def test_a_pixel_shares_with_its_neighbours_and_an_even_image_stays_even():
    spot = torch.zeros(1, 1, 5, 5)
    spot[..., 2, 2] = 16.0
    shared = with_neighbours(spot, 1 / 4)[0, 0]
    assert shared.tolist() == [[0] * 5, [0, 1, 2, 1, 0], [0, 2, 4, 2, 0], [0, 1, 2, 1, 0], [0] * 5]
    even = torch.full((2, 3, 4, 5), 7.0)
    torch.testing.assert_close(with_neighbours(even, 1 / 3), even)
