"""Stage results kept under what they were made from, with a record of what ran and why."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import Any, Literal

State = Literal["computed", "reused", "skipped"]


@dataclass(frozen=True)
class Stage:
    """What became of one stage in the last update.

    Attributes:
        ms: wall-clock milliseconds spent in this update.
        state: computed now, reused from an earlier update, or skipped as needless.
        why: the reason in words.
    """

    ms: float
    state: State
    why: str


@dataclass
class StageCache:
    """Keeps the newest results of every stage, each under the key it belongs to.

    A key names everything the stage reads: fields of the edit, the light, the keys of the stages before.
    """

    _kept: dict[str, OrderedDict[Hashable, Any]] = field(default_factory=dict)
    stages: dict[str, Stage] = field(default_factory=dict)

    def begin_update(self) -> None:
        """Forget the last update's record; results stay."""
        self.stages = {}

    def run(self, name: str, key: Hashable, make: Callable[[], Any], why: str, keep: int = 1) -> Any:
        """The stage's result for this key, made by `make` unless it is kept.

        Args:
            why: the reason for running, for the record.
            keep: how many results of this stage stay; more than one only where they are small and an
                editor goes back and forth between them.
        """
        kept = self._kept.setdefault(name, OrderedDict())
        if key in kept:
            kept.move_to_end(key)
            self.stages.setdefault(name, Stage(0.0, "reused", "nothing it reads has changed"))
            return kept[key]
        started = time.perf_counter()
        result = make()
        self.stages[name] = Stage((time.perf_counter() - started) * 1e3, "computed", why)
        kept[key] = result
        while len(kept) > keep:
            kept.popitem(last=False)
        return result

    def skip(self, name: str, why: str) -> None:
        """Record that a stage was not needed."""
        self.stages[name] = Stage(0.0, "skipped", why)
