"""Table 2 from trained variants."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from relight_core.evaluation.contest import Contest, OurNetworks, Outcome, hold
from relight_core.evaluation.contest_report import CHANNELS, RELIT, heading, paper_table, table
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import load_bundle

PAPER_TABLE_2 = {
    "DL-RL": (0.0511, 26.4, 0.870, 0.0342, 0.132, None, None, 0.0364),
    "DL-RL+SS": (0.0415, 28.2, 0.882, 0.0347, 0.144, 0.00909, 0.00512, 0.0356),
    "DL-RL+SS+LFM": (0.0309, 31.0, 0.909, 0.0314, 0.131, 0.00575, 0.00416, 0.0301),
    "Full": (0.0281, 31.8, 0.914, 0.0271, 0.132, 0.00575, 0.00416, 0.0274),
}
"""The paper's Table 2; None where a row has no such channel."""

PAPER_COLUMNS = ("relit RMSE", "PSNR", "SSIM", "albedo", "normal", "specular", "shadow", "light wlog-L2")


def score_variants(weights: Mapping[str, Path], contest: Contest, report: Callable[[float], None]) -> Outcome:
    """Every variant on the same pictures; see `contest.hold`."""
    reflection = ReflectionTable()
    networks = {name: OurNetworks(load_bundle(path).eval(), reflection) for name, path in weights.items()}
    return hold(networks, contest, report)


def as_markdown(outcome: Outcome, training: str) -> str:
    """Ours as the paper has it, the channels, and the paper's own."""
    lines = heading("Ablation (paper, Table 2)", outcome, training)
    lines += table(outcome, {**RELIT, "relit.psnr_gain": "PSNR over the row above"}) + [""] + table(outcome, CHANNELS)
    lines += paper_table("The paper's, on its own data", PAPER_COLUMNS, PAPER_TABLE_2)
    return "\n".join(lines) + "\n"
