"""The variants of Table 2 as recipes, and their training: same seed, same batches, same number of steps."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import torch

from relight_core.dataset.recipe import data_mark
from relight_core.errors import InputError
from relight_core.evaluation.counted import counted
from relight_core.imaging.files import whole_file
from relight_core.networks.bundle import BundleConfig, NetworkBundle, load_bundle, save_bundle
from relight_core.training.loop import state_path
from relight_core.training.recipe import Recipe, StagePlan, follow, load_recipe
from relight_core.training.run import Run, train
from relight_core.training.stages import STAGES

VARIANTS = {
    "DL-RL": "ablation/dl-rl",
    "DL-RL+SS": "ablation/ss",
    "DL-RL+SS+LFM": "ablation/ss-lfm",
    "Full": "ablation/full",
    "ours": "ablation/ours",
}
"""Recipes by the paper's names of its rows, in its order; "ours" goes on from "Full"."""

_WARM_UP = "warm-"

Report = Callable[[float, str], None]


@dataclass(frozen=True)
class Budget:
    """What every variant is given.

    Attributes:
        steps: of each warm-up; fine-tuning takes as many as the recipes give it in proportion. None leaves
            the recipes' own.
        size: side of the images in pixels, a multiple of 32.
        pairs: pairs of lights in a batch; a batch holds twice as many photos.
    """

    steps: int | None = None
    size: int = 64
    pairs: int = 4

    def of(self, recipe: Recipe) -> Recipe:
        """A recipe of this length and size."""
        longest = max(plan.steps for plan in recipe.stages)
        share = 1.0 if self.steps is None else self.steps / longest
        return replace(
            recipe,
            stages=tuple(
                replace(plan, steps=max(round(plan.steps * share), 1), size=self.size, pairs=self.pairs)
                for plan in recipe.stages
            ),
        )


def in_words(budget: Budget) -> str:
    """How all variants were trained, in a sentence."""
    plans = budget.of(load_recipe(VARIANTS["Full"])).stages
    stages = ", ".join(f"{plan.steps} of {plan.name}" for plan in plans)
    return (
        f"All networks learned from the same batches of {2 * budget.pairs} photos "
        f"({counted(budget.pairs, 'pair')} of lights) at {budget.size} pixels, from the same seed; steps: {stages}."
    )


def train_variants(
    heads: Path, lights: Path, folder: Path, budget: Budget, report: Report = lambda done, note: None
) -> dict[str, Path]:
    """Train every variant that is not yet there; a run that was stopped goes on where it was.

    Warm-ups that variants have in common are run once: two that start from the same seed and see the same
    batches would end in the same weights.

    Args:
        folder: gets the batches, the warm-ups and a folder for each variant.
        report: called with the fraction of all training that is done and a note.

    Returns:
        The variants' weights, by name.

    Raises:
        InputError: the folder holds a training of another budget, or on other data.
        TrainingDiverged, InputError: as `training.loop.train_stage`.
    """
    check_budget(folder, budget, heads, lights)
    plans = {name: budget.of(load_recipe(recipe)) for name, recipe in VARIANTS.items()}
    for number, (name, recipe) in enumerate(plans.items()):
        if not _weights(folder, name).exists():
            trainer = _Trainer(heads, lights, folder, lambda at, note, n=number: report((n + at) / len(plans), note))
            trainer.train(name, recipe, _weights(folder, name).parent)
    return trained_variants(folder)


def check_budget(folder: Path, budget: Budget, heads: Path, lights: Path) -> None:
    """Note the budget and the training data in a folder; raises InputError where others trained in it."""
    note, words = folder / "budget.json", json.dumps({**asdict(budget), "data": data_mark(heads, lights)})
    begun = note.exists() and any(folder.rglob("*.safetensors"))
    # Older notes know of no data; a training that was refused has left nothing but its note.
    if not begun or note.read_text() == json.dumps(asdict(budget)):
        with whole_file(note) as beside:
            beside.write_text(words)
    elif note.read_text() != words:
        about = f"{note.read_text()}, where data stands for heads and lights"
        raise InputError(f"{folder}: holds a training with {about}; choose another folder after -o")


def trained_variants(folder: Path) -> dict[str, Path]:
    """Weights, by name, of the variants whose training in a folder is finished."""
    return {name: _weights(folder, name) for name in VARIANTS if _weights(folder, name).exists()}


def _weights(folder: Path, name: str) -> Path:
    return folder / name.lower().replace("+", "-") / "relight.safetensors"


@dataclass(frozen=True)
class _Trainer:
    heads: Path
    lights: Path
    folder: Path
    report: Report

    def train(self, name: str, recipe: Recipe, place: Path) -> None:
        """All stages of one variant, into its folder."""
        warm = [plan for plan in recipe.stages if plan.name.startswith(_WARM_UP)]
        rest = tuple(plan for plan in recipe.stages if not plan.name.startswith(_WARM_UP))
        count = len(recipe.stages)
        torch.manual_seed(recipe.seed)
        bundle = NetworkBundle(recipe.networks)
        for number, plan in enumerate(warm):
            trained = self._warm_up(name, recipe, plan, number / count, 1 / count)
            for part in STAGES[plan.name].trains:
                getattr(bundle, part).load_state_dict(getattr(trained, part).state_dict())
        start = place / "00-warm.safetensors"
        start.parent.mkdir(parents=True, exist_ok=True)
        if not start.exists():
            save_bundle(start, bundle, half=False)

        def show(number: int, elapsed: float, progress) -> None:
            self.report((len(warm) + number + elapsed) / count, f"{name}, {rest[number].name}, step {progress.step}")

        follow(replace(recipe, stages=rest), self.heads, self.lights, place, show, start, kept=self.folder / "batches")

    def _warm_up(self, name: str, recipe: Recipe, plan: StagePlan, done: float, share: float) -> NetworkBundle:
        """Networks after a warm-up, trained unless another variant did."""
        config = _alone(recipe.networks, STAGES[plan.name].trains)
        what = json.dumps([asdict(plan), asdict(config), recipe.seed], sort_keys=True)
        place = self.folder / "warm" / f"{plan.name}-{hashlib.sha256(what.encode()).hexdigest()[:10]}.safetensors"
        if place.exists() and not state_path(place).exists():
            return load_bundle(place)
        place.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(place.with_suffix(".json")) as beside:
            beside.write_text(what)
        run = Run(
            plan.name,
            self.heads,
            self.lights,
            place,
            steps=plan.steps,
            size=plan.size,
            pairs=plan.pairs,
            seed=recipe.seed,
            learning_rate=plan.learning_rate,
            kept=self.folder / "batches",
            config=config,
        )
        return train(run, lambda at, state: self.report(done + at * share, f"{name}, {plan.name}, step {state.step}"))


def _alone(config: BundleConfig, names: tuple[str, ...]) -> BundleConfig:
    """A configuration in which only what is trained has its size, so that equal trainings look equal."""
    return replace(BundleConfig.tiny(), **{name: getattr(config, name) for name in names})
