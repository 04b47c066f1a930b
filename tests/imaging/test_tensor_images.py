"""Images as tensors and back."""

import numpy as np
import pytest
import torch

from relight_core.imaging.tensor_images import as_image, as_tensor, enlarge, resized


@pytest.mark.parametrize("shape", [(2, 3), (2, 3, 3)])
def test_an_image_comes_back_as_itself(shape):
    image = np.random.default_rng(0).random(shape).astype(np.float32)
    np.testing.assert_array_equal(as_image(as_tensor(image)), image)
    np.testing.assert_array_equal(as_image(as_tensor(image[::-1])), image[::-1])


def test_channels_are_planes_of_a_tensor():
    image = np.float32([[[1, 2, 3], [4, 5, 6]]])
    assert as_tensor(image).tolist() == [[[[1, 4]], [[2, 5]], [[3, 6]]]]


def test_enlarging_blends_between_the_middles_of_pixels():
    enlarged = enlarge(torch.tensor([[[[0.0, 4.0]]]]), (1, 4))
    assert enlarged.tolist() == [[[[0, 1, 3, 4]]]]


def test_an_image_of_another_size_is_averaged_or_lies_between_its_pixels():
    image = torch.tensor([[0.0, 4.0], [8.0, 4.0]])[None, None]
    assert resized(image, 2) is image
    assert float(resized(image, 1)) == 4
    larger = resized(image, 4)
    assert larger.shape == (1, 1, 4, 4)
    torch.testing.assert_close(larger[0, 0, 0], torch.tensor([0.0, 1.0, 3.0, 4.0]))
