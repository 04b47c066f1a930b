"""Outcomes of a contest as an object for programs and as tables of Markdown for people."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from relight_core.evaluation.contest import Outcome
from relight_core.evaluation.counted import counted
from relight_core.evaluation.report import figures_record, interval_text, intervals_in_words
from relight_core.evaluation.tables import figure_text, markdown_table

Columns = Mapping[str, str]

RELIT: Columns = {
    "relit.rmse": "relit RMSE",
    "relit.psnr": "PSNR",
    "relit.ssim": "SSIM",
    "relit.rmse_aligned": "RMSE, one exposure",
    "relit.psnr_aligned": "PSNR, one exposure",
}

CHANNELS: Columns = {
    "albedo.rmse": "albedo RMSE",
    "albedo.rmse_aligned": "albedo, one exposure",
    "normal.rmse": "normal RMSE",
    "specular.rmse": "specular RMSE",
    "shadow.rmse": "shadow RMSE",
    "shadow.relative": "shadow over its RMS",
    "light.wlog_l2": "light wlog-L2",
}

BORROWED: Columns = {
    "borrowed.wlog_l2": "estimated light, wlog-L2",
    "borrowed.rmse": "relit RMSE with it",
    "relit.rmse": "with the true light",
}


def as_record(outcome: Outcome, training: str) -> dict:
    """One JSON-ready object: for each contender the means and 95 % intervals, and how all were trained."""
    contest = outcome.contest
    return {
        "rows": {name: figures_record(figures) for name, figures in outcome.figures.items()},
        "samples": outcome.samples,
        "heads": outcome.heads,
        "split": contest.split,
        "size": contest.size,
        "training": training,
    }


def table(outcome: Outcome, columns: Columns) -> list[str]:
    """Lines of Markdown: a row for each contender that has one of the columns, a dash for what it has not."""
    rows = [
        [name, *(interval_text(figures.get(column)) or "–" for column in columns)]
        for name, figures in outcome.figures.items()
        if any(column in figures for column in columns)
    ]
    return markdown_table(["", *columns.values()], rows)


def paper_table(title: str, columns: Sequence[str], rows: Mapping[str, Sequence[float | None]]) -> list[str]:
    """The paper's own figures, for the order of their size."""
    cells = [[name, *(figure_text(value, "g") for value in values)] for name, values in rows.items()]
    return ["", f"{title}:", "", *markdown_table(["", *columns], cells)]


def heading(title: str, outcome: Outcome, training: str) -> list[str]:
    """A title and what was measured."""
    contest = outcome.contest
    return [
        f"# {title}",
        "",
        f"{contest.split} split: {counted(outcome.heads, 'head')}, {counted(outcome.samples, 'relighting')} "
        f"under panoramas at {contest.size} x {contest.size} pixels, clean photos, over all of the head. {training} "
        f"{intervals_in_words(outcome.heads)}",
        "",
    ]
