"""What the pages of a bench and of a replayed session say, figure by figure."""

import re
from dataclasses import replace
from types import SimpleNamespace

import pytest

from relight_core.evaluation.bench_accuracy import Accuracy
from relight_core.evaluation.bench_configurations import Configuration, configurations
from relight_core.evaluation.bench_machine import Demand, Peaks, demands
from relight_core.evaluation.bench_report import BenchResult, Row, as_markdown
from relight_core.evaluation.bench_session import Savings
from relight_core.evaluation.bench_session import as_markdown as session_words
from relight_core.evaluation.bench_timing import Spread, Timing
from relight_core.networks.bundle import BundleConfig, NetworkBundle
from relight_core.pipeline.quality import Tier

MACHINE = {"processor": "A chip", "threads": 1, "cores": 2, "torch": "2.0", "device": "cpu", "system": "Linux"}
SMALL = Tier(32, 32, 32, 8, False)
FINALS = [("draft", 1.0, 0.02), ("live", 3.0, 0.03), ("final", 4.0, 0.0)]


def row(name, rotation_ms, rmse, is_tier=True):
    actions = {"delight": Spread(50.0, 60.0), "rotation": Spread(rotation_ms, 9.0), "slider": Spread(0.5, 0.75)}
    timing = Timing(actions, {"compose": Spread(2.0, 3.0)}, None)
    accuracy = Accuracy(rmse, 20.0, 0.0125)
    return Row(Configuration(name, SMALL, name, is_tier), timing, accuracy, {"compose": Demand(1.0, 2.0)})


def page(*rows, **machine):
    return as_markdown(BenchResult(MACHINE | machine, Peaks({"fp32": 50.0}, 8.0), list(rows))).splitlines()


def test_a_page_has_a_star_at_what_nothing_beats_and_tiers_in_bold():
    lines = page(row("draft", 1.0, 0.2), row("slow draft", 2.0, 0.25, is_tier=False), row("live", 3.0, 0.1))
    assert lines[0] == "A chip, 1 thread of 2 cores; torch 2.0 on cpu, Linux"
    rows = [line for line in lines if "50.0 (60.0)" in line]
    assert rows == [
        "| **draft** * | 50.0 (60.0) | 1.0 (9.0) | 0.5 (0.8) | 0.2000 | 20.0 | 0.0125 | – |",
        "| slow draft | 50.0 (60.0) | 2.0 (9.0) | 0.5 (0.8) | 0.2500 | 20.0 | 0.0125 | – |",
        "| **live** * | 50.0 (60.0) | 3.0 (9.0) | 0.5 (0.8) | 0.1000 | 20.0 | 0.0125 | – |",
    ]
    limits = [line for line in lines if ": compose" in line]
    # 1 GFLOP at 50 a second.
    assert limits == [f"| {name}: compose | 1.00 | 2.0 | 20.0 | 2.0 (3.0) |" for name in ("draft", "live")]
    assert "Measured peaks: 50 GFLOP/s in fp32, 8.0 GB/s." in lines
    assert not any("From the start of the program" in line for line in lines)


def test_a_page_tells_how_busy_the_machine_was_and_how_soon_there_is_a_picture():
    lines = page(row("draft", 1.0, 0.2), load_average=0.0, first_picture_s=4.5)
    assert ", load 0.0;" in lines[0]
    assert "From the start of the program to a relit picture in a file: 4.5 s." in lines


def test_without_the_truth_the_front_is_that_of_the_errors_against_final():
    rows = [replace(row(name, ms, None), accuracy=Accuracy(None, None, error)) for name, ms, error in FINALS]
    stars = {
        found[1]: bool(found[2]) for line in page(*rows) if (found := re.match(r"\| \*\*(\w+)\*\*( \*)? \|", line))
    }
    assert stars == {"draft": True, "live": False, "final": True}


def test_what_leaves_a_network_out_is_among_the_first_that_are_compared():
    networks = {found.name: (found.tier.shadow_network, found.tier.correction) for found in configurations(quick=True)}
    assert networks["live, no correction"] == (True, False)
    assert networks["live, relief's shadow, corrected"] == (False, True)
    assert networks["draft"] == (False, False)
    assert networks["live"] == (True, True)


def test_every_look_is_asked_of_de_lighting_and_half_as_much_moves_in_half_precision():
    bundle = NetworkBundle(BundleConfig.tiny()).for_inference()
    once = demands(bundle, SMALL)["delight"]
    for looks, tier in ((2, replace(SMALL, mirrored=True)), (4, replace(SMALL, mirrored=True, looks_twice=True))):
        asked = demands(bundle, tier)["delight"]
        assert asked.gflop == pytest.approx(looks * once.gflop)
        assert asked.megabytes == pytest.approx(looks * once.megabytes)
    whole = demands(bundle, replace(SMALL, precision="fp32"))["delight"]
    assert whole.megabytes == pytest.approx(2 * once.megabytes)


def left_out(bound, saved_ms):
    effects = [
        ("relief", "skipped", f"flat: {bound}", bound, saved_ms),
        ("detail", "reused", "the same", None, None),
        ("shadow", "computed", "a light", 0.5, 7.0),
    ]
    names = ("name", "state", "why", "bound", "saved_ms")
    return SimpleNamespace(plan=[SimpleNamespace(**dict(zip(names, effect, strict=True))) for effect in effects])


def test_every_reason_for_leaving_an_effect_out_has_its_times_and_its_largest_error():
    savings = Savings(updates=2, runs=8, avoided=2, ms=500.0, ms_of_everything=2000.0, largest_error=0.02, compared=2)
    for bound, saved_ms, error in ((0.01, 20.0, 0.004), (0.03, 30.0, 0.001), (0.02, None, None)):
        savings.note_rules(left_out(bound, saved_ms), error)
    lines = session_words(savings).splitlines()
    assert lines[0] == "2 updates: 25.0 % of 8 stage runs avoided;"
    assert lines[1] == "0.5 s, against 2.0 s if every stage ran every time (25.0 %);"
    assert lines[2].startswith("largest error 5.10 / 255 over 2 pictures compared")
    assert lines[-2:] == [
        "| detail | reused | the same | 3 | 0.00 | – | 2 | 1.02 |",
        "| relief | skipped | flat | 3 | 0.05 | 7.65 | 2 | 1.02 |",
    ]
    record = savings.as_record()
    assert (record["share_avoided"], record["share_of_time"]) == (0.25, 0.25)
    assert record["rules"][1] == {
        "effect": "relief",
        "state": "skipped",
        "why": "flat",
        "times": 3,
        "saved_ms": 50.0,
        "bound": 0.03,
        "compared": 2,
        "largest_error": 0.004,
    }
