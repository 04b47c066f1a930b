"""The stability report as a heat map."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from relight_core.evaluation.stability import BOUNDS, StabilityReport
from relight_core.evaluation.tables import figure_text

_CALM, _FAR = 1e-4, 10.0


def plot_stability(report: StabilityReport, path: Path) -> None:
    """Cases by checks, each error as a share of its bound on a logarithmic scale, into a PNG.

    Yellow is at the bound, red above it; what was not checked stays white.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.colors import TwoSlopeNorm
    from matplotlib.figure import Figure

    bounds = np.array([BOUNDS[check] for check in report.checks])
    # A bound of 0 allows nothing: what is above it counts as far too much.
    shares = np.where(bounds > 0, report.errors / np.where(bounds > 0, bounds, 1), (report.errors > 0) * _FAR)
    shares = np.where(np.isnan(report.errors), np.nan, np.clip(shares, _CALM, _FAR))
    figure = Figure(figsize=(2.5 + 1.1 * len(report.checks), 1.5 + 0.24 * len(report.cases)), layout="constrained")
    axes = figure.add_subplot()
    norm = TwoSlopeNorm(0.0, np.log10(_CALM), np.log10(_FAR))
    image = axes.imshow(np.log10(shares), norm=norm, cmap="RdYlGn_r", aspect="auto")
    axes.set_xticks(range(len(report.checks)), report.checks, rotation=30, ha="right")
    axes.set_yticks(range(len(report.cases)), report.cases, fontsize=7)
    for (row, column), error in np.ndenumerate(report.errors):
        axes.text(column, row, figure_text(error, ".1g"), ha="center", va="center", fontsize=6)
    ticks = np.arange(np.log10(_CALM), np.log10(_FAR) + 1)
    figure.colorbar(image, label="error over its bound", ticks=ticks).ax.set_yticklabels([f"{10**t:g}" for t in ticks])
    FigureCanvasAgg(figure).print_png(str(path))
