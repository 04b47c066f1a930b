"""What the quality tiers cost on this machine, kept in the user's cache folder between runs."""

from __future__ import annotations

import hashlib
import json
import math
import os
import platform
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

from app.user_folders import cache_folder
from relight_core.errors import InputError
from relight_core.imaging.files import file_bytes, whole_file
from relight_core.pipeline.auto_quality import TierCost
from relight_core.pipeline.quality import TIERS

_VERSION = 1


def cache_path() -> Path:
    """The file, where this system keeps what can be made again; it may not exist yet."""
    return cache_folder() / "tiers.json"


def read_costs(path: Path, key: str) -> dict[str, TierCost] | None:
    """The costs kept under a key; None where there are none, or the file is damaged."""
    try:
        content = json.loads(file_bytes(path).decode("utf-8"))
        if content["version"] != _VERSION or content["key"] != key:
            return None
        tiers = content["tiers"].items()
        costs = {str(name): TierCost(float(cost["ms"]), float(cost["error"])) for name, cost in tiers}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError, OverflowError):
        return None
    sound = all(math.isfinite(cost.ms) and math.isfinite(cost.error) for cost in costs.values())
    return costs if sound and set(costs) == set(TIERS) else None


def write_costs(path: Path, key: str, costs: Mapping[str, TierCost]) -> None:
    """Keep costs; a folder that can't be written to keeps none, and they are measured again next time."""
    content = {"version": _VERSION, "key": key, "tiers": {name: asdict(cost) for name, cost in costs.items()}}
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(path) as partial:
            partial.write_text(json.dumps(content, indent=1), encoding="utf-8")
    except (OSError, InputError):
        return


def machine_key() -> str:
    """Names what the costs depend on: processor, threads, torch, the tiers and the weights."""
    import torch

    from relight_core.pipeline.relighter import WEIGHTS
    from relight_core.resources import resource_path

    weights = resource_path(*WEIGHTS).stat()
    machine = (platform.processor() or platform.machine(), os.cpu_count(), torch.get_num_threads())
    program = (torch.__version__, sorted(TIERS.items()), weights.st_size, weights.st_mtime_ns)
    return hashlib.sha256(repr((machine, program)).encode()).hexdigest()[:24]
