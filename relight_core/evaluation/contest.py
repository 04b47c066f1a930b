"""Several ways to relight on the same held-out pictures, at the size at which they were trained."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from relight_core.evaluation.bench import Editor, ReadyPhoto
from relight_core.evaluation.direct import DirectRelighter, FoundSurface, found_channels
from relight_core.evaluation.evaluate import intervals_over_heads
from relight_core.evaluation.held_out import (
    Case,
    HeldOutHead,
    HeldOutLight,
    cases_of,
    held_out_lights,
    held_out_paths,
    held_out_textures,
    load_head,
)
from relight_core.evaluation.metrics import Interval, interval_over_heads, wlog_l2
from relight_core.evaluation.scoring import Figures, levelled, score_effects, score_relit, score_surface
from relight_core.lighting.lamps import Lamp
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import NetworkBundle
from relight_core.pipeline.quality import Tier


@dataclass(frozen=True)
class Task:
    """One relighting.

    Attributes:
        light: (16, 32, 3) the target, of mean luminance 1.
        gain: the exposure at which a meter would show the truth.
        reference: (S, S, 3) linear, [0, 1]: the truth as photographed, for whoever needs an example.
        covered: (S, S) bool, the head.
        surface: true images "normal" and "relief", for whoever needs a fitted model of the head.
        small_lamps: of the light, for whoever draws their shadows.
    """

    light: np.ndarray
    gain: float
    reference: np.ndarray
    covered: np.ndarray
    surface: Mapping[str, np.ndarray]
    small_lamps: tuple[Lamp, ...] = ()


class Contender(Protocol):
    """A way to relight; one that finds nothing out beforehand need only relight."""

    def look(self, photo: np.ndarray) -> Any:
        """Whatever a photo (S, S, 3), linear, [0, 1] tells, once for all its relightings; the photo itself does."""
        return photo

    def relight(self, seen: Any, task: Task) -> Mapping[str, np.ndarray]:
        """ "composition": linear, in units of the normalised light; "specular" and "shadow" where there are such."""

    def channels(self, seen: Any) -> Mapping[str, np.ndarray]:
        """ "guess", the photo's light, and "albedo" and "normal", as far as they are found."""
        return {}


class OurNetworks:
    """The three networks, as a contender."""

    def __init__(self, bundle: NetworkBundle, table: ReflectionTable):
        self._direct = DirectRelighter(bundle, table)

    def look(self, photo: np.ndarray) -> FoundSurface:
        return self._direct.take_apart(photo)

    def relight(self, seen: FoundSurface, task: Task) -> Mapping[str, np.ndarray]:
        return self._direct.relight(seen, task.light)

    def channels(self, seen: FoundSurface) -> Mapping[str, np.ndarray]:
        return found_channels(seen)


class OurEditor:
    """The three networks with all that the editor does before and after them, as a contender."""

    def __init__(self, bundle: NetworkBundle, table: ReflectionTable, tier: Tier):
        """Take networks that are ready for inference."""
        self._editor = Editor(bundle, table, tier, table.transport.device.type)

    def look(self, photo: np.ndarray) -> ReadyPhoto:
        return self._editor.take_apart(photo)

    def relight(self, seen: ReadyPhoto, task: Task) -> Mapping[str, np.ndarray]:
        return self._editor.relight(seen, HeldOutLight("target", task.light, False, task.small_lamps))

    def channels(self, seen: ReadyPhoto) -> Mapping[str, np.ndarray]:
        return seen.channels


@dataclass(frozen=True)
class Contest:
    """What is contested.

    Attributes:
        heads, lights, split: as in `evaluate.Settings`.
        size: side of the pictures; the baked size or a divisor of it.
        count: heads.
        every: take only every so-many-th relighting of a head, each head beginning with another.
    """

    heads: Path
    lights: Path
    size: int
    split: str = "test"
    count: int = 8
    every: int = 1

    def cases(self, head_number: int, lights: list[HeldOutLight]) -> list[Case]:
        """The relightings of one head."""
        return cases_of(head_number, lights)[head_number % self.every :: self.every]


@dataclass(frozen=True)
class Outcome:
    """Figures of every contender, by its name and theirs, with 95 % intervals over heads.

    "relit.psnr_gain" is the mean difference in PSNR from the contender before, picture by picture: its
    interval tells whether an order holds, where those of the figures themselves overlap.
    Beside those of `scoring`: "borrowed.wlog_l2" is the target light as estimated from a portrait of another
    head in it, "borrowed.rmse" the error when the photo is relit with that estimate (paper, Figure 11, below).
    `sheet` is linear: a row for each head's first relighting, with the photo, every contender's and the truth.
    """

    figures: dict[str, dict[str, Interval]]
    samples: int
    heads: int
    sheet: np.ndarray = field(repr=False)
    contest: Contest = field(repr=False)


def hold(
    contenders: Mapping[str, Contender], contest: Contest, report: Callable[[float], None] = lambda done: None
) -> Outcome:
    """Relight every held-out photo by every contender; panoramas only.

    Args:
        report: called with the fraction that is done.

    Raises:
        InputError: heads or lights are missing, damaged, or of a size that does not fit.
    """
    lights = [light for light in held_out_lights(contest.lights, contest.split) if not light.lamp]
    paths = held_out_paths(contest.heads, contest.split, contest.count)
    textures = held_out_textures()
    rows: dict[str, list[tuple[str, Figures]]] = defaultdict(list)
    portraits = _portraits_of_others(paths, lambda path: load_head(path, lights, textures, contest.size))
    strips = []
    for number, (head, other) in enumerate(portraits):
        cases, pictures = contest.cases(number, lights), []
        for place, (name, contender) in enumerate(contenders.items()):
            scored = list(_score_head(contender, cases, head, other, lights))
            rows[name] += [(head.name, figures) for figures, _ in scored]
            pictures += [picture for _, picture in scored[:1]]
            report((number + (place + 1) / len(contenders)) / len(paths))
        if cases:
            photo, truth = (head.photo(light, "clean") for light in (cases[0].source, cases[0].target))
            strips.append(np.hstack([photo, *pictures, truth]))
    figures = {name: intervals_over_heads(scored) for name, scored in rows.items()}
    for name, before in zip(list(rows)[1:], rows, strict=False):
        figures[name]["relit.psnr_gain"] = _gain(rows[name], rows[before])
    whose = [head for head, _ in next(iter(rows.values()))]
    # Where `every` is more than a head has relightings, some heads have none.
    return Outcome(figures, len(whose), len(set(whose)), np.vstack(strips), contest)


def _gain(rows: list[tuple[str, Figures]], before: list[tuple[str, Figures]]) -> Interval:
    differences = [one["relit.psnr"] - other["relit.psnr"] for (_, one), (_, other) in zip(rows, before, strict=True)]
    return interval_over_heads(np.array(differences), np.array([head for head, _ in rows]))


def _portraits_of_others(
    paths: Sequence[Path], load: Callable[[Path], HeldOutHead]
) -> Iterator[tuple[HeldOutHead, HeldOutHead | None]]:
    """Every head, and the one before it (before the first: the last) as the portrait that lends its light.

    One head alone has nobody to borrow from.
    """
    other = load(paths[-1]) if len(paths) > 1 else None
    for path in paths:
        head = load(path)
        yield head, other
        other = head if len(paths) > 1 else None


def _score_head(
    contender: Contender, cases: list[Case], head: HeldOutHead, other: HeldOutHead | None, lights: list[HeldOutLight]
) -> Iterator[tuple[Figures, np.ndarray]]:
    """Figures of every relighting, and the picture (S, S, 3), linear, as it is shown."""
    truth, covered = head.surface(), head.lit.head.covered
    for case in cases:
        seen, target = contender.look(head.photo(case.source, "clean")), lights[case.target].radiance
        true, gain = head.channels(case.target), head.exposure(case.target)
        reference, lamps = np.clip(true["image"] * gain, 0, 1), lights[case.target].small_lamps
        task = Task(target, gain, reference, covered, truth, lamps)
        made, found = contender.relight(seen, task), contender.channels(seen)
        figures = score_relit(made["composition"], true["image"], gain, covered, covered)
        if "shadow" in made:
            figures |= score_effects(made, true, covered)
        if "albedo" in found:
            figures |= score_surface(found, lights[case.source].radiance, truth, covered)
        elif "guess" in found:
            figures["light.wlog_l2"] = wlog_l2(levelled(found["guess"]), lights[case.source].radiance)
        if "guess" in found and other is not None:
            lent = levelled(contender.channels(contender.look(other.photo(case.target, "clean")))["guess"])
            image = contender.relight(seen, Task(lent, gain, task.reference, covered, truth))["composition"]
            figures["borrowed.wlog_l2"] = wlog_l2(lent, target)
            figures["borrowed.rmse"] = score_relit(image, true["image"], gain, covered, covered)["relit.rmse"]
        yield figures, np.clip(made["composition"] * gain, 0, 1) * covered[..., None]
