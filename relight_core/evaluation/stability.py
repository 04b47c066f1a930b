"""The stability report: hostile portraits under hostile lights, and how far every output leaves the lawful.

Each case relights one portrait; each check is a number that would be 0 in a perfect program and has a stated
bound. Pictures are compared as the screen shows them, sRGB in [0, 1].
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch

from relight_core.evaluation.tables import figure_text, markdown_table
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.imaging.view_transform import apply_view
from relight_core.lighting.environment import Environment
from relight_core.networks.precision import has_bf16
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.per_photo.choosing_faces import choose_faces
from relight_core.pipeline.quality import Tier, tier_of
from relight_core.pipeline.relighter import Relighter
from relight_core.pipeline.results.relit import Relit

BOUNDS = {
    "not finite": 0.0,
    "out of range": 0.0,
    "level law": 1e-5,
    "full turn": 1e-3,
    "half a degree": 0.25,
    "draft in bf16": 0.01,
    "live in bf16": 0.01,
    "final in bf16": 0.01,
    "threads": 0.02,
    "own light": 0.02,
}
"""The largest value of each check that is not a failure."""

_TIERS = ("draft", "live", "final")
_TIER = "live"
"""Of all checks but those that name a tier, whose pictures have to be finite and in range as well."""
_DEVICE = "cpu"
_THREADS = (1, 2, 4)
_THREADED_LIGHT = "noise"

_YAW_DEG = 33.0
_LEVEL = 64.0


@dataclass(frozen=True)
class StabilityReport:
    """Worst errors.

    Attributes:
        cases: names of the rows: portrait, light.
        checks: names of the columns, see BOUNDS.
        errors: (cases, checks); NaN where a check was not made.
    """

    cases: tuple[str, ...]
    checks: tuple[str, ...]
    errors: np.ndarray

    @property
    def failures(self) -> list[str]:
        """One line for each error above its bound."""
        return [
            f"{case}: {check} {self.errors[row, column]:.3g} is above {BOUNDS[check]:g}"
            for row, case in enumerate(self.cases)
            for column, check in enumerate(self.checks)
            if self.errors[row, column] > BOUNDS[check]
        ]

    def as_record(self) -> dict:
        """For JSON."""
        rows = {
            case: {
                check: None if np.isnan(error) else float(error) for check, error in zip(self.checks, row, strict=True)
            }
            for case, row in zip(self.cases, self.errors, strict=True)
        }
        return {"bounds": BOUNDS, "cases": rows, "failures": self.failures}

    def as_markdown(self) -> str:
        """A table: the worst case of every check, then every case."""
        rows = {"bound": [BOUNDS[check] for check in self.checks], "**worst**": np.fmax.reduce(self.errors)}
        rows |= zip(self.cases, self.errors, strict=True)
        cells = [[name, *(figure_text(error, ".2g") for error in errors)] for name, errors in rows.items()]
        return "\n".join(markdown_table(["", *self.checks], cells))


def hostile_lights() -> dict[str, np.ndarray]:
    """Panoramas (H, 2H, 3) by name."""
    rng = np.random.default_rng(0)

    def sun(row: int, column: int) -> np.ndarray:
        panorama = np.zeros((64, 128, 3), np.float32)
        panorama[row, column] = 1e6
        return panorama

    return {
        "even": np.ones((16, 32, 3), np.float32),
        "noise": rng.gamma(0.3, 1, (32, 64, 3)).astype(np.float32),
        "sun ahead": sun(28, 2),
        "sun at the seam": sun(20, 127),
        "sun at the pole": sun(0, 9),
        "blue lamp": sun(24, 20) * np.float32([0.02, 0.1, 1]),
        "1 x 2": np.float32([[[4, 1, 0], [0, 1, 4]]]),
        "black": np.zeros((16, 32, 3), np.float32),
    }


def hostile_portraits(photo: Photo) -> dict[str, Photo]:
    """What may have happened to a portrait on its way here, by name."""
    image = photo.linear

    def changed(linear: np.ndarray) -> Photo:
        return replace(photo, linear=np.ascontiguousarray(linear, np.float32))

    noise = np.random.default_rng(1).normal(0, 0.1, image.shape)
    return {
        "as it is": photo,
        "2 EV under": changed(image / 4),
        "4 EV over": changed(np.minimum(image * 16, 1)),
        "grainy": changed(np.clip(image + noise, 0, 1)),
        "monochrome": changed(image.mean(-1, keepdims=True).repeat(3, -1)),
        "red only": changed(image * [1, 0, 0]),
    }


def run_stability(
    photo: Photo,
    *,
    quick: bool = False,
    weights: Path | None = None,
    report: Callable[[int, int], None] = lambda done, total: None,
) -> StabilityReport:
    """Run every check on every case.

    Args:
        photo: a portrait whose face is found.
        quick: two portraits and two lights.
        weights: a file of networks; None takes the bundled one.
        report: called with the cases done and all cases.

    Raises:
        InputError: no face in the photo as it is.
    """
    portraits, lights = hostile_portraits(photo), hostile_lights()
    if quick:
        portraits = {name: portraits[name] for name in ("as it is", "4 EV over")}
        lights = {name: lights[name] for name in ("noise", "sun at the seam")}
    relighter, tier, face = Relighter(weights, _DEVICE), tier_of(_TIER), choose_faces(photo)[0]
    cases, errors = [], []
    for portrait_name, portrait in portraits.items():
        # Framed by hand: what the finder makes of such pictures is another question.
        relighter.set_portrait(portrait, boxes=[face])
        for light_name, panorama in lights.items():
            cases.append(f"{portrait_name}, {light_name}")
            environment = Environment.from_radiance(panorama, light_name)
            found = _errors(relighter, portrait, environment, tier)
            if light_name == _THREADED_LIGHT and (portrait is photo or not quick):
                found[tuple(BOUNDS).index("threads")] = _thread_error(portrait, face, environment, tier, weights)
            errors.append(found)
            report(len(cases), len(portraits) * len(lights))
    return StabilityReport(tuple(cases), tuple(BOUNDS), np.array(errors, np.float64))


def _errors(relighter: Relighter, photo: Photo, environment: Environment, tier: Tier) -> list[float]:
    """In the order of BOUNDS."""
    edit = Edit(quality=tier, yaw_deg=_YAW_DEG, tolerance=0.0)
    shown_level = min(environment.level, 0.5)
    light = Environment(environment.shape, shown_level, environment.name)
    relit = relighter.relight(light, edit)
    extreme = relighter.relight(light, replace(edit, specular=2.0, shadow=2.0))
    brighter = relighter.relight(Environment(environment.shape, shown_level * _LEVEL), edit)
    around = relighter.relight(light, replace(edit, yaw_deg=_YAW_DEG + 360))
    beside = relighter.relight(light, replace(edit, yaw_deg=_YAW_DEG + 0.5))
    own = relighter.relight(relighter.estimated_light(tier), replace(edit, yaw_deg=0.0))
    view = relit.channels["composition"]
    law = np.abs(brighter.channels["composition"] / np.float32(_LEVEL) - view).max() / max(float(view.max()), 1e-12)
    by_precision = [_by_precision(relighter, light, edit, tier_of(name)) for name in _TIERS]
    pictures = (relit, extreme, brighter, around, beside, own, *itertools.chain(*by_precision))
    return [
        max(map(_not_finite, pictures)),
        max(map(_out_of_range, pictures)),
        float(law),
        float(_difference(relit, around).max()),
        float(_difference(relit, beside).max()),
        *(float(_difference(*pair).mean()) if len(pair) == 2 else float("nan") for pair in by_precision),
        float("nan"),
        float(np.abs(apply_view(own.image) - apply_view(photo.linear)).mean()),
    ]


def _by_precision(relighter: Relighter, light: Environment, edit: Edit, tier: Tier) -> list[Relit]:
    """A picture by a tier's networks in fp32, and one in bf16 where that would not be fp32 as well."""
    precisions = ("bf16", "fp32") if has_bf16(_DEVICE) else ("fp32",)
    return [relighter.relight(light, replace(edit, quality=replace(tier, precision=one))) for one in precisions]


def _thread_error(photo: Photo, face: FaceBox, light: Environment, tier: Tier, weights: Path | None) -> float:
    """Largest difference that the number of threads makes, over the whole way from the photo."""
    edit, results, before = Edit(quality=tier, yaw_deg=_YAW_DEG, tolerance=0.0), [], torch.get_num_threads()
    try:
        for count in _THREADS:
            torch.set_num_threads(count)
            relighter = Relighter(weights)
            relighter.set_portrait(photo, boxes=[face])
            results.append(relighter.relight(light, edit))
    finally:
        torch.set_num_threads(before)
    return max(float(_difference(results[0], other).max()) for other in results[1:])


def _difference(one: Relit, other: Relit) -> np.ndarray:
    return np.abs(apply_view(one.channels["composition"]) - apply_view(other.channels["composition"]))


def _not_finite(relit: Relit) -> float:
    """Share of values that are none, over the image and all channels."""
    arrays = [relit.image, *relit.channels.values()]
    return max(float(1 - np.isfinite(array).mean()) for array in arrays)


def _out_of_range(relit: Relit) -> float:
    """How far anything that can't be negative is below 0, or anything shown outside [0, 1]."""
    lows = [relit.image] + [array for name, array in relit.channels.items() if name != "normal"]
    shown = apply_view(relit.image)
    below = max(float(-np.nanmin(array)) for array in lows)
    return max(0.0, below, float(-shown.min()), float(shown.max() - 1))
