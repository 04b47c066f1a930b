"""Samples a second, told by a clock that goes on with every sample and at no other time."""

import itertools
from dataclasses import replace
from types import SimpleNamespace

import torch

from relight_core.evaluation import loader_speed as module
from relight_core.evaluation.loader_speed import LoaderSpeed, loader_speed, waiting_share
from relight_core.networks.bundle import BundleConfig, NetworkBundle
from relight_core.training.stages import STAGES


def test_samples_a_second_are_of_whole_heads_by_either_clock_and_leave_out_what_happens_once(monkeypatch):
    wall_s, cpu_s, threads = [0.0], [0.0], []

    class Stream:
        """Pairs of photos, the first of which comes late, and slowly those that begin another head."""

        paints_per_head = 3

        def __init__(self, *given, **named):
            pass

        def __iter__(self):
            for number in itertools.count():
                threads.append(torch.get_num_threads())
                seconds = 100.0 if number == 0 else 4.0 if number % 3 == 0 else 1.0
                wall_s[0] += seconds
                cpu_s[0] += seconds / 2
                yield number

    clocks = SimpleNamespace(perf_counter=lambda: wall_s[0], process_time=lambda: cpu_s[0])
    monkeypatch.setattr(module, "SampleStream", Stream)
    monkeypatch.setattr(module, "time", clocks)
    before = torch.get_num_threads()
    # Two rounds of eight heads, whose three pairs take 1 + 1 + 4 seconds.
    assert loader_speed("heads", "lights", 64, rounds=2) == LoaderSpeed(64, 96, 1.0, 2.0)
    assert set(threads) == {1}
    assert torch.get_num_threads() == before


def test_the_share_of_waiting_is_of_all_steps_but_those_in_which_the_loader_begins(monkeypatch):
    now_s = [0.0]

    def batches(*_):
        for number in itertools.count():
            now_s[0] += 50.0 if number < 2 else 3.0
            yield {}

    def losses(bundle, table, batch):
        now_s[0] += 1.0
        return {"one": sum(weight.sum() for weight in bundle.delight.parameters())}

    monkeypatch.setattr(module, "training_batches", batches)
    monkeypatch.setattr(module, "training_device", lambda: "cpu")
    nothing = SimpleNamespace(zero_grad=lambda: None, step=lambda: None)
    monkeypatch.setattr(module, "Optimiser", lambda network, rate: nothing)
    monkeypatch.setattr(module, "NetworkBundle", lambda config: NetworkBundle(BundleConfig.tiny()))
    monkeypatch.setattr(module, "STAGES", {"warm-delight": replace(STAGES["warm-delight"], losses=losses)})
    monkeypatch.setattr(module, "time", SimpleNamespace(perf_counter=lambda: now_s[0]))
    assert waiting_share("heads", "lights", 64, steps=4) == 0.75
