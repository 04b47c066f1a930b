"""A bench as an object for programs, a page of Markdown and a plot."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path

from relight_core.evaluation.bench_accuracy import Accuracy
from relight_core.evaluation.bench_configurations import Configuration
from relight_core.evaluation.bench_machine import Demand, Peaks
from relight_core.evaluation.bench_timing import ACTIONS, Spread, Timing
from relight_core.evaluation.counted import counted
from relight_core.evaluation.tables import figure_text, markdown_table

_BEST, _BEATEN = "#c8842c", "#b0b0b0"


@dataclass(frozen=True)
class Row:
    """One configuration with all that was measured of it."""

    configuration: Configuration
    timing: Timing
    accuracy: Accuracy
    demands: dict[str, Demand]


@dataclass(frozen=True)
class BenchResult:
    """A whole bench; `machine` is JSON-ready."""

    machine: dict
    peaks: Peaks
    rows: list[Row]


def as_record(result: BenchResult) -> dict:
    """{"machine", "configurations": [{"name", "tier", "ms", "error", "memory_mib"}]}, JSON-ready."""
    return {
        "machine": result.machine
        | {"peak_gflops": _rounded(result.peaks.gflops)}
        | {"peak_bandwidth_gb_s": round(result.peaks.bandwidth_gb_s, 1)},
        "configurations": [
            {
                "name": row.configuration.name,
                "tier": row.configuration.tier_name,
                "ms": {name: _rounded(asdict(row.timing.actions[name])) for name in ACTIONS},
                "error": _rounded(asdict(row.accuracy), 5),
                "memory_mib": None if row.timing.memory_mib is None else round(row.timing.memory_mib, 1),
            }
            for row in result.rows
        ],
    }


def as_full_record(result: BenchResult) -> dict:
    """`as_record` with every stage's milliseconds, the settings, and what the networks ask of the machine."""
    record = as_record(result)
    for entry, row in zip(record["configurations"], result.rows, strict=True):
        entry["settings"] = asdict(row.configuration.tier)
        entry["stages"] = {name: _rounded(asdict(spread)) for name, spread in row.timing.stages.items()}
        entry["networks"] = {
            name: {
                "gflop": round(demand.gflop, 3),
                "megabytes": round(demand.megabytes, 2),
                "least_ms": round(demand.least_ms(result.peaks, row.configuration.tier.precision), 2),
            }
            for name, demand in row.demands.items()
        }
    return record


def pareto(points: list[tuple[float, float]]) -> list[bool]:
    """Which of (milliseconds, error) no other beats in one without losing in the other."""
    return [
        not any(other[0] <= point[0] and other[1] <= point[1] and other != point for other in points)
        for point in points
    ]


def as_markdown(result: BenchResult) -> str:
    """Tables of the actions, the stages and the limits."""
    machine = result.machine
    lines = [
        f"{machine['processor']}, {counted(machine['threads'], 'thread')} of {machine['cores']} cores{_load(machine)}; "
        f"torch {machine['torch']} on {machine['device']}, {machine['system']}",
        *_start(machine),
        "",
        *_actions(result),
        "",
        *_stages(result),
        "",
        *_limits(result),
    ]
    return "\n".join(lines) + "\n"


def _load(machine: dict) -> str:
    load = machine.get("load_average")
    return "" if load is None else f", load {load}"


def _start(machine: dict) -> list[str]:
    seconds = machine.get("first_picture_s")
    return [] if seconds is None else ["", f"From the start of the program to a relit picture in a file: {seconds} s."]


def _actions(result: BenchResult) -> list[str]:
    kinds = _measured_errors(result.rows)
    best = [True] * len(result.rows)
    if kinds:
        best = pareto([(_rotation(row), error) for row, error in zip(result.rows, kinds[0][1], strict=True)])
    note = "Milliseconds, median (95th percentile); * is on the Pareto front of rotation against error."
    titles = ("", "de-light", "rotation", "slider", "RMSE", "PSNR", "against final", "MiB")
    rows = []
    for row, front in zip(result.rows, best, strict=True):
        name = f"**{row.configuration.name}**" if row.configuration.is_tier else row.configuration.name
        times = [_ms(row.timing.actions[name]) for name in ACTIONS]
        errors = ((row.accuracy.rmse, ".4f"), (row.accuracy.psnr, ".1f"), (row.accuracy.against_final, ".4f"))
        figures = [figure_text(*figure) for figure in (*errors, (row.timing.memory_mib, ".0f"))]
        rows.append([name + " *" * front, *times, *figures])
    return [note, "", *markdown_table(titles, rows)]


def _stages(result: BenchResult) -> list[str]:
    names = list(dict.fromkeys(name for row in result.rows for name in row.timing.stages))
    rows = [[row.configuration.name, *(_ms(row.timing.stages.get(name)) for name in names)] for row in result.rows]
    return markdown_table(["stage, ms", *names], rows)


def _limits(result: BenchResult) -> list[str]:
    """What the networks would take at the machine's measured peak."""
    peaks = ", ".join(f"{value:.0f} GFLOP/s in {name}" for name, value in result.peaks.gflops.items())
    rows = []
    for row in result.rows:
        if not row.configuration.is_tier:
            continue
        for name, demand in row.demands.items():
            least_ms = demand.least_ms(result.peaks, row.configuration.tier.precision)
            figures = (f"{demand.gflop:.2f}", f"{demand.megabytes:.1f}", f"{least_ms:.1f}")
            rows.append([f"{row.configuration.name}: {name}", *figures, _ms(row.timing.stages.get(name))])
    note = f"Measured peaks: {peaks}, {result.peaks.bandwidth_gb_s:.1f} GB/s."
    return [note, "", *markdown_table(("network", "GFLOP", "MB", "least ms", "measured ms"), rows)]


def plot(result: BenchResult, path: Path) -> None:
    """Errors against milliseconds of a turn of the light, the Pareto front drawn, what it beats in grey. PNG."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    kinds = _measured_errors(result.rows)
    figure, places = pyplot.subplots(
        1, max(len(kinds), 1), figsize=(8 * max(len(kinds), 1), 5.5), constrained_layout=True, squeeze=False
    )
    for axes, (title, errors) in zip(places[0], kinds, strict=False):
        _scatter(axes, result.rows, errors)
        axes.set(xlabel="milliseconds from a turned light to the picture, median", ylabel=title)
    machine = result.machine
    words = f"{machine['processor']}, {counted(machine['threads'], 'thread')}{_load(machine)}"
    figure.suptitle(words, fontsize=9)
    figure.savefig(path, dpi=120, format="png")
    pyplot.close(figure)


def _scatter(axes, rows: list[Row], errors: list[float]) -> None:
    points = [(_rotation(row), error) for row, error in zip(rows, errors, strict=True)]
    front = pareto(points)
    line = sorted(point for point, best in zip(points, front, strict=True) if best)
    axes.plot(*zip(*line, strict=True), color=_BEST, linewidth=1.5, zorder=1)
    low, high = min(errors), max(errors)
    span = max(high - low, 1e-4)
    rightmost = max(ms for ms, _ in points)
    axes.set_xlim(0, 1.35 * rightmost)
    axes.grid(alpha=0.25)
    taken: list[tuple[float, float]] = []
    for row, point, best in sorted(zip(rows, points, front, strict=True), key=lambda entry: -entry[1][1]):
        marker, size = ("s", 55) if row.configuration.is_tier else ("o", 30)
        axes.scatter(*point, color=_BEST if best else _BEATEN, marker=marker, s=size, zorder=2)
        height = _free_height(point, taken, 0.35 * rightmost, 0.045 * span)
        taken.append((point[0], height))
        place = (point[0] + 0.015 * rightmost, height)
        if height != point[1]:
            axes.plot(*zip(point, place, strict=True), color="#d8d8d8", linewidth=0.6, zorder=0)
        axes.annotate(row.configuration.name, place, fontsize=8, color="#303030" if best else "#808080", va="center")
    axes.set_ylim(min(low, *(y for _, y in taken)) - 0.1 * span, high + 0.1 * span)


def _free_height(point: tuple[float, float], taken: list[tuple[float, float]], width: float, line: float) -> float:
    """Where a label beside the point meets none that is placed already: at its height or below."""
    height = point[1]
    for _ in range(len(taken) + 1):
        near = [y for x, y in taken if abs(x - point[0]) < width and abs(y - height) < 0.99 * line]
        if not near:
            break
        height = min(near) - line
    return height


def _measured_errors(rows: list[Row]) -> list[tuple[str, list[float]]]:
    """Every kind of error that was measured for all rows, with its title."""
    kinds = (
        ("RMSE against the truth, sRGB", [row.accuracy.rmse for row in rows]),
        ("RMSE against the final tier, sRGB", [row.accuracy.against_final for row in rows]),
    )
    return [(title, values) for title, values in kinds if all(value is not None for value in values)]


def _rotation(row: Row) -> float:
    return row.timing.actions["rotation"].median


def _ms(spread: Spread | None) -> str:
    return "–" if spread is None else f"{spread.median:.1f} ({spread.p95:.1f})"


def _rounded(numbers: dict, digits: int = 2) -> dict:
    return {name: None if value is None else round(float(value), digits) for name, value in numbers.items()}
