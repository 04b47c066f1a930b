"""The moving average of the weights, which is what training saves."""

import pytest
import torch

from relight_core.networks.bundle import BundleConfig, NetworkBundle
from relight_core.training.loop import AveragedWeights

pytestmark = pytest.mark.usefixtures("seeded")


def filled(bundle, value):
    """The bundle, with the first of its weights all at one value."""
    with torch.no_grad():
        next(bundle.parameters()).fill_(value)
    return bundle


def first_weight(bundle):
    return float(next(bundle.parameters()).detach().flatten()[0])


@pytest.mark.parametrize(("steps", "least", "most"), [(50, 40, 49), (300, 250, 290), (2000, 1400, 1850)])
def test_averaged_weights_follow_closely_at_first_and_later_over_hundreds_of_steps(steps, least, most):
    bundle = NetworkBundle(BundleConfig.tiny())
    average = AveragedWeights(bundle)
    for step in range(1, steps + 1):
        average.update(filled(bundle, float(step)), step)
    assert least < first_weight(average.bundle(bundle)) < most


@pytest.mark.parametrize(("steps", "reached"), [(1, 1 - 2 / 11), (2, 1 - (3 / 12) ** 2), (3, 1 - (4 / 13) ** 3)])
def test_steps_too_few_for_an_update_are_caught_up_with(steps, reached):
    bundle = filled(NetworkBundle(BundleConfig.tiny()), 0.0)
    average = AveragedWeights(bundle)
    filled(bundle, 1.0)
    for step in range(1, steps + 1):
        average.update(bundle, step)
    assert first_weight(average.bundle(bundle)) == 0
    average.catch_up(bundle, steps)
    assert first_weight(average.bundle(bundle)) == pytest.approx(reached)


def test_nothing_is_left_to_catch_up_with_right_after_an_update():
    bundle = filled(NetworkBundle(BundleConfig.tiny()), 0.0)
    average = AveragedWeights(bundle)
    average.update(filled(bundle, 1.0), 4)
    reached = first_weight(average.bundle(bundle))
    average.catch_up(bundle, 4)
    assert first_weight(average.bundle(bundle)) == reached < 1


def test_counts_are_the_latest_and_no_mean():
    bundle = NetworkBundle(BundleConfig.tiny())
    counts = [name for name, value in bundle.state_dict().items() if not value.is_floating_point()]
    average = AveragedWeights(bundle)
    for name, count in bundle.named_buffers():
        if name in counts:
            count.fill_(7)
    average.update(bundle, 4)
    averaged = average.bundle(bundle).state_dict()
    assert counts
    assert {int(averaged[name]) for name in counts} == {7}


def test_the_averaged_bundle_has_a_card_and_weights_of_its_own():
    bundle = NetworkBundle(BundleConfig.tiny())
    bundle.card = {"steps": "12"}
    average = AveragedWeights(filled(bundle, 1.0))
    copy = average.bundle(bundle)
    filled(copy, 5.0).card["steps"] = "13"
    assert bundle.card == {"steps": "12"}
    assert average.bundle(bundle).card == {"steps": "12"}
    assert first_weight(bundle) == first_weight(average.bundle(bundle)) == 1
