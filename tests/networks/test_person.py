"""The person network, alone and among the others in one file."""

import math

import pytest
import torch

from relight_core.networks.bundle import BundleConfig, NetworkBundle, load_bundle, save_bundle, with_person_network
from relight_core.networks.person import PersonConfig, PersonNetwork
from relight_core.training.outline_step import outline_losses

TINY = PersonConfig(width=4, levels=3, widest=8)


pytestmark = pytest.mark.usefixtures("seeded")


def planes(size=32, batch=2):
    torch.manual_seed(1)
    photo = torch.rand(batch, 3, size, size)
    inside = torch.ones(batch, 1, size, size)
    face = torch.zeros(batch, 1, size, size)
    face[..., 8:20, 10:22] = 1
    return photo, inside, face


@pytest.mark.parametrize("size", [24, 64])
def test_every_pixel_gets_its_odds_at_any_size_that_fits(size):
    logits = PersonNetwork(TINY).eval()(*planes(size))
    assert logits.shape == (2, 1, size, size)
    assert logits.dtype == torch.float32


def test_which_face_is_marked_matters():
    network = PersonNetwork(TINY).eval()
    photo, inside, face = planes()
    here, there = (network(photo, inside, marked) for marked in (face, face.roll(8, 3)))
    assert (here - there).abs().max() > 1e-4


def test_it_travels_with_the_other_networks(tmp_path):
    bundle = with_person_network(NetworkBundle(BundleConfig.tiny()), PersonNetwork(TINY))
    save_bundle(tmp_path / "w.safetensors", bundle, half=False)
    loaded = load_bundle(tmp_path / "w.safetensors").eval()
    assert loaded.config.person == TINY
    torch.testing.assert_close(loaded.person(*planes()), bundle.eval().person(*planes()), rtol=0, atol=0)


def test_taking_it_in_leaves_the_others_alone():
    before = NetworkBundle(BundleConfig.tiny())
    after = with_person_network(before, PersonNetwork(TINY)).state_dict()
    for name, value in before.state_dict().items():
        torch.testing.assert_close(after[name], value, rtol=0, atol=0)


def test_folded_for_inference_it_says_the_same():
    bundle = with_person_network(NetworkBundle(BundleConfig.tiny()), PersonNetwork(TINY)).eval()
    expected = bundle.person(*planes())
    torch.testing.assert_close(bundle.for_inference().person(*planes()), expected, rtol=1e-4, atol=1e-5)


def batch_of(person):
    photo, inside, face = planes()
    return {"photo_srgb": photo, "inside": inside, "face": face, "person": person}


class Says(torch.nn.Module):
    """A network that has made up its mind."""

    def __init__(self, person):
        super().__init__()
        self.logits = (person * 2 - 1) * 12

    def forward(self, photo, inside, face):
        return self.logits


def half():
    person = torch.zeros(2, 1, 32, 32)
    person[..., :16] = 1
    return person


def test_the_truth_costs_nothing_and_its_opposite_much():
    right = outline_losses(Says(half()), batch_of(half()))
    wrong = outline_losses(Says(1 - half()), batch_of(half()))
    assert sum(right.values()) < 1e-3
    assert wrong["outline"] > 10
    assert wrong["overlap"] > 0.49


def test_what_lies_beyond_the_photo_is_not_asked_for():
    batch = batch_of(half())
    batch["inside"] = batch["inside"].clone()
    batch["inside"][..., 24:, :] = 0
    person = half()
    person[..., 24:, :] = 0
    batch["person"] = person
    assert sum(outline_losses(Says(half()), batch).values()) < 1e-3


@pytest.mark.parametrize("beside", [16, 19])
def test_an_error_at_the_edge_costs_more_than_one_far_from_it(beside):
    near, far = half(), half()
    near[..., 4, beside] = 1
    far[..., 4, 30] = 1
    at_edge, inside = (outline_losses(Says(said), batch_of(half()))["outline"] for said in (near, far))
    assert at_edge > 2 * inside


def test_a_photo_s_border_is_no_edge_of_whoever_fills_it():
    everybody, corner, middle = (torch.ones_like(half()) for _ in range(3))
    corner[..., 0, 0] = middle[..., 16, 16] = 0
    at_corner, within = (outline_losses(Says(said), batch_of(everybody))["outline"] for said in (corner, middle))
    assert float(at_corner) == pytest.approx(float(within), rel=1e-5)


def test_who_knows_nothing_pays_ln_2_and_half_of_the_overlap():
    """Of a person who is half of a photo of P pixels half is found, and as much is made up."""
    nothing, pixels = 0 * half() + 0.5, half()[0].numel()
    losses = outline_losses(Says(nothing), batch_of(half()))
    assert float(losses["outline"]) == pytest.approx(math.log(2), rel=1e-5)
    overlap = (2 * pixels / 4 + 1) / (pixels / 2 + pixels / 2 + 1)
    assert float(losses["overlap"]) == pytest.approx(0.5 * (1 - overlap), rel=1e-5)


def test_nobody_found_where_nobody_is_costs_next_to_nothing():
    assert sum(outline_losses(Says(0 * half()), batch_of(0 * half())).values()) < 0.01
