"""Where the error of a relit picture comes from: de-lighting is told the truth, one part at a time.

Every photo is taken apart by the editor's own stages; then a part of what was found gives way to the true one, and
the picture is relit from that. What is gained is what a perfect estimate of that part alone would bring.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import torch

from relight_core.evaluation.bench import Editor, ReadyPhoto, masks_of
from relight_core.evaluation.counted import counted
from relight_core.evaluation.evaluate import HeldOut, Rows, Settings
from relight_core.evaluation.held_out import Case, HeldOutHead, HeldOutLight, Photos
from relight_core.evaluation.metrics import Interval, interval_over_heads
from relight_core.evaluation.report import intervals_in_words, known
from relight_core.evaluation.scoring import Figures, best_gain, score_relit
from relight_core.evaluation.tables import markdown_table
from relight_core.evaluation.true_surface import true_surface
from relight_core.face.parsing import FACE_LABELS, INDEX
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import NetworkBundle
from relight_core.pipeline.quality import quality_of
from relight_core.pipeline.stages import Surface

_MEASURES = ("relit.psnr", "relit.psnr_aligned")
_WHOLE_PIXEL = 0.99
_HAIR_AND_HEADWEAR = tuple(INDEX[name] for name in ("hair", "hat", "glasses"))
_OF_THE_HEAD = frozenset({"albedo", "normal", "relief"})
_BODY = tuple(INDEX[name] for name in ("neck", "cloth"))

Told = Callable[[Surface, torch.Tensor, Surface, torch.Tensor], tuple[Surface, torch.Tensor]]
"""(found surface and light, true surface and light) -> surface and light."""


def _nothing(found, light, true, true_light):
    return found, light


def _level(found, light, true, true_light):
    known = (true.person[0, 0] > _WHOLE_PIXEL).cpu().numpy()
    albedo, true_albedo = (part[0].permute(1, 2, 0).cpu().numpy() for part in (found.albedo, true.albedo))
    return replace(found, albedo=(found.albedo * best_gain(albedo, true_albedo, known)).clamp(0, 1)), light


def _parts(found, light, true, true_light, *, names: tuple[str, ...]):
    """The truth; beside the head there is none of its surface, whose height of 0 would stand there like a wall."""
    told = {name: getattr(true, name) for name in names}
    for name in _OF_THE_HEAD.intersection(names):
        told[name] = torch.where(true.person > 0, told[name], getattr(found, name))
    return replace(found, **told), light


def _normals_of(found, light, true, true_light, *, labels: tuple[int, ...]):
    there = torch.isin(true.parsing.argmax(1, keepdim=True), torch.tensor(labels, device=true.parsing.device))
    return replace(found, normal=torch.where(there, true.normal, found.normal)), light


def _light(found, light, true, true_light):
    return found, true_light


def _everything(found, light, true, true_light):
    return _parts(found, light, true, true_light, names=_SURFACE)[0], true_light


_SURFACE = ("albedo", "normal", "relief", "parsing", "person")
ROWS: dict[str, Told] = {
    "nothing": _nothing,
    "level of the albedo": _level,
    "albedo": partial(_parts, names=("albedo",)),
    "normals of the face": partial(_normals_of, labels=tuple(FACE_LABELS)),
    "normals of hair, headwear and glasses": partial(_normals_of, labels=_HAIR_AND_HEADWEAR),
    "normals of neck, arms and clothes": partial(_normals_of, labels=_BODY),
    "all normals": partial(_parts, names=("normal",)),
    "relief": partial(_parts, names=("relief",)),
    "normals and relief": partial(_parts, names=("normal", "relief")),
    "the photo's light": _light,
    "the whole surface": partial(_parts, names=_SURFACE),
    "the whole surface and the photo's light": _everything,
}


@dataclass(frozen=True)
class Breakdown:
    """What telling each part brings.

    Attributes:
        figures: by row and group ("panoramas", "face" or "lamps", as in `Evaluation.figures`): "relit.psnr" and
            "relit.psnr_aligned" in dB, and of both the gain over "nothing", picture by picture, such as
            figures["relief"]["lamps"]["relit.psnr_gain"], with 95 % intervals over heads.
        samples: pictures in each group.
    """

    figures: dict[str, dict[str, dict[str, Interval]]]
    samples: dict[str, int]
    heads: int


def break_down(
    bundle: NetworkBundle,
    settings: Settings,
    report: Callable[[int, int], None] = lambda done, total: None,
) -> Breakdown:
    """Relight the pictures of `evaluate.evaluate` with every row of `ROWS`; arguments and errors as there."""
    held_out = HeldOut.of(settings)
    editor = Editor(bundle, ReflectionTable(), settings.tier, "cpu")
    bench_of = lambda head: _ToldBench(editor, head, held_out.lights, settings.photos)  # noqa: E731
    rows = held_out.scored(bench_of, report)
    samples = {group: len(scored) for (row, group), scored in rows.items() if row == "nothing"}
    figures = {row: {group: _summed_up(rows[row, group], rows["nothing", group]) for group in samples} for row in ROWS}
    return Breakdown(figures, samples, len(held_out.paths))


class _ToldBench:
    """One head under test; a photo is taken apart once, and made ready once for every row."""

    def __init__(self, editor: Editor, head: HeldOutHead, lights: list[HeldOutLight], photos: Photos):
        self._editor, self._head, self._lights, self._photos = editor, head, lights, photos
        self._true = true_surface(head, lights[0], editor.tier.network_size, editor.device)
        self._ready: dict[int, dict[str, ReadyPhoto]] = {}

    def score(self, case: Case) -> dict[tuple[str, str], Figures]:
        """Figures of one relighting, by row and group."""
        if case.source not in self._ready:
            self._ready[case.source] = self._made_ready(case.source)
        head, target = self._head, self._lights[case.target]
        truth, exposure = head.channels(case.target)["image"], head.exposure(case.target)
        figures = {}
        for row, found in self._ready[case.source].items():
            relit = self._editor.relight(found, target)["composition"]
            for group, mask in masks_of(head, target).items():
                figures[row, group] = score_relit(relit, truth, exposure, head.lit.head.covered, mask)
        return figures

    def _made_ready(self, source: int) -> dict[str, ReadyPhoto]:
        editor, seen = self._editor, self._editor.look(self._head.photo(source, self._photos))
        light = torch.from_numpy(self._lights[source].radiance)[None].to(editor.device)
        told = {row: tell(seen.surface, seen.light, self._true, light) for row, tell in ROWS.items()}
        return {row: editor.ready(editor.told(seen, *parts)) for row, parts in told.items()}


def _summed_up(rows: Rows, untold: Rows) -> dict[str, Interval]:
    heads = np.array([head for head, _ in rows])
    summary = {}
    for name in _MEASURES:
        values, before = (np.array([figures[name] for _, figures in table]) for table in (rows, untold))
        summary[name] = interval_over_heads(values, heads)
        summary[f"{name}_gain"] = interval_over_heads(values - before, heads)
    return summary


def as_record(breakdown: Breakdown) -> dict:
    """One JSON-ready object: by row and group the means, in dB, and the 95 % intervals of both gains."""
    gains = {"gain_interval": "relit.psnr_gain", "aligned_gain_interval": "relit.psnr_aligned_gain"}
    rows = {
        row: {
            group: {name.removeprefix("relit."): value.mean for name, value in figures.items()}
            | {key: [known(bound) for bound in figures[name][1:]] for key, name in gains.items()}
            for group, figures in groups.items()
        }
        for row, groups in breakdown.figures.items()
    }
    return {"rows": rows, "samples": breakdown.samples, "heads": breakdown.heads}


def as_markdown(breakdown: Breakdown, weights: str, settings: Settings) -> str:
    """What was measured, and a table: what each part brings when it is told, in dB of the relit picture."""
    groups = list(breakdown.samples)
    what = (
        f"{weights}; {settings.split} split: {counted(breakdown.heads, 'head')} ({quality_of(settings.tier)}, "
        f"networks at {settings.tier.network_size}), {settings.photos} photos. The first row is the relit picture's "
        f"PSNR, the others are what they add to it. {intervals_in_words(breakdown.heads)}"
    )
    titles = [f"{group} ({breakdown.samples[group]}), {how}" for group in groups for how in ("dB", "one exposure")]
    rows = [
        [row, *(_cell(row, figures[group], name) for group in groups for name in _MEASURES)]
        for row, figures in breakdown.figures.items()
    ]
    lines = ["# Where the error comes from", "", what, "", *markdown_table(["de-lighting is told", *titles], rows)]
    return "\n".join(lines) + "\n"


def _cell(row: str, figures: dict[str, Interval], name: str) -> str:
    if row == "nothing":
        return f"{figures[name].mean:.2f}"
    gain = figures[f"{name}_gain"]
    text = f"{gain.mean:+.2f}"
    return text if math.isnan(gain.low) else f"{text} ({gain.low:+.2f} to {gain.high:+.2f})"
