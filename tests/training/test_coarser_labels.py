"""Channels and labels at a coarser size: means, shares, and pairs that keep their order."""

import torch

from relight_core.training.coarser import label_shares, shrunk, shrunk_heads, shrunk_within
from relight_core.training.losses import focal_parsing
from relight_core.training.relight_steps import flatten_pairs


def test_images_shrink_by_area_and_lights_do_not():
    images = torch.rand(2, 3, 64, 64)
    torch.testing.assert_close(shrunk(images, 16)[1, 2, 5, 7], images[1, 2, 20:24, 28:32].mean())
    light = torch.rand(2, 16, 32, 3)
    assert shrunk(light, 8) is light
    assert shrunk(images, None) is images


def test_shares_are_those_of_the_pixels_in_each_square():
    label = torch.zeros(1, 8, 6, dtype=torch.long)
    label[0, :2, 2:4] = 1
    label[0, 4:, 4:] = 2
    shares = label_shares(label, 3, (2, 3))
    assert shares[0, :, 0, 1].tolist() == [0.5, 0.5, 0.0]
    assert shares[0, :, 1, 2].tolist() == [0.0, 0.0, 1.0]
    torch.testing.assert_close(shares.sum(1), torch.ones(1, 2, 3))


def test_coarse_logits_are_judged_by_every_pixel_that_they_stand_for():
    torch.manual_seed(3)
    coarse, label = torch.randn(2, 5, 4, 4), torch.randint(5, (2, 8, 8))
    fine = coarse.repeat_interleave(2, 2).repeat_interleave(2, 3)
    torch.testing.assert_close(focal_parsing(coarse, label), focal_parsing(fine, label))


def test_pairs_come_flat_in_order_and_shrunk_with_a_parsing_of_their_size():
    number = torch.arange(4.0).reshape(2, 2)
    batch = {
        "image": number[..., None, None, None].expand(2, 2, 3, 8, 8),
        "light": torch.rand(2, 2, 16, 32, 3),
        "covered": torch.tensor([0.25, 0.75])[:, None, None, None].expand(2, 1, 8, 8),
        "label": torch.tensor([3, 5])[:, None, None].expand(2, 8, 8),
    }
    flat = flatten_pairs(batch, 4)
    assert flat["image"].shape == (4, 3, 4, 4)
    assert flat["image"][:, 0, 0, 0].tolist() == [0, 1, 2, 3]
    assert flat["covered"][:, 0, 0, 0].tolist() == [0.25, 0.25, 0.75, 0.75]
    assert flat["parsing"].argmax(1)[:, 1, 2].tolist() == [3, 3, 5, 5]
    assert torch.equal(flat["light"], batch["light"].flatten(0, 1))


def test_a_square_that_is_covered_in_part_has_the_mean_of_that_part():
    covered = torch.zeros(1, 1, 4, 4)
    covered[..., 0, :3] = 1
    value = torch.full((1, 2, 4, 4), 9.0)
    value[..., 0, :3] = torch.tensor([1.0, 3.0, 5.0])
    small = shrunk_within(value, covered, 2)
    assert small[0, 1].tolist() == [[2.0, 5.0], [0.0, 0.0]]
    assert shrunk_within(value, covered, 4) is value
    torch.testing.assert_close(shrunk_within(value, covered / 1000, 2), small)


def test_what_lies_outside_a_head_has_no_say_in_its_shrunk_channels():
    torch.manual_seed(1)
    covered = (torch.rand(2, 1, 8, 8) > 0.4).float()
    images = {"covered": covered, "albedo": torch.rand(2, 3, 8, 8), "light": torch.rand(2, 16, 32, 3)}
    other = images | {"albedo": torch.where(covered > 0, images["albedo"], 7.0)}
    torch.testing.assert_close(shrunk_heads(images, 4), shrunk_heads(other, 4))
