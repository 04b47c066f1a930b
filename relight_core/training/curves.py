"""Loss curves as a picture."""

from __future__ import annotations

import json
from pathlib import Path

from relight_core.errors import InputError
from relight_core.imaging.files import file_bytes, whole_file


def draw_curves(log: Path, picture: Path) -> None:
    """Draw the log that `loop.train_stage` leaves beside its checkpoint, one panel for each loss.

    Args:
        log: JSON list of {"step", "elapsed", loss: value, ...}.
        picture: a .png, written whole or not at all.

    Raises:
        InputError: the log can't be read, or holds nothing.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    try:
        rows = json.loads(file_bytes(log).decode("utf-8"))
        names = [name for name in rows[0] if name not in ("step", "elapsed")] if rows else []
        steps = [float(row["step"]) for row in rows]
        curves = {name: [float(row.get(name, "nan")) for row in rows] for name in names}
    except InputError:
        raise
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(f"{log}: not a log of losses ({error}); train again") from error
    if not names:
        raise InputError(f"{log}: holds no losses; train again")
    figure = Figure(figsize=(7, 2.2 * len(names)), layout="constrained")
    FigureCanvasAgg(figure)
    for place, (name, values) in enumerate(curves.items(), 1):
        axes = figure.add_subplot(len(names), 1, place)
        axes.plot(steps, values, linewidth=1, marker="." if len(rows) == 1 else None)  # No line leads to one point.
        axes.set_title(name.replace("_", " "), loc="left", fontsize=9)
        axes.set_yscale("log")
        axes.grid(alpha=0.3)
    axes.set_xlabel("step")
    with whole_file(picture) as partial:
        figure.savefig(partial, format="png", dpi=100)
