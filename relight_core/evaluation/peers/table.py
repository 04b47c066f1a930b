"""Table 3: ours beside what others have published, on the same pictures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from relight_core.errors import InputError
from relight_core.evaluation.ablation.variants import VARIANTS, Budget, check_budget
from relight_core.evaluation.contest import Contender, OurEditor, OurNetworks, Outcome
from relight_core.evaluation.contest_report import BORROWED, RELIT, heading, paper_table, table
from relight_core.evaluation.peers.dpr import Dpr, DprNetwork
from relight_core.evaluation.peers.shih import Shih
from relight_core.evaluation.peers.shu import Shu
from relight_core.evaluation.peers.sun import Sun, SunConfig, load_sun, train_sun
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import NetworkBundle
from relight_core.networks.delight import DelightConfig
from relight_core.pipeline.quality import tier_of
from relight_core.training.loop import state_path
from relight_core.training.recipe import load_recipe
from relight_core.training.run import Run

GIVEN_TRUTH = ("Shih et al. 2014", "Shu et al. 2017")
"""Whoever is given the truth as an example."""

PAPER_TABLE_3 = {
    "Shih et al. 2014": (0.0389, 29.4, 0.877),
    "Shu et al. 2017": (0.0717, 25.1, 0.884),
    "DPR (Zhou et al. 2019)": (0.1128, 19.8, 0.675),
    "Sun et al. 2019": (0.0518, 26.4, 0.865),
    "Full": (0.0281, 31.8, 0.914),
}
"""RMSE, PSNR and SSIM of the paper's Table 3; "Full" is its own model."""


def trained_sun(
    heads: Path,
    lights: Path,
    folder: Path,
    budget: Budget,
    report: Callable[[float, str], None],
    like: DelightConfig | None = None,
) -> Sun:
    """Sun et al.'s network from a folder, trained first where it is not there or not finished.

    It takes as many steps as a variant does in all its stages, on the same batches.

    Args:
        like: it is as wide and deep as this de-lighting network; None is that of the variants.

    Raises:
        InputError: the folder holds a training of another budget, on other data, or of another size of network.
        TrainingDiverged, InputError: as `training.loop.train_stage`.
    """
    check_budget(folder, budget, heads, lights)
    checkpoint, variant = folder / "sun" / "sun.safetensors", budget.of(load_recipe(VARIANTS["Full"]))
    like = like or variant.networks.delight
    config = SunConfig(like.width, like.levels)
    if not checkpoint.exists() or state_path(checkpoint).exists():
        run = Run("", heads, lights, checkpoint, size=budget.size, pairs=budget.pairs, kept=folder / "batches")
        steps = [plan.steps for plan in variant.stages]
        train_sun(run, sum(steps), max(steps), config, report)
    model = load_sun(checkpoint)
    if model.config != config:
        raise InputError(
            f"{checkpoint}: is {model.config.width} wide and {model.config.levels} deep, and what it is set beside "
            f"{config.width} and {config.levels}; choose another folder after -o"
        )
    return Sun(model)


def contenders(
    networks: Mapping[str, NetworkBundle],
    sun: Sun | None,
    dpr: DprNetwork | None,
    in_editor: Mapping[str, NetworkBundle] | None = None,
) -> dict[str, Contender]:
    """Everybody, in the order of the paper's Table 3.

    Args:
        networks: ours by name.
        dpr: None where the user has no weights for it.
        in_editor: those of ours, ready for inference, that also take part as the editor runs them at `final`.
    """
    table = ReflectionTable()
    everybody: dict[str, Contender] = {"Shih et al. 2014": Shih(), "Shu et al. 2017": Shu()}
    if dpr is not None:
        everybody["DPR (Zhou et al. 2019)"] = Dpr(dpr)
    if sun is not None:
        everybody["Sun et al. 2019"] = sun
    everybody |= {name: OurNetworks(bundle.eval(), table) for name, bundle in networks.items()}
    editors = {name: OurEditor(bundle, table, tier_of("final")) for name, bundle in (in_editor or {}).items()}
    return everybody | {f"{name}, in the editor": editor for name, editor in editors.items()}


def as_markdown(outcome: Outcome, training: str) -> str:
    """Everybody's relit pictures, light borrowed from a portrait, and the paper's own figures."""
    shown = [f"{name} (given the truth)" if name in GIVEN_TRUTH else name for name in outcome.figures]
    told = replace(outcome, figures=dict(zip(shown, outcome.figures.values(), strict=True)))
    lines = heading("Comparison (paper, Table 3)", told, training) + table(told, RELIT)
    lines += ["", "Light from a portrait of somebody else (paper, Figure 11, below):", "", *table(told, BORROWED)]
    lines += paper_table("The paper's Table 3, on its own data", ("RMSE", "PSNR", "SSIM"), PAPER_TABLE_3)
    return "\n".join(lines) + "\n"
