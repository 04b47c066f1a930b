"""Stage results kept under what they were made from, with a record of what ran and why."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable, Collection, Hashable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

State = Literal["computed", "reused", "skipped"]


@dataclass(frozen=True)
class Stage:
    """What became of one stage in the last update.

    Attributes:
        ms: wall-clock milliseconds spent in this update, all of its runs together, stages that it started not counted.
        state: computed now, reused from an earlier update, or skipped as needless.
        why: the reason in words.
        start_ms: when it first began, from the beginning of the update.
        is_of_photo: neither a light nor an edit makes it run again.
    """

    ms: float
    state: State
    why: str
    start_ms: float = 0.0
    is_of_photo: bool = False


def computed_ms(stages: Mapping[str, Stage]) -> float:
    """Milliseconds of all that was computed, together."""
    return sum(stage.ms for stage in stages.values() if stage.state == "computed")


@dataclass
class Record:
    """What became of the stages; caches that work on one picture share one.

    Attributes:
        stages: of the last update, in the order in which they ended.
        typical_ms: what each stage took when it last ran, in whatever update.
        began: when the update began, as of time.perf_counter.
        nested_ms: spent in stages that the running one started.
        ended: when each stage was last computed, as of time.perf_counter.
    """

    stages: dict[str, Stage] = field(default_factory=dict)
    typical_ms: dict[str, float] = field(default_factory=dict)
    began: float = field(default_factory=time.perf_counter)
    nested_ms: float = 0.0
    ended: dict[str, float] = field(default_factory=dict)

    def begin_update(self) -> None:
        """Forget the last update's stages."""
        self.stages = {}
        self.began = time.perf_counter()

    def last_end(self, names: Collection[str]) -> float | None:
        """When the last of these stages was computed, as of time.perf_counter; None if none ever was."""
        return max((end for name, end in self.ended.items() if name in names), default=None)


@dataclass
class StageCache:
    """Keeps the newest results of every stage, each under the key it belongs to.

    A key names everything the stage reads: fields of the edit, the light, the keys of the stages before.

    Attributes:
        record: what the stages did; outlives results.
    """

    record: Record = field(default_factory=Record)
    _kept: dict[str, OrderedDict[Hashable, Any]] = field(default_factory=dict)
    _of_photo: set[str] = field(default_factory=set)

    def clear(self) -> None:
        """Forget all results."""
        self._kept.clear()

    def forget(self, name: str) -> None:
        """Forget one stage's results."""
        self._kept.pop(name, None)

    def forget_lights(self) -> None:
        """Forget what came with a light or an edit: all stages but those `of_photo`."""
        self.keep_only(self._of_photo)

    def keep_only(self, names: Collection[str]) -> None:
        """Forget the results of all other stages."""
        for name in self._kept.keys() - set(names):
            del self._kept[name]

    def has(self, name: str, key: Hashable) -> bool:
        """Whether `run` would reuse."""
        return key in self._kept.get(name, ())

    def run(self, name: str, key: Hashable, make: Callable[[], Any], why: str, keep: int = 1) -> Any:
        """The stage's result for this key, made by `make` unless it is kept.

        Args:
            why: the reason for running, for the record.
            keep: how many results of this stage stay; more than one only where they are small and an
                editor goes back and forth between them.
        """
        kept = self._kept.setdefault(name, OrderedDict())
        started = time.perf_counter()
        start_ms = (started - self.record.began) * 1e3
        if key in kept:
            kept.move_to_end(key)
            self.record.stages.setdefault(name, Stage(0.0, "reused", "nothing it reads has changed", start_ms))
            return kept[key]
        outside, self.record.nested_ms = self.record.nested_ms, 0.0
        result = make()
        whole_ms = (time.perf_counter() - started) * 1e3
        own_ms = max(whole_ms - self.record.nested_ms, 0.0)
        self.record.nested_ms = outside + whole_ms
        self.record.typical_ms[name] = own_ms
        self.record.ended[name] = time.perf_counter()
        before = self.record.stages.get(name)
        if before is not None and before.state == "computed":
            # For another key, as a face that is taken apart at two qualities: it took the time of both.
            own_ms, start_ms = before.ms + own_ms, before.start_ms
        self.record.stages[name] = Stage(own_ms, "computed", why, start_ms, name in self._of_photo)
        kept[key] = result
        while len(kept) > keep:
            kept.popitem(last=False)
        return result

    def of_photo(self, name: str, key: Hashable, make: Callable[[], Any], why: str = "new photo", keep: int = 1) -> Any:
        """`run` for a stage that reads neither light nor edit, so that its results outlast them."""
        self._of_photo.add(name)
        return self.run(name, key, make, why, keep)

    def skip(self, name: str, why: str) -> None:
        """Record that a stage was not needed."""
        self.record.stages[name] = Stage(0.0, "skipped", why, (time.perf_counter() - self.record.began) * 1e3)
