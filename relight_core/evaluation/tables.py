"""Tables of Markdown, and the figures in them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence


def markdown_table(titles: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Lines of a table; as many cells in each row as there are titles."""
    return [_line(titles), "|---" * len(titles) + "|", *(_line(row) for row in rows)]


def _line(cells: Sequence[str]) -> str:
    return "".join(f"| {cell} " if cell else "| " for cell in cells) + "|"


def figure_text(figure: float | None, form: str) -> str:
    """A figure in a form as of `format`, or a dash where there is none: None or NaN."""
    return "–" if figure is None or math.isnan(figure) else f"{figure:{form}}"
