"""One step of training, and what lets a GPU play it back."""

import copy
from dataclasses import replace

import pytest
import torch
from small_runs import some_batch
from torch.overrides import TorchFunctionMode
from torch.utils._python_dispatch import TorchDispatchMode

from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import BundleConfig, NetworkBundle
from relight_core.training.optimiser import Optimiser
from relight_core.training.stages import STAGES
from relight_core.training.step import RecordedStep, Step

RECORDABLE = ["warm-delight", "tune-delight", "tune-delight-strongly"]
HOST_ONLY = ("_local_scalar_dense", "lift_fresh", "nonzero", "masked_select", "is_nonzero", "_unique")
MAKERS = ("rand", "randint", "randperm", "arange", "linspace", "zeros", "ones", "full", "empty", "eye")


class WhatIsRun(TorchDispatchMode):
    """Notes where a GPU would wait for the host: numbers that are read, tensors made of lists, picks by a mask."""

    def __init__(self, asked):
        super().__init__()
        self.asked = asked

    def __torch_dispatch__(self, function, types, args=(), kwargs=None):
        name = function.name().split("::")[1].split(".")[0]
        by_mask = name in ("index", "index_put_") and any(i is not None and i.dtype == torch.bool for i in args[1])
        if name in HOST_ONLY or by_mask:
            self.asked.append(name)
        return function(*args, **(kwargs or {}))


class WhatIsCalled(TorchFunctionMode):
    """Notes tensors that are made without being told where, and so on the host."""

    def __init__(self, asked):
        super().__init__()
        self.asked = asked

    def __torch_function__(self, function, types, args=(), kwargs=None):
        if function in [getattr(torch, name) for name in MAKERS] and (kwargs or {}).get("device") is None:
            self.asked.append(function.__name__)
        return function(*args, **(kwargs or {}))


def asked_of_host(losses, times):
    for _ in range(times - 1):
        losses()
    asked = []
    with WhatIsCalled(asked), WhatIsRun(asked):
        losses()
    return asked


@pytest.mark.parametrize("name", RECORDABLE)
def test_what_is_recorded_asks_the_host_for_nothing_but_at_first(name):
    bundle, table, batch = NetworkBundle(BundleConfig.tiny()).train(), ReflectionTable(), some_batch(pairs=2)
    assert asked_of_host(lambda: sum(STAGES[name].losses(bundle, table, batch).values()).backward(), times=2) == []


def test_a_step_that_would_ask_is_noticed():
    image = torch.rand(4)
    for losses in (
        lambda: float(image.sum()),
        lambda: image * torch.tensor([1.0, 2, 3, 4]),
        lambda: image + torch.rand(4),
        lambda: image[image > 0.5],
    ):
        assert asked_of_host(losses, times=1)


def test_only_stages_that_ask_nothing_are_recorded():
    assert [name for name, stage in STAGES.items() if stage.recordable] == RECORDABLE


def step_on(kind, bundle, device):
    bundle.delight.requires_grad_(True)
    optimiser = Optimiser(bundle, 1e-3)
    return kind(STAGES["warm-delight"], bundle, ReflectionTable().to(device), optimiser, device)


def test_a_batch_that_is_not_finite_changes_nothing():
    bundle = NetworkBundle(BundleConfig.tiny()).train().requires_grad_(False).to(memory_format=torch.channels_last)
    step = step_on(Step, bundle, "cpu")
    assert step(some_batch(pairs=2)).keys() >= {"albedo", "normal", "light"}
    before = copy.deepcopy(bundle.state_dict())
    broken = some_batch(pairs=2)
    broken["light"][0] = float("inf")
    assert step(broken) == {}
    for name, value in bundle.state_dict().items():
        torch.testing.assert_close(value, before[name], rtol=0, atol=0)


@pytest.mark.parametrize(
    "spoilt",
    [lambda weight: weight.sum() + float("inf"), lambda weight: (0 * weight).sum().sqrt()],
    ids=["loss", "gradient"],
)
def test_a_loss_or_a_gradient_that_alone_is_not_finite_changes_nothing(spoilt):
    bundle = NetworkBundle(BundleConfig.tiny()).requires_grad_(False).to(memory_format=torch.channels_last)
    bundle.delight.requires_grad_(True)
    losses = lambda bundle, table, batch: {"spoilt": spoilt(bundle.delight.head.weight)}  # noqa: E731
    stage = replace(STAGES["warm-delight"], losses=losses)
    before = bundle.delight.head.weight.detach().clone()
    assert Step(stage, bundle, ReflectionTable(), Optimiser(bundle, 1e-3), "cpu")({}) == {}
    assert torch.equal(bundle.delight.head.weight, before)


@pytest.mark.skipif(not torch.cuda.is_available(), reason="no GPU")
def test_a_recorded_step_learns_what_others_do():
    torch.manual_seed(0)
    start, batch = NetworkBundle(BundleConfig.tiny()).train().requires_grad_(False), some_batch(pairs=2)
    losses = {}
    for kind in (Step, RecordedStep):
        torch.manual_seed(1)
        bundle = copy.deepcopy(start).to("cuda", memory_format=torch.channels_last)
        with torch.cuda.stream(torch.cuda.Stream()):
            step = step_on(kind, bundle, "cuda")
            ready = {name: value.cuda() for name, value in batch.items()}
            losses[kind] = [sum(step(ready).values()) for _ in range(12)]
    assert losses[RecordedStep] == pytest.approx(losses[Step], rel=0.02)
    assert losses[Step][-1] < 0.9 * losses[Step][0]
