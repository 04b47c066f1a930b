"""List the bundled lights, which --light takes by name."""

from __future__ import annotations

import argparse
import textwrap

from app.cli.arguments import add_json
from app.cli.report import reporting


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of `relight rigs`."""
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Print each rig's name and description; returns the exit code."""
    from relight_core.lighting.rigs import read_bundled_rig, rig_names

    with reporting(arguments.json) as report:
        rigs = [(name, read_bundled_rig(name)) for name in rig_names()]
        width = max(len(name) for name, _ in rigs) + 2
        for name, rig in rigs:
            first, *others = textwrap.wrap(rig.description, 100 - width) or [""]
            report.line(f"{name:<{width}}{first}")
            for line in others:
                report.line(" " * width + line)
        report.record({"rigs": [{"name": n, "title": r.title, "description": r.description} for n, r in rigs]})
    return 0
