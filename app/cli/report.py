"""What a subcommand tells: lines for people, or one JSON object for programs."""

from __future__ import annotations

import contextlib
import ctypes
import json
import os
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from app.cli.streams import Heedless, flush_said, say, tell
from relight_core.errors import without_controls
from relight_core.pipeline.cache import computed_ms
from relight_core.pipeline.edit import Edit

if TYPE_CHECKING:
    from relight_core.pipeline.plan import Effect
    from relight_core.pipeline.results.relit import Relit


class Report:
    """Where a subcommand says what it did; each call is silent in the other mode."""

    def __init__(self, as_json: bool) -> None:
        self._as_json = as_json
        self._record: dict | None = None
        self._page: str | None = None

    def line(self, text: str) -> None:
        """Print a line for people, and one alone, whatever the names of files in it hold."""
        if not self._as_json:
            say(without_controls(text))

    def record(self, record: dict) -> None:
        """Keep the object for programs; it is printed when the command ends, be it because something fails later."""
        self._record = record

    def figures(self, page: str, record: dict) -> None:
        """Keep what was measured, for people and for programs, in place of what was; printed as `record` is."""
        self._page = page
        self.record(record)

    def kept(self) -> str | None:
        """What is left to print: the page, or the object as one line of ASCII; None when there is nothing."""
        if not self._as_json:
            return self._page
        return None if self._record is None else json.dumps(self._record, allow_nan=False)


@contextlib.contextmanager
def reporting(as_json: bool) -> Iterator[Report]:
    """A Report; with JSON, whatever else writes to stdout meanwhile, C libraries included, goes to stderr."""
    report = Report(as_json)
    try:
        with _stdout_to_stderr() if as_json else contextlib.nullcontext():
            yield report
    finally:
        text = report.kept()
        if text is not None:
            say(text)


@contextlib.contextmanager
def counting(title: str) -> Iterator[Callable[[int, int], None]]:
    """A line on stderr that tells how far work is, gone when it has ended; call the result with what is done, of all.

    Where stderr is no terminal nothing is told.
    """
    shown = sys.stderr.isatty()

    def step(done: int, count: int) -> None:
        if shown:
            tell(f"\r{title} {done} of {count}", end="")

    try:
        yield step
    finally:
        if shown:
            tell("\r\x1b[K", end="")


@contextlib.contextmanager
def _stdout_to_stderr() -> Iterator[None]:
    flush_said()
    kept = os.dup(1)
    os.dup2(2, 1)
    try:
        with contextlib.redirect_stdout(Heedless(sys.stderr)):
            yield
    finally:
        _flush_c_streams()
        os.dup2(kept, 1)
        os.close(kept)


def _flush_c_streams() -> None:
    """Push out what C code has printed but its library still holds, while stdout points elsewhere."""
    with contextlib.suppress(OSError, TypeError, AttributeError):
        ctypes.CDLL(None).fflush(None)


@dataclass(frozen=True)
class FileTimes:
    """What opening a photo and writing its result took.

    Attributes:
        opening_ms: of "read" and "find".
        write_ms: from the first band of rows to the file under its name; most of the picture is computed meanwhile.
        after_networks_ms: from the end of the last network to the file under its name.
    """

    opening_ms: dict[str, float]
    write_ms: float
    after_networks_ms: float


def relit_record(input_name: str, output_name: str, relit: Relit, times: FileTimes | None = None) -> dict:
    """What `--json` says of one relighting; `size` is [width, height], boxes and size in pixels."""
    height, width = relit.size
    record = {
        "input": input_name,
        "output": output_name,
        "size": [int(width), int(height)],
        "faces": [{"box": [round(float(edge), 2) for edge in (b.x0, b.y0, b.x1, b.y1)]} for b in relit.faces],
        "stages": {
            name: {"ms": round(float(stage.ms), 3), "state": stage.state, "why": stage.why}
            for name, stage in relit.stages.items()
        },
        "plan": [effect_record(effect) for effect in relit.plan],
    }
    if times is not None:
        opening = {name: _file_stage(ms, "new photo") for name, ms in times.opening_ms.items()}
        record["stages"] = opening | record["stages"] | {"write": _file_stage(times.write_ms, "new file")}
        record["after_networks_ms"] = round(times.after_networks_ms, 3)
    return record


def _file_stage(ms: float, why: str) -> dict:
    return {"ms": round(ms, 3), "state": "computed", "why": why}


def effect_record(effect: Effect) -> dict:
    """One effect of a plan; `bound` is of a displayed value in [0, 1], null where no rule answers for it."""
    return {
        "effect": effect.name,
        "state": effect.state,
        "why": effect.why,
        "bound": None if effect.bound is None else round(effect.bound, 6),
        "forced": effect.forced,
        "saved_ms": None if effect.saved_ms is None else round(effect.saved_ms, 3),
    }


def relit_line(output_name: str, relit: Relit, edit: Edit) -> str:
    """The same for people, in a line."""
    height, width = relit.size
    return f"wrote {output_name} ({width} x {height}, {edit.quality} quality, {computed_ms(relit.stages):.0f} ms)"
