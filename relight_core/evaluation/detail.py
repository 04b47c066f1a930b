"""How well the light's change is carried from the networks' size to the photo's (docs/detail.md).

Held-out heads are rendered large under two lights. The picture under the second, shrunk to the networks'
size, stands for a perfect network; every method carries it back to the full size with the picture under
the first as its photo, and is compared with the picture it should have become. A real network blurs colour
too: the same again with the albedo blurred within the small picture.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from relight_core.dataset.baking.shard import shard_size
from relight_core.errors import InputError
from relight_core.evaluation.counted import counted
from relight_core.evaluation.detail_methods import METHODS, DetailTask
from relight_core.evaluation.held_out import (
    HeldOutHead,
    HeldOutLight,
    held_out_lights,
    held_out_paths,
    held_out_textures,
    load_head,
)
from relight_core.evaluation.tables import figure_text, markdown_table
from relight_core.face.parsing import CLASSES, EYES, INDEX
from relight_core.imaging.colour import srgb_encode
from relight_core.imaging.resampling import resize_area
from relight_core.pipeline.results.channels import materials_of

REGIONS = ("head", "eyes", "hair", "cast shadow", "photo's shadow", "outline, head", "outline, background")

_NETWORK_SIZE = 128
_BACKGROUND = 0.45
_PANORAMAS, _LAMPS = 3, 2
_STEEP_SHADOW = 0.06
_BLUR_PX = 1.2
_EYES = [INDEX[name] for name in EYES]


@dataclass(frozen=True)
class DetailScores:
    """Mean RMS error in sRGB codes of 255, by method and region; NaN where no head has the region.

    Attributes:
        errors: with a perfect small picture.
        blurred: with one whose albedo is blurred.
    """

    errors: dict[str, dict[str, float]]
    blurred: dict[str, dict[str, float]]
    pictures: int
    size: int


def compare_detail(
    heads: Path, lights: Path, split: str, count: int, report: Callable[[int, int], None] = lambda done, total: None
) -> DetailScores:
    """Run every method on heads of a split; they should be baked large (`relight dataset bake --size 1024`).

    Raises:
        InputError: heads or lights are missing or damaged, or a head is smaller than what the networks see.
    """
    library, paths = held_out_lights(lights, split), held_out_paths(heads, split, count)
    _check_sizes(paths)
    pool, size, done = held_out_textures(), 0, 0
    total = sum(len(_pairs(_chosen(library, number))) for number in range(len(paths)))
    rows = {kind: defaultdict(list) for kind in ("errors", "blurred")}
    for number, path in enumerate(paths):
        chosen = _chosen(library, number)
        head = load_head(path, chosen, pool)
        size = head.lit.head.size
        for source, target in _pairs(chosen):
            for kind in rows:
                for method, errors in _score(head, source, target, kind == "blurred").items():
                    rows[kind][method].append(errors)
            done += 1
            report(done, total)
    means = {kind: {method: _means(errors) for method, errors in of.items()} for kind, of in rows.items()}
    return DetailScores(**means, pictures=done, size=size)


def _check_sizes(paths: list[Path]) -> None:
    """Raise InputError for a head that would have to be enlarged to the networks' size: it has no detail to carry."""
    for path in paths:
        if (size := shard_size(path)) < _NETWORK_SIZE:
            raise InputError(
                f"{path}: a head of {size} pixels is smaller than the {_NETWORK_SIZE} that the networks see; "
                "bake heads with --size 1024"
            )


def detail_table(scores: DetailScores) -> str:
    """The scores as a table in Markdown."""
    lines = []
    for title, rows in (("perfect", scores.errors), ("albedo blurred", scores.blurred)):
        cells = [[method, *(figure_text(errors[name], ".2f") for name in REGIONS)] for method, errors in rows.items()]
        lines += [*markdown_table([title, *REGIONS], cells), ""]
    return "\n".join(lines) + f"RMS in sRGB codes, {counted(scores.pictures, 'relighting')} at {scores.size} pixels.\n"


def _means(rows: list[list[float]]) -> dict[str, float]:
    columns = [[error for error in column if not np.isnan(error)] for column in zip(*rows, strict=True)]
    return {
        region: float(np.mean(column)) if column else float("nan")
        for region, column in zip(REGIONS, columns, strict=True)
    }


def _chosen(library: list[HeldOutLight], number: int) -> list[HeldOutLight]:
    panoramas, lamps = ([light for light in library if light.lamp == kind] for kind in (False, True))
    first = _PANORAMAS * number
    chosen = [panoramas[(first + i) % len(panoramas)] for i in range(_PANORAMAS)]
    return chosen + [lamps[(number + i) % len(lamps)] for i in range(_LAMPS)]


def _pairs(chosen: list[HeldOutLight]) -> list[tuple[int, int]]:
    """Source and target among the chosen lights: one panorama to all others, another to the lamps, and back from them.

    Fewer than three panoramas come around again; a photo relit with its own light would tell nothing.
    """
    lamps = range(_PANORAMAS, _PANORAMAS + _LAMPS)
    pairs = [(0, target) for target in (*range(1, _PANORAMAS), *lamps)] + [(1, lamp) for lamp in lamps]
    pairs += [(lamp, 0) for lamp in lamps]
    return [(source, target) for source, target in pairs if chosen[source] is not chosen[target]]


def _score(head: HeldOutHead, source: int, target: int, blurred: bool) -> dict[str, list[float]]:
    covered = head.lit.head.covered
    behind = (_BACKGROUND * ~covered)[..., None].astype(np.float32)
    channels, exposure = head.channels(target), head.exposure(target)
    photo, truth = head.photo(source, "clean") + behind, channels["image"] * exposure + behind
    gloss = np.repeat(channels["specular"][..., None] * exposure, 3, axis=2)
    labels = head.surface()["label"]
    small = (_NETWORK_SIZE,) * 2
    materials = materials_of(resize_area(np.eye(len(CLASSES), dtype=np.float32)[labels], small))
    task = DetailTask(photo, *(resize_area(image, small) for image in (photo, truth, gloss)), materials)
    if blurred:
        albedo = resize_area(head.surface()["albedo"] + 2 * behind, small)
        ratio = cv2.GaussianBlur(albedo, (0, 0), _BLUR_PX) / np.maximum(albedo, 1e-3)
        matt = np.maximum(task.relit_small - task.gloss_small, 0)
        task = replace(task, relit_small=matt * ratio + task.gloss_small)
    shadows = (light["shadow_fraction"] for light in (channels, head.channels(source)))
    masks = list(_masks(covered, labels, *shadows))
    shown = _display(truth)
    pictures = {name: _display(method(task)) for name, method in METHODS.items()}
    return {name: [_error(picture, shown, mask) for mask in masks] for name, picture in pictures.items()}


def _masks(
    covered: np.ndarray, labels: np.ndarray, shadow: np.ndarray, photos_shadow: np.ndarray
) -> Iterator[np.ndarray]:
    """(S, S) bool, one for each of REGIONS."""
    step = max(covered.shape[0] // 64, 1)
    outline = cv2.morphologyEx(covered.astype(np.uint8), cv2.MORPH_GRADIENT, np.ones((step + 1, step + 1))) > 0
    yield covered
    yield cv2.dilate(np.isin(labels, _EYES).astype(np.uint8), np.ones((step, step))) > 0
    yield labels == INDEX["hair"]
    for ending in (shadow, photos_shadow):
        smooth = cv2.blur(ending.astype(np.float32), (9, 9))
        slope = cv2.magnitude(*(cv2.Sobel(smooth, cv2.CV_32F, *axis) for axis in ((1, 0), (0, 1))))
        yield (slope > _STEEP_SHADOW) & covered & ~outline
    yield outline & covered
    yield outline & ~covered


def _display(linear: np.ndarray) -> np.ndarray:
    return 255 * srgb_encode(np.clip(linear, 0, 1))


def _error(shown: np.ndarray, expected: np.ndarray, mask: np.ndarray) -> float:
    return float(np.sqrt(np.square(shown[mask] - expected[mask]).mean())) if mask.any() else float("nan")
