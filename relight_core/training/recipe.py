"""A training run in words: which networks, which stages, for how long; read from TOML."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields, replace
from functools import partial
from pathlib import Path
from typing import Any

from relight_core.dataset.recipe import data_mark
from relight_core.errors import InputError
from relight_core.face.parsing import CLASSES
from relight_core.imaging.files import check_regular, file_bytes, file_digest, whole_file
from relight_core.networks.bundle import BundleConfig, NetworkBundle, load_bundle, save_bundle
from relight_core.networks.foreign_shadow import ForeignShadowConfig
from relight_core.networks.person import PersonConfig
from relight_core.training.loop import is_begun, state_path
from relight_core.training.run import Run, train
from relight_core.training.stages import STAGES
from relight_core.training.state import Progress

_NOTE = "begun.json"
_REAL = ("minutes", "learning_rate")
"""Numbers of a stage that need not be whole."""
_CONFIG_OF_MORE = {"person": PersonConfig, "foreign_shadow": ForeignShadowConfig}
_NETWORKS = ("delight", "specular_shadow", "composition", *_CONFIG_OF_MORE)
_AT_LEAST_ONE = ("width", "levels", "widest")
"""Whole numbers of a network that can't be 0."""
_ALL_OR_NONE = ("classes", "parsing_classes")
"""Numbers of classes of the parsing: labels have all of them."""
_LARGEST_SEED = 2**63 - 1
_STEP_S = 1.7
"""Of fine-tuning on four pairs at 256 pixels, on two processor cores with bf16; others go by their pixels."""
_DATA = "heads and lights"
_WORDS = {"networks": "kind of networks", "seed": "seed", "start": "--start", _DATA: "set of heads and lights"}


@dataclass(frozen=True)
class StagePlan:
    """One stage of a recipe.

    Attributes:
        name: of a stage in `stages.STAGES`.
        minutes, steps: its length, one of them.
        size, pairs: image side in pixels and pairs of lights per batch.
        learning_rate: peak; None takes the stage's own.
        detail_width: from here on de-lighting has a sharpening pass of this width; 0 leaves it as it is.
        narrow_width, examples: of "distil-relight", see `run.Run`.
        uses, window: how often each pair is learnt from, and among how many, see `run.Run`.
    """

    name: str
    minutes: float | None = None
    steps: int | None = None
    size: int = 128
    pairs: int = 8
    learning_rate: float | None = None
    detail_width: int = 0
    narrow_width: int | None = None
    examples: int = 150
    uses: int = 1
    window: int = 1024

    @property
    def expected_minutes(self) -> float:
        """Its length, or what that many steps take on two processor cores, roughly."""
        if self.minutes is not None:
            return self.minutes
        return self.steps * _STEP_S / 60 * self.pairs / 4 * (self.size / 256) ** 2


@dataclass(frozen=True)
class Recipe:
    """Networks and the stages that train them, in order."""

    networks: BundleConfig
    stages: tuple[StagePlan, ...]
    seed: int = 0

    def expected_minutes(self, number: int, elapsed: float) -> float:
        """How long it takes to get as far as a fraction of the stage at that place, roughly."""
        before = sum(plan.expected_minutes for plan in self.stages[:number])
        return before + elapsed * self.stages[number].expected_minutes


def recipe_names() -> list[str]:
    """Names of the recipes that come with the project; one in a folder has the folder's name before its own."""
    folder = Path(__file__).parent / "recipes"
    return sorted(path.relative_to(folder).with_suffix("").as_posix() for path in folder.rglob("*.toml"))


def load_recipe(name_or_path: str) -> Recipe:
    """Read a recipe of the project by its name, or a file.

    Raises:
        InputError: it can't be read, or says something that no run understands.
    """
    bundled = Path(__file__).parent / "recipes" / f"{name_or_path}.toml"
    path = bundled if name_or_path in recipe_names() else Path(name_or_path)
    try:
        check_regular(path)
        return _parsed(tomllib.loads(path.read_text(encoding="utf-8")))
    except InputError:
        raise
    except OSError as error:
        known = ", ".join(recipe_names())
        raise InputError(f"{path}: can't be read ({error.strerror}); give a file or one of {known}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, TypeError, ValueError, KeyError) as error:
        raise InputError(f"{path}: not a training recipe ({error}); mend that line") from error


def _parsed(data: dict[str, Any]) -> Recipe:
    unknown = set(data) - {"seed", "networks", "stage", "description"}
    if unknown:
        raise ValueError(f"unknown entry {sorted(unknown)[0]!r}")
    entries = data.get("stage", [])
    if not (isinstance(entries, list) and all(isinstance(entry, dict) for entry in entries)):
        raise ValueError("each stage goes under a line [[stage]]")
    stages = tuple(_stage(entry) for entry in entries)
    if not stages:
        raise ValueError("no [[stage]]")
    seed = data.get("seed", 0)
    if type(seed) is not int or not 0 <= seed <= _LARGEST_SEED - len(stages):
        raise ValueError(f"seed must be a whole number from 0 up, below {_LARGEST_SEED:.0e}")
    return Recipe(_networks(data.get("networks", {})), stages, seed)


def _networks(data: dict[str, dict[str, Any]]) -> BundleConfig:
    config = BundleConfig()
    for name, settings in _table(data, "networks").items():
        if name not in _NETWORKS:
            raise ValueError(f"unknown network {name!r}: one of {', '.join(_NETWORKS)}")
        before = getattr(config, name) or _CONFIG_OF_MORE[name]()
        known = {field.name for field in fields(before)}
        for entry, value in _table(settings, f"networks.{name}").items():
            if entry not in known:
                raise ValueError(f"networks.{name}: unknown entry {entry!r}")
            _check_network_entry(name, entry, value, getattr(before, entry))
        config = replace(config, **{name: replace(before, **settings)})
    return config


def _check_network_entry(network: str, entry: str, value: Any, default: Any) -> None:
    """Raise ValueError for a value of another type than the entry's default, or out of range.

    Entries whose default is a tuple of whole numbers are lists in TOML.
    """
    if isinstance(default, tuple) and type(value) is list:
        numbers, kind = value, int
    else:
        numbers, kind = [value], type(default)
    least = 1 if entry in _AT_LEAST_ONE else 0
    # Not isinstance, for which True is a whole number.
    if any(type(number) is not kind or (kind is int and number < least) for number in numbers):
        raise ValueError(f"networks.{network}: {entry} can't be {value!r}")
    if entry in _ALL_OR_NONE and value not in (0, len(CLASSES)):
        raise ValueError(f"networks.{network}: {entry} can't be {value}; write {len(CLASSES)}, or 0 for none")


def _table(value: Any, name: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise ValueError(f"{name} is {value!r} and not a table; write a line [{name}]")
    return value


def _stage(entry: dict[str, Any]) -> StagePlan:
    types = {field.name: field.type for field in fields(StagePlan)}
    for name, value in entry.items():
        if name not in types:
            raise ValueError(f"unknown entry {name!r} in a stage")
        if name != "name" and not (type(value) in (int, float) and 0 < value < math.inf):
            raise ValueError(f"{name} must be a number above 0")
        if name not in ("name", *_REAL) and type(value) is not int:
            raise ValueError(f"{name} must be a whole number")
    if not isinstance(entry.get("name"), str):
        raise ValueError("a stage has no name; write a line name = ...")
    plan = StagePlan(**entry)
    if plan.name not in STAGES:
        raise ValueError(f"unknown stage {plan.name!r}: one of {', '.join(STAGES)}")
    if (plan.minutes is None) == (plan.steps is None):
        raise ValueError(f"{plan.name}: give either minutes or steps")
    if STAGES[plan.name].samples != "pairs" and plan.uses > 1:
        raise ValueError(f"{plan.name}: its samples are used once each")
    return plan


def follow(
    recipe: Recipe,
    heads: Path,
    lights: Path,
    folder: Path,
    report: Callable[[int, float, Progress], None],
    start: Path | None = None,
    kept: Path | None = None,
    workers: int = 1,
    places: Path | None = None,
) -> NetworkBundle:
    """Train all stages into a folder; a run that was stopped goes on where it was.

    Every stage leaves its weights and its log; the last one's, in half precision, are also
    "relight.safetensors".

    Args:
        report: called with the stage's place in the recipe, the fraction of it that is done, its progress.
        start: weights to begin from, with the networks that the recipe names; random ones without.
        kept, workers, places: see `run.Run`.

    Raises:
        InputError: the folder holds a run of other networks, of another seed, from other weights, on other heads or
            lights, a finished stage of another plan, or one that the recipe has not; a stage finds random networks.
        TrainingDiverged, InputError: as `loop.train_stage`.
    """
    _check_start(recipe, start)
    folder.mkdir(parents=True, exist_ok=True)
    _keep_to_one_run(recipe, start, folder, data_mark(heads, lights))
    _check_order(recipe, start)
    before = start
    for number, plan in enumerate(recipe.stages):
        checkpoint = _checkpoint(folder, number, plan)
        if state_path(checkpoint).exists() or not checkpoint.exists():
            settings = _run(recipe, plan, number, heads, lights, checkpoint, before)
            train(replace(settings, kept=kept, workers=workers, places=places), partial(report, number))
        before = checkpoint
    result = load_bundle(before)
    save_bundle(folder / "relight.safetensors", result)
    return result


def _check_start(recipe: Recipe, start: Path | None) -> None:
    """Weights keep the networks that they were made with, so a recipe must not ask for others without being heard."""
    if start is None:
        return
    has, usual = load_bundle(start).config, BundleConfig()
    for name in (field.name for field in fields(BundleConfig)):
        asked = getattr(recipe.networks, name)
        if asked not in (getattr(usual, name), getattr(has, name)):
            mend = f"leave out --start, or [networks.{name}] in the recipe"
            raise InputError(f"{start}: its {name} network is another than the recipe asks for; {mend}")


def _check_order(recipe: Recipe, start: Path | None) -> None:
    """Told before the first stage: a later one would find random networks after hours of others."""
    trained = set() if start is None else {"delight", "specular_shadow", "composition"}
    for plan in recipe.stages:
        STAGES[plan.name].check_trained(trained, recipe.networks)
        trained |= set(STAGES[plan.name].trains)


def _keep_to_one_run(recipe: Recipe, start: Path | None, folder: Path, data: str) -> None:
    """Note what a folder's run is made from; its finished stages would be taken for those of any other.

    Stages of a plan of their own may follow in the same folder, as a recipe is lengthened; one that is put between
    others makes those after it others, which have to go on from its weights. A shortened recipe is another run.
    """
    weights = None if start is None else file_digest(start)
    begun = {"networks": json.loads(recipe.networks.to_json()), "seed": recipe.seed, "start": weights, _DATA: data}
    plans = _plans(recipe, folder)
    note = folder / _NOTE
    earlier = _read_note(note, begun) if note.exists() else {}
    if not any(is_begun(folder / f"{name}.safetensors") for name in earlier.get("stages", {})):
        earlier = {}  # A run that was refused has left its note and nothing that could be taken for another's.
    other = [_WORDS[name] for name, value in begun.items() if earlier.get(name, value) != value]
    kept = earlier.get("stages", {})
    other += [f"plan for {name}" for name, plan in plans.items() if _is_another(folder, name, plan, kept)]
    if other:
        raise InputError(f"{folder}: holds a run that began with another {other[0]}; choose another folder after -o")
    left_out = sorted(name for name in kept.keys() - plans.keys() if is_begun(folder / f"{name}.safetensors"))
    if left_out:
        # Its result would become that of an earlier stage.
        raise InputError(f"{folder}: holds {left_out[0]}, which the recipe has not; choose another folder after -o")
    with whole_file(note) as beside:
        beside.write_text(json.dumps({**begun, "stages": {**kept, **plans}}, indent=1))


def _plans(recipe: Recipe, folder: Path) -> dict[str, dict]:
    """Every stage's plan and which stage's weights it goes on from, by the name of its files."""
    names = [_checkpoint(folder, number, plan).stem for number, plan in enumerate(recipe.stages)]
    before = [None, *names]
    return {
        name: asdict(plan) | {"after": earlier}
        for name, plan, earlier in zip(names, recipe.stages, before, strict=False)
    }


def _read_note(note: Path, begun: dict) -> dict:
    try:
        noted = {_DATA: begun[_DATA], **json.loads(file_bytes(note))}  # Older notes don't tell the data.
        return {**{name: noted[name] for name in begun}, "stages": dict(noted["stages"])}
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f"{note}: can't be read ({error}); choose another folder after -o") from error


def _is_another(folder: Path, name: str, plan: dict, kept: dict) -> bool:
    """Whether a stage is there of another plan or after another stage; a half-done one may still change its length."""
    checkpoint = folder / f"{name}.safetensors"
    noted = kept.get(name, plan)
    if state_path(checkpoint).exists():
        return noted["after"] != plan["after"]
    return checkpoint.exists() and noted != plan


def _checkpoint(folder: Path, number: int, plan: StagePlan) -> Path:
    return folder / f"{number + 1:02d}-{plan.name}.safetensors"


def _run(recipe: Recipe, plan: StagePlan, number: int, heads, lights, checkpoint, before) -> Run:
    planned = asdict(plan)
    places = planned.pop("name"), heads, lights, checkpoint, before
    return Run(*places, seed=recipe.seed + number, config=recipe.networks, **planned)
