"""Show versions, devices, graphics, weights and threads: what to put into a report of a fault."""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, version

from app.cli.arguments import add_json
from app.cli.report import reporting
from relight_core import __version__
from relight_core.imaging.files import file_digest

PACKAGES = (
    "torch",
    "numpy",
    "scipy",
    "safetensors",
    "opencv-contrib-python-headless",
    "OpenEXR",
    "pillow",
    "pi-heif",
    "tifffile",
    "rawpy",
    "av",
    "scikit-image",
    "moderngl",
    "glfw",
    "imgui-bundle",
    "mitsuba",
)

_PROBE_SECONDS = 30

_GRAPHICS_PROBE = """
import moderngl, sys
settings = {"backend": "egl"} if sys.platform == "linux" else {}
info = moderngl.create_context(standalone=True, **settings).info
print(info["GL_VENDOR"], info["GL_RENDERER"], info["GL_VERSION"], sep="\\n")
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of `relight info`."""
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Print what this installation is made of; returns the exit code."""
    with reporting(arguments.json) as report:
        facts = {
            "relight": __version__,
            "python": platform.python_version(),
            "system": platform.platform(),
            "packages": _packages(),
            **_compute(),
            "graphics": _graphics(),
            "weights": _weights(),
        }
        for line in _lines(facts):
            report.line(line)
        report.record(facts)
    return 0


def _packages() -> dict[str, str | None]:
    found = {}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = None
    return found


def _compute() -> dict:
    import torch

    from app.engine.pace import leave_a_core

    cards = [torch.cuda.get_device_name(index) for index in range(torch.cuda.device_count())]
    devices = ["cpu", *(f"cuda:{index} ({name})" for index, name in enumerate(cards))]
    leave_a_core()
    return {"devices": devices, "threads": {"torch": torch.get_num_threads(), "cores": os.cpu_count()}}


def _graphics() -> dict[str, str]:
    """Who draws, asked in a process of its own: a broken driver may take its process down."""
    try:
        probe = subprocess.run(
            [sys.executable, "-c", _GRAPHICS_PROBE], capture_output=True, text=True, timeout=_PROBE_SECONDS
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return {"missing": f"no OpenGL context ({type(error).__name__})"}
    lines = probe.stdout.strip().splitlines()
    if probe.returncode != 0 or len(lines) != 3:
        reason = (probe.stderr.strip().splitlines() or [f"exit code {probe.returncode}"])[-1]
        return {"missing": f"no OpenGL context ({reason})"}
    return dict(zip(("vendor", "renderer", "version"), lines, strict=True))


def _weights() -> list[dict]:
    from relight_core.resources import resource_path

    try:
        paths = sorted(resource_path("weights").glob("*.safetensors"))
    except FileNotFoundError:
        return []
    return [{"file": path.name, "bytes": path.stat().st_size, "sha256": file_digest(path)} for path in paths]


def _lines(facts: dict) -> list[str]:
    lines = [f"relight {facts['relight']}, Python {facts['python']}, {facts['system']}"]
    lines += [f"  {name:<32}{number or 'not installed'}" for name, number in facts["packages"].items()]
    lines.append(f"devices   {', '.join(facts['devices'])}")
    lines.append(f"threads   {facts['threads']['torch']} for the networks, of {facts['threads']['cores']} cores")
    lines.append(f"graphics  {', '.join(facts['graphics'].values())}")
    for weights in facts["weights"]:
        lines.append(f"weights   {weights['file']}, {weights['bytes']} bytes, sha256 {weights['sha256']}")
    if not facts["weights"]:
        lines.append("weights   none")
    return lines
