"""The stability report as a heat map."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from relight_core.evaluation.stability import BOUNDS, StabilityReport

_CALM = 1e-4


def plot_stability(report: StabilityReport, path: Path) -> None:
    """Cases by checks, each error as a share of its bound on a logarithmic scale, into a PNG."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.colors import LogNorm
    from matplotlib.figure import Figure

    bounds = np.array([BOUNDS[check] for check in report.checks])
    # A bound of 0 allows nothing: what is above it counts as ten times too much.
    shares = np.where(bounds > 0, report.errors / np.where(bounds > 0, bounds, 1), (report.errors > 0) * 10.0)
    figure = Figure(figsize=(2.5 + 1.1 * len(report.checks), 1.5 + 0.24 * len(report.cases)), layout="constrained")
    axes = figure.add_subplot()
    image = axes.imshow(np.maximum(shares, _CALM), norm=LogNorm(_CALM, 10), cmap="RdYlGn_r", aspect="auto")
    axes.set_xticks(range(len(report.checks)), report.checks, rotation=30, ha="right")
    axes.set_yticks(range(len(report.cases)), report.cases, fontsize=7)
    for (row, column), error in np.ndenumerate(report.errors):
        axes.text(column, row, "–" if np.isnan(error) else f"{error:.1g}", ha="center", va="center", fontsize=6)
    figure.colorbar(image, label="error over its bound")
    FigureCanvasAgg(figure).print_png(str(path))
