"""What the pages of a bench and of a replayed session say, figure by figure."""

import re
from dataclasses import replace
from types import SimpleNamespace

import pytest

from relight_core.evaluation.bench_accuracy import Accuracy
from relight_core.evaluation.bench_configurations import Configuration, configurations
from relight_core.evaluation.bench_machine import Demand, Peaks, demands
from relight_core.evaluation.bench_report import BenchResult, Row, as_full_record, as_markdown, plot
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
    setting = Configuration(name, SMALL, name.split()[-1], is_tier)
    return Row(setting, timing, accuracy, {"compose": Demand(1.0, 2.0)})


def page(*rows, **machine):
    return as_markdown(BenchResult(MACHINE | machine, Peaks({"fp32": 50.0}, 8.0), list(rows))).splitlines()


def test_a_page_has_a_star_at_what_nothing_beats_and_tiers_in_bold():
    lines = page(row("draft", 1.0, 0.2), row("slow draft", 2.0, 0.25, is_tier=False), row("live", 3.0, 0.1))
    assert lines[0] == "A chip, 1 thread of 2 cores; torch 2.0 on cpu, Linux"
    assert "| | de-light | rotation | slider | RMSE | PSNR | against final | MiB |" in lines
    assert "| network | GFLOP | MB | least ms | measured ms |" in lines
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


def test_every_stage_has_a_column_though_some_settings_leave_it_out():
    with_network = row("live", 3.0, 0.1)
    timing = replace(with_network.timing, stages={"light": Spread(4.0, 5.0), "compose": Spread(6.0, 7.0)})
    lines = page(row("draft", 1.0, 0.2), replace(with_network, timing=timing))
    at = lines.index("| stage, ms | compose | light |")
    assert lines[at + 2 : at + 4] == ["| draft | 2.0 (3.0) | – |", "| live | 6.0 (7.0) | 4.0 (5.0) |"]


def test_a_variant_is_recorded_with_its_tier_and_what_its_own_precision_takes_at_least():
    variant = row("slow draft", 2.0, 0.123456, is_tier=False)
    result = BenchResult(MACHINE, Peaks({"fp32": 50.0, "bf16": 200.0}, 8.0), [variant])
    record = as_full_record(result)
    assert record["machine"] == MACHINE | {"peak_gflops": {"fp32": 50.0, "bf16": 200.0}, "peak_bandwidth_gb_s": 8.0}
    (entry,) = record["configurations"]
    assert (entry["name"], entry["tier"], entry["memory_mib"]) == ("slow draft", "draft", None)
    assert entry["error"] == {"rmse": 0.12346, "psnr": 20.0, "against_final": 0.0125}
    # 1 GFLOP at 200 a second, which is slower than 2 MB at 8 GB a second.
    assert entry["networks"] == {"compose": {"gflop": 1.0, "megabytes": 2.0, "least_ms": 5.0}}
    tier = replace(variant, configuration=Configuration("draft", SMALL, "draft", True))
    assert "| draft: compose | 1.00 | 2.0 | 5.0 | 2.0 (3.0) |" in as_markdown(replace(result, rows=[tier]))


@pytest.fixture
def plotted(monkeypatch):
    """Plots a result, and gives its title and its axes."""
    pytest.importorskip("matplotlib", reason="plots need the training extra")
    from matplotlib.figure import Figure

    figures = []
    monkeypatch.setattr(Figure, "savefig", lambda figure, *_, **__: figures.append(figure))

    def draw(*rows, **machine):
        plot(BenchResult(MACHINE | machine, Peaks({"fp32": 50.0}, 8.0), list(rows)), "bench.png")
        return figures[-1].get_suptitle(), figures[-1].axes

    return draw


@pytest.mark.parametrize(("load", "busy"), [(None, ""), (0.5, ", load 0.5")])
def test_a_plot_is_of_a_machine_and_says_how_busy_it_was_where_that_is_known(plotted, load, busy):
    title, _ = plotted(row("draft", 1.0, 0.2), load_average=load)
    assert title == f"A chip, 1 thread{busy}"


def test_a_plot_has_every_setting_where_its_times_and_errors_are_and_the_front_drawn(plotted):
    rows = [row("live", 3.0, 0.1), row("slow draft", 2.0, 0.25, is_tier=False), row("draft", 1.0, 0.2)]
    rows = [replace(one, accuracy=replace(one.accuracy, against_final=0.5 - one.accuracy.rmse)) for one in rows]
    _, (truth, final) = plotted(*rows)
    assert truth.get_xlabel() == "milliseconds from a turned light to the picture, median"
    assert truth.get_ylabel() == "RMSE against the truth, sRGB"
    assert final.get_ylabel() == "RMSE against the final tier, sRGB"
    assert truth.lines[0].get_xydata().tolist() == [[1.0, 0.2], [3.0, 0.1]]
    for axes, errors in ((truth, (0.1, 0.25, 0.2)), (final, (0.4, 0.25, 0.3))):
        points = {tuple(dots.get_offsets()[0]): dots for dots in axes.collections}
        labels = {text.get_text(): text.xy for text in axes.texts}
        colours = {}
        for one, error in zip(rows, errors, strict=True):
            name, at = one.configuration.name, (one.timing.actions["rotation"].median, pytest.approx(error))
            (dots,) = [dots for point, dots in points.items() if point == at]
            colours[name] = tuple(dots.get_facecolor()[0])
            # Beside its point, and so near in height that no other is nearer.
            assert labels[name][0] == pytest.approx(at[0], abs=0.1)
            assert labels[name][1] == pytest.approx(error, abs=0.02)
            assert axes.get_xlim()[0] <= at[0] < axes.get_xlim()[1]
            assert axes.get_ylim()[0] < error < axes.get_ylim()[1]
        beaten = {"slow draft"} if axes is truth else {"live"}
        assert {name for name in colours if colours[name] != colours["draft"]} == beaten


def test_labels_of_settings_that_are_alike_are_drawn_below_each_other(plotted):
    _, (axes, _) = plotted(
        *(row(f"{number} draft", 2.0, 0.2, is_tier=False) for number in range(4)), row("live", 2.0, 0.1)
    )
    heights = sorted(text.xy[1] for text in axes.texts)
    assert min(upper - lower for lower, upper in zip(heights, heights[1:], strict=False)) > 0.004
    assert axes.get_ylim()[0] < heights[0]


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
    times = {"ms": 500.0, "ms_of_everything": 2000.0}
    savings = Savings(2, 8, 2, **times, largest_error=0.02, largest_bound=0.03, compared=2)
    for bound, saved_ms, error in ((0.01, 20.0, 0.004), (0.03, 30.0, 0.001), (0.02, None, None)):
        savings.note_rules(left_out(bound, saved_ms), error)
    lines = session_words(savings).splitlines()
    assert lines[0] == "2 updates: 25.0 % of 8 stage runs avoided;"
    assert lines[1] == "0.5 s, against 2.0 s if every stage ran every time (25.0 %);"
    assert lines[2] == "largest error 5.10 / 255 over 2 pictures compared, largest bound given 7.65 / 255."
    assert lines[4] == "| effect | | because | times | saved, s | bound / 255 | compared | largest error / 255 |"
    assert lines[-2:] == [
        "| detail | reused | the same | 3 | 0.00 | – | 2 | 1.02 |",
        "| relief | skipped | flat | 3 | 0.05 | 7.65 | 2 | 1.02 |",
    ]
    record = savings.as_record()
    assert (record["share_avoided"], record["share_of_time"]) == (0.25, 0.25)
    assert (record["ms"], record["ms_of_everything"]) == (500.0, 2000.0)
    assert (record["largest_error"], record["largest_bound"]) == (0.02, 0.03)
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


def test_one_of_each_is_told_as_one():
    lines = session_words(Savings(updates=1, runs=1, avoided=1, compared=1)).splitlines()
    assert lines[0] == "1 update: 100.0 % of 1 stage run avoided;"
    assert " over 1 picture compared, " in lines[2]
