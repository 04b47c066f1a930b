"""Tables of Markdown, and the figures in them."""

import pytest

from relight_core.evaluation.tables import figure_text, markdown_table


def test_a_table_has_its_titles_and_a_line_for_each_row():
    lines = markdown_table(["", "RMSE"], [["ours", "0.25"], ["theirs", ""]])
    assert lines == ["| | RMSE |", "|---|---|", "| ours | 0.25 |", "| theirs | |"]


@pytest.mark.parametrize(("figure", "text"), [(0.25, "0.2"), (0.0, "0.0"), (None, "–"), (float("nan"), "–")])
def test_a_figure_that_is_missing_is_a_dash(figure, text):
    assert figure_text(figure, ".1f") == text
