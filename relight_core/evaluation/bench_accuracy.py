"""The error of every configuration: against the truth on test heads, against the final tier on photos."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from relight_core.evaluation.bench import Bench, Editor
from relight_core.evaluation.bench_configurations import Configuration
from relight_core.evaluation.held_out import (
    Case,
    cases_of,
    held_out_lights,
    held_out_paths,
    held_out_textures,
    load_head,
)
from relight_core.evaluation.scoring import Figures
from relight_core.face.crop import Crop
from relight_core.imaging.photo import Photo
from relight_core.imaging.view_transform import apply_view
from relight_core.lighting.environment import Environment
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import NetworkBundle
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.relighter import Relighter

_YAWS_DEG = (0.0, 110.0, -75.0)


@dataclass
class Accuracy:
    """Errors of a configuration; None where nothing was given to measure them on.

    Attributes:
        rmse, psnr: of pictures relit from photos of test heads, sRGB, over the head.
        against_final: RMSE of pictures of photos against those of the final tier, sRGB, over the face's crop.
    """

    rmse: float | None = None
    psnr: float | None = None
    against_final: float | None = None


@dataclass(frozen=True)
class HeldOutData:
    """Baked heads of the test split and the light library; `cases` relightings of each head."""

    heads: Path
    lights: Path
    count: int
    cases: int


def against_truth(
    bundle: NetworkBundle,
    data: HeldOutData,
    configurations: Sequence[Configuration],
    report: Callable[[int, int], None] = lambda done, total: None,
    device: str = "cpu",
) -> dict[str, Accuracy]:
    """Relight photos of test heads under panoramas, by the stages of the editor.

    Raises:
        InputError: heads or lights are missing or damaged.
    """
    lights = held_out_lights(data.lights, "test")
    paths = held_out_paths(data.heads, "test", data.count)
    table, textures = ReflectionTable().to(device), held_out_textures()
    scored: dict[str, list[Figures]] = {configuration.name: [] for configuration in configurations}
    for number, path in enumerate(paths):
        head = load_head(path, lights, textures)
        cases = _few([case for case in cases_of(number, lights) if not lights[case.target].lamp], data.cases)
        for place, configuration in enumerate(configurations):
            bench = Bench(Editor(bundle, table, configuration.tier, device), head, lights, "clean")
            scored[configuration.name] += [bench.score(case)["panoramas"] for case in cases]
            report(number * len(configurations) + place + 1, len(paths) * len(configurations))
    return {
        name: Accuracy(*(float(np.mean([one[f"relit.{measure}"] for one in figures])) for measure in ("rmse", "psnr")))
        for name, figures in scored.items()
    }


def _few(cases: list[Case], count: int) -> list[Case]:
    """At most `count` of them, evenly spread."""
    return [cases[i] for i in np.unique(np.linspace(0, len(cases) - 1, min(count, len(cases))).round().astype(int))]


def against_final(
    relighter: Relighter,
    photos: Sequence[Photo],
    environments: Sequence[Environment],
    configurations: Sequence[Configuration],
    report: Callable[[int, int], None] = lambda done, total: None,
) -> dict[str, float]:
    """RMSE of the relit pictures against those at final quality, sRGB in [0, 1]; the last photo stays set.

    Raises:
        InputError: a photo without a face.
    """
    squares: dict[str, list[float]] = {configuration.name: [] for configuration in configurations}
    for number, photo in enumerate(photos):
        relighter.set_portrait(photo)
        for index, environment in enumerate(environments):
            edit = Edit(yaw_deg=_YAWS_DEG[index % len(_YAWS_DEG)], channels=(), quality="final")
            reference = relighter.relight(environment, edit)
            part = _face_part(reference.faces[0], photo)
            expected = apply_view(reference.image[part])
            for configuration in configurations:
                edit_here = Edit(yaw_deg=edit.yaw_deg, channels=(), quality=configuration.tier)
                shown = apply_view(relighter.relight(environment, edit_here).image[part])
                squares[configuration.name].append(float(((shown - expected) ** 2).mean()))
            report(number * len(environments) + index + 1, len(photos) * len(environments))
    return {name: float(np.sqrt(np.mean(values))) for name, values in squares.items()}


def _face_part(face, photo: Photo) -> tuple[slice, slice]:
    """Rows and columns of the face's box within the photo."""
    height, width = photo.linear.shape[:2]
    x0, y0, x1, y1 = Crop((face.x0 + face.x1) / 2, (face.y0 + face.y1) / 2, max(face.width, face.height)).window
    rows = slice(int(np.clip(y0, 0, height - 1)), int(np.clip(np.ceil(y1), 1, height)))
    return rows, slice(int(np.clip(x0, 0, width - 1)), int(np.clip(np.ceil(x1), 1, width)))
