"""The foreign-shadow network, alone and among the others in one file, and what its errors cost."""

import pytest
import torch

from relight_core.face.parsing import KINDS
from relight_core.networks.bundle import (
    BundleConfig,
    NetworkBundle,
    load_bundle,
    save_bundle,
    with_foreign_shadow_network,
)
from relight_core.networks.foreign_shadow import ForeignShadowConfig, ForeignShadowNetwork
from relight_core.training.foreign_shadow_step import foreign_shadow_losses

TINY = ForeignShadowConfig(width=4, levels=3, widest=8)


@pytest.fixture(autouse=True)
def _seeded():
    torch.manual_seed(0)


def planes(size=32):
    torch.manual_seed(1)
    return torch.rand(2, 3, size, size), torch.rand(2, 4, size, size) / 4


@pytest.mark.parametrize("size", [24, 64])
def test_every_pixel_gets_a_log_for_each_channel_at_any_size_that_fits(size):
    logs = ForeignShadowNetwork(TINY).eval()(*planes(size))
    assert logs.shape == (2, 3, size, size)
    assert logs.dtype == torch.float32


def test_what_lies_where_matters():
    network = ForeignShadowNetwork(TINY).eval()
    photo, parts = planes()
    assert (network(photo, parts) - network(photo, parts.roll(1, 1))).abs().max() > 1e-4


def test_what_lies_in_one_corner_says_something_of_the_opposite_one():
    network = ForeignShadowNetwork(TINY).eval()
    photo, parts = planes(256)
    other = photo.clone()
    other[..., :32, :32] = 0
    assert not torch.equal(network(photo, parts)[..., 240:, 240:], network(other, parts)[..., 240:, 240:])


def test_each_pixel_of_a_block_of_four_has_a_log_of_its_own():
    logs = ForeignShadowNetwork(TINY).eval()(*planes())
    four = [logs[..., row::2, column::2] for row in (0, 1) for column in (0, 1)]
    for one in range(4):
        for other in range(one):
            assert (four[one] - four[other]).abs().mean() > 1e-3


def test_the_coarsest_level_tells_places_apart_even_where_all_of_the_picture_says_nothing():
    network = ForeignShadowNetwork(TINY).eval()
    torch.nn.init.zeros_(network.overview.weight)
    torch.nn.init.zeros_(network.overview.bias)
    before = network(*planes(64))
    network.encoder.levels[-1][-1].norm.weight.data *= 1000
    assert (network(*planes(64)) - before).abs().max() > 1e-3


def test_no_level_has_more_channels_than_the_widest_may_have():
    widths = [value.shape[0] for value in ForeignShadowNetwork(TINY).encoder.parameters()]
    assert max(widths) == 8


def test_it_is_told_of_all_classes_but_the_background():
    assert len(KINDS) == 4
    names = [name for kind in KINDS for name in kind]
    assert len(set(names)) == len(names) == 13
    assert "background" not in names


def test_it_travels_with_the_other_networks(tmp_path):
    before = NetworkBundle(BundleConfig.tiny())
    bundle = with_foreign_shadow_network(before, ForeignShadowNetwork(TINY))
    save_bundle(tmp_path / "w.safetensors", bundle, half=False)
    loaded = load_bundle(tmp_path / "w.safetensors").eval()
    assert loaded.config.foreign_shadow == TINY
    expected = bundle.eval().foreign_shadow(*planes())
    torch.testing.assert_close(loaded.foreign_shadow(*planes()), expected, rtol=0, atol=0)
    torch.testing.assert_close(loaded.for_inference().foreign_shadow(*planes()), expected, rtol=1e-4, atol=1e-5)
    for name, value in before.state_dict().items():
        torch.testing.assert_close(bundle.state_dict()[name], value, rtol=0, atol=0)


class Says(torch.nn.Module):
    def __init__(self, logs):
        super().__init__()
        self.logs = logs

    def forward(self, photo, parts):
        return self.logs


def batch_of(true, person=None):
    photo, parts = planes()
    person = torch.ones(2, 1, 32, 32) if person is None else person
    return {"photo_srgb": photo, "kinds": parts, "foreign_shadow": true, "person": person}


def half(depth=1.0):
    shadow = torch.zeros(2, 3, 32, 32)
    shadow[..., :16] = -depth
    return shadow


def test_the_truth_costs_nothing_and_an_error_as_much_as_it_is_large():
    assert sum(foreign_shadow_losses(Says(half()), batch_of(half())).values()) == 0
    losses = foreign_shadow_losses(Says(half(0.5)), batch_of(half()))
    assert float(losses["level"]) == pytest.approx(0.25)
    assert float(losses["colour"]) == pytest.approx(0, abs=1e-6)


def test_a_colour_that_is_off_is_told_from_a_level():
    bluer = half() + torch.tensor([-0.3, 0.0, 0.3])[None, :, None, None]
    losses = foreign_shadow_losses(Says(bluer), batch_of(half()))
    assert float(losses["colour"]) == pytest.approx(0.2, abs=1e-6)
    assert float(losses["level"] + losses["slopes"]) == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("first", [16, 13])
def test_off_the_person_nothing_is_asked_for(first):
    person = torch.ones(2, 1, 32, 32)
    person[..., first:, :] = 0
    said = half()
    said[..., first:, :] = -2 * torch.rand(2, 3, 32 - first, 32)
    assert sum(foreign_shadow_losses(Says(said), batch_of(half(), person)).values()) == 0


def test_an_error_costs_as_much_whatever_the_person_s_size():
    person = torch.zeros(2, 1, 32, 32)
    person[..., :8] = 1
    off = torch.tensor([0.2, 0.5, 0.8])[None, :, None, None]
    losses = foreign_shadow_losses(Says(half() + off), batch_of(half(), person))
    assert float(losses["level"]) == pytest.approx(0.5, rel=1e-5)
    assert float(losses["colour"]) == pytest.approx(0.2, rel=1e-5)


@pytest.mark.parametrize("turned", [False, True])
def test_a_step_that_is_not_there_costs_at_four_scales_in_either_direction(turned):
    step = torch.full((2, 3, 32, 32), 0.5)
    step[..., 16:] = -0.5
    losses = foreign_shadow_losses(Says(step.mT if turned else step), batch_of(0 * step))
    assert float(losses["level"]) == pytest.approx(0.5)
    # One of so many neighbours is off by 1.
    assert float(losses["slopes"]) == pytest.approx(0.5 * (1 / 31 + 1 / 15 + 1 / 7 + 1 / 3), rel=1e-5)


def test_what_cancels_out_at_a_coarser_scale_costs_at_the_finest_alone():
    stripes = torch.tensor([1.0, -1, -1, 1]).repeat(8).expand(2, 3, 32, 32)
    losses = foreign_shadow_losses(Says(stripes), batch_of(0 * stripes))
    assert float(losses["slopes"]) == pytest.approx(0.5 * 32 / 31, rel=1e-5)


def test_nobody_in_a_picture_costs_nothing():
    losses = foreign_shadow_losses(Says(half()), batch_of(0 * half(), torch.zeros(2, 1, 32, 32)))
    assert float(sum(losses.values())) == 0


def test_a_blurred_edge_costs_more_than_an_even_error_of_the_same_mean():
    blurred, even = half(), half()
    blurred[..., 12:20] = torch.linspace(-1, 0, 8)
    error = (blurred - half()).abs().mean()
    even = even + error
    one, other = (foreign_shadow_losses(Says(said), batch_of(half())) for said in (blurred, even))
    assert float(one["level"]) == pytest.approx(float(other["level"]), rel=1e-4)
    assert float(one["slopes"]) > float(other["slopes"]) + 0.02
