"""What this machine is and could do at most, and what the networks ask of it."""

from __future__ import annotations

import contextlib
import os
import platform
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import torch
from torch.utils.flop_counter import FlopCounterMode

from relight_core import process_memory
from relight_core.networks.bundle import NetworkBundle
from relight_core.networks.lfm import LIGHT_SHAPE
from relight_core.networks.precision import has_bf16
from relight_core.pipeline.quality import Tier
from relight_core.pipeline.stages import in_precision

_MATRIX, _STREAM_MIB = 1024, 64
_SECONDS = 0.25


@dataclass(frozen=True)
class Peaks:
    """The best that was measured: arithmetic in GFLOP/s by precision, memory in GB/s."""

    gflops: dict[str, float]
    bandwidth_gb_s: float


@dataclass(frozen=True)
class Demand:
    """What one run of a network asks for: GFLOP, and MB moved if every layer's data passes memory once."""

    gflop: float
    megabytes: float

    def least_ms(self, peaks: Peaks, precision: str) -> float:
        """No run can be faster than the slower of its arithmetic and its traffic."""
        fastest = peaks.gflops.get(precision, peaks.gflops["fp32"])
        return 1e3 * max(self.gflop / fastest, self.megabytes / 1e3 / peaks.bandwidth_gb_s)


def load_average() -> float | None:
    """How many programs wanted a core in the last minute; None where the system does not tell, as Windows."""
    return round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None


def describe_machine(device: str = "cpu") -> dict:
    """Processor, cores, threads and versions, JSON-ready."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "threads": torch.get_num_threads(),
        "system": platform.platform(),
        "python": platform.python_version(),
        "torch": torch.__version__,
        "device": torch.cuda.get_device_name() if device == "cuda" else device,
        "load_average": load_average(),
    }


def measure_peaks(device: str = "cpu") -> Peaks:
    """Multiply large matrices and copy a large array, and keep the best run of each."""
    kinds = {"fp32": torch.float32}
    if has_bf16(device):
        kinds["bf16"] = torch.bfloat16
    gflops = {}
    for name, kind in kinds.items():
        a, b = (torch.randn(_MATRIX, _MATRIX, device=device).to(kind) for _ in range(2))
        gflops[name] = 2e-9 * _MATRIX**3 / _best_seconds(lambda a=a, b=b: a @ b, device)
    source = torch.ones(_STREAM_MIB * 2**18, device=device)
    target = torch.empty_like(source)
    moved = 2 * source.numel() * 4
    return Peaks(gflops, 1e-9 * moved / _best_seconds(lambda: target.copy_(source), device))


@torch.inference_mode()
def demands(bundle: NetworkBundle, tier: Tier, device: str = "cpu") -> dict[str, Demand]:
    """What the three networks ask for at a tier's sizes, by stage."""
    size, lit = tier.delight_size, tier.network_size
    bundle = in_precision(bundle, device, tier.precision)
    pair = bundle.pair(tier.pair)
    light = torch.ones(1, *LIGHT_SHAPE, device=device)

    def image(channels: int, side: int) -> torch.Tensor:
        return torch.rand(1, channels, side, side, device=device)

    hints = image(pair.specular_shadow.config.hints, lit)
    runs: dict[str, tuple[torch.nn.Module, tuple]] = {
        "delight": (bundle.delight, (image(3, size),)),
        "specular_shadow": (pair.specular_shadow, (image(3, lit), light, hints if hints.shape[1] else None)),
        "compose": (
            pair.composition,
            (image(3, lit), image(3, lit), image(1, lit), image(1, lit), image(3, lit), light),
        ),
    }
    width = 2 if tier.precision == "bf16" else 4
    asked = {name: _demand(network, inputs, width) for name, (network, inputs) in runs.items()}
    looks, once = (1 + tier.mirrored) * (1 + tier.looks_twice), asked["delight"]
    asked["delight"] = Demand(looks * once.gflop, looks * once.megabytes)
    if not tier.shadow_network:
        del asked["specular_shadow"]
    if not tier.correction:
        del asked["compose"]
    return asked


def _demand(network: torch.nn.Module, inputs: tuple, width: int) -> Demand:
    """Operations counted by torch; bytes are every convolution's input, output and weights, once each."""
    moved = 0

    def add(module: torch.nn.Module, given: tuple, made: torch.Tensor) -> None:
        nonlocal moved
        moved += given[0].numel() + made.numel() + sum(weight.numel() for weight in module.parameters())

    layers = [m for m in network.modules() if isinstance(m, torch.nn.Conv2d | torch.nn.Linear)]
    hooks = [layer.register_forward_hook(add) for layer in layers]
    try:
        with FlopCounterMode(display=False) as counter:
            network(*inputs)
    finally:
        for hook in hooks:
            hook.remove()
    return Demand(1e-9 * counter.get_total_flops(), 1e-6 * width * moved)


def _best_seconds(work: Callable[[], object], device: str) -> float:
    work()
    best, until = float("inf"), time.perf_counter() + _SECONDS
    while time.perf_counter() < until:
        wait_for(device)
        started = time.perf_counter()
        work()
        wait_for(device)
        best = min(best, time.perf_counter() - started)
    return best


def wait_for(device: str) -> None:
    """Let a graphics card finish what it was given."""
    if device == "cuda":
        torch.cuda.synchronize()


def reset_peak_memory() -> None:
    """Forget the largest memory use so far, where the system can."""
    if torch.cuda.is_available():
        torch.cuda.reset_peak_memory_stats()
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


def peak_memory_mib(device: str = "cpu") -> float | None:
    """The largest memory this process (or, on "cuda", torch on the card) has used since `reset_peak_memory`."""
    if device == "cuda":
        return torch.cuda.max_memory_allocated() / 2**20
    return process_memory.peak_memory_mib()


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()
