"""The stability report: nothing is above its bound, and it would say so if something were."""

import numpy as np

from relight_core.evaluation.stability import BOUNDS, StabilityReport, run_stability
from relight_core.evaluation.stability_plot import plot_stability
from relight_core.imaging.read import read_photo


def some_report(error):
    errors = np.zeros((2, len(BOUNDS)))
    errors[1, list(BOUNDS).index("full turn")] = error
    errors[0, 0] = np.nan
    return StabilityReport(("calm, even", "wild, sun"), tuple(BOUNDS), errors)


def test_the_shipped_networks_stay_within_every_bound(portrait):
    done = []
    report = run_stability(portrait, quick=True, report=lambda n, total: done.append((n, total)))
    assert report.failures == []
    assert report.errors.shape == (4, 10)
    threads = report.checks.index("threads")
    assert np.isfinite(np.delete(report.errors, threads, axis=1)).all()
    assert np.isfinite(report.errors[0, threads])
    assert done[-1] == (4, 4)


def test_an_error_above_its_bound_is_named():
    assert some_report(1e-9).failures == []
    (line,) = some_report(0.5).failures
    assert "wild, sun" in line
    assert "full turn" in line


def test_record_table_and_picture(tmp_path):
    report = some_report(0.5)
    record = report.as_record()
    assert record["cases"]["calm, even"]["not finite"] is None
    assert record["cases"]["wild, sun"]["full turn"] == 0.5
    assert report.as_markdown().count("\n") == 5
    plot_stability(report, tmp_path / "a.png")
    assert read_photo(tmp_path / "a.png").linear.std() > 0.05
