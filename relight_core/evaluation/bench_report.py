"""A bench as an object for programs, a page of Markdown and a plot."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path

from relight_core.evaluation.bench_accuracy import Accuracy
from relight_core.evaluation.bench_configurations import Configuration
from relight_core.evaluation.bench_machine import Demand, Peaks
from relight_core.evaluation.bench_timing import ACTIONS, Spread, Timing


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


def errors_of(rows: list[Row]) -> tuple[str, list[float]] | None:
    """The error to rank by: against the truth where it was measured, else against the final tier."""
    for title, values in (
        ("RMSE against the truth, sRGB", [row.accuracy.rmse for row in rows]),
        ("RMSE against the final tier, sRGB", [row.accuracy.against_final for row in rows]),
    ):
        if all(value is not None for value in values):
            return title, values
    return None


def as_markdown(result: BenchResult) -> str:
    """Tables of the actions, the stages and the limits."""
    machine = result.machine
    load = f", load {machine['load_average']}" if machine.get("load_average") is not None else ""
    lines = [
        f"{machine['processor']}, {machine['threads']} threads of {machine['cores']} cores{load}; "
        f"torch {machine['torch']} on {machine['device']}, {machine['system']}",
        "",
        *_actions(result),
        "",
        *_stages(result),
        "",
        *_limits(result),
    ]
    return "\n".join(lines) + "\n"


def _actions(result: BenchResult) -> list[str]:
    ranking = errors_of(result.rows)
    best = [True] * len(result.rows)
    if ranking is not None:
        best = pareto([(_rotation(row), e) for row, e in zip(result.rows, ranking[1], strict=True)])
    table = ["Milliseconds, median (95th percentile); * is on the Pareto front of rotation against error.", ""]
    table += [
        "| | de-light | rotation | slider | RMSE | PSNR | against final | MiB |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row, front in zip(result.rows, best, strict=True):
        accuracy = row.accuracy
        cells = [_ms(row.timing.actions[name]) for name in ACTIONS]
        cells += [_number(accuracy.rmse, 4), _number(accuracy.psnr, 1), _number(accuracy.against_final, 4)]
        cells.append(_number(row.timing.memory_mib, 0))
        name = f"**{row.configuration.name}**" if row.configuration.is_tier else row.configuration.name
        table.append(f"| {name}{' *' if front else ''} | {' | '.join(cells)} |")
    return table


def _stages(result: BenchResult) -> list[str]:
    names = list(dict.fromkeys(name for row in result.rows for name in row.timing.stages))
    table = ["| stage, ms | " + " | ".join(names) + " |", "|---|" + "---|" * len(names)]
    for row in result.rows:
        cells = [_ms(row.timing.stages[name]) if name in row.timing.stages else "–" for name in names]
        table.append(f"| {row.configuration.name} | {' | '.join(cells)} |")
    return table


def _limits(result: BenchResult) -> list[str]:
    """What the networks would take at the machine's measured peak."""
    peaks = ", ".join(f"{value:.0f} GFLOP/s in {name}" for name, value in result.peaks.gflops.items())
    table = [f"Measured peaks: {peaks}, {result.peaks.bandwidth_gb_s:.1f} GB/s.", ""]
    table += ["| network | GFLOP | MB | least ms | measured ms |", "|---|---|---|---|---|"]
    for row in result.rows:
        if not row.configuration.is_tier:
            continue
        for name, demand in row.demands.items():
            least = demand.least_ms(result.peaks, row.configuration.tier.precision)
            measured = _ms(row.timing.stages[name]) if name in row.timing.stages else "–"
            table.append(
                f"| {row.configuration.name}: {name} | {demand.gflop:.2f} | {demand.megabytes:.1f} "
                f"| {least:.1f} | {measured} |"
            )
    return table


def plot(result: BenchResult, path: Path) -> None:
    """Error against milliseconds of a turn of the light, the Pareto front drawn, what it beats in grey."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    title, errors = errors_of(result.rows) or ("", [0.0] * len(result.rows))
    points = [(_rotation(row), error) for row, error in zip(result.rows, errors, strict=True)]
    front = pareto(points)
    figure, axes = pyplot.subplots(figsize=(9, 5.5), constrained_layout=True)
    line = sorted(point for point, best in zip(points, front, strict=True) if best)
    axes.plot(*zip(*line, strict=True), color="#c8842c", linewidth=1.5, zorder=1)
    for row, point, best in zip(result.rows, points, front, strict=True):
        colour = "#c8842c" if best else "#b0b0b0"
        marker = "s" if row.configuration.is_tier else "o"
        axes.scatter(*point, color=colour, marker=marker, s=55 if row.configuration.is_tier else 30, zorder=2)
    _label(axes, result.rows, points, front)
    axes.set(xlabel="milliseconds from a turned light to the picture, median", ylabel=title)
    axes.set_title(f"{result.machine['processor']}, {result.machine['threads']} threads", fontsize=9)
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    axes.grid(alpha=0.25)
    figure.savefig(path, dpi=140, format="png")
    pyplot.close(figure)


def _label(axes, rows: list[Row], points: list[tuple[float, float]], front: list[bool]) -> None:
    """Names beside the points, from the top down, each moved down as far as the one above it asks."""
    top = max((error for _, error in points), default=0.0) or 1.0
    free: dict[int, float] = {}
    right = max(ms for ms, _ in points)
    for index in sorted(range(len(points)), key=lambda i: -points[i][1]):
        ms, error = points[index]
        column = int(4 * ms / right)
        height = min(error, free.get(column, 2 * top) - 0.04 * top)
        free[column] = height
        axes.annotate(
            rows[index].configuration.name,
            (ms, error),
            (ms + 0.012 * right, height),
            fontsize=8,
            color="#303030" if front[index] else "#909090",
            va="center",
            annotation_clip=False,
        )


def _rotation(row: Row) -> float:
    return row.timing.actions["rotation"].median


def _ms(spread: Spread) -> str:
    return f"{spread.median:.1f} ({spread.p95:.1f})"


def _number(value: float | None, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f}"


def _rounded(numbers: dict, digits: int = 2) -> dict:
    return {name: None if value is None else round(float(value), digits) for name, value in numbers.items()}
