"""What a data set is worth: the same small de-lighting network, trained alike on two, shown photos of people.

Photos have no truth, so two things are measured that a network which paints everyone alike gets wrong: how
far the albedo's edges are the photo's, and how far people differ from each other. A third guards against
copying the photo: what of the light's difference between the sides of the face is left in the albedo.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
import torch
from torch.utils.data import DataLoader

from relight_core.dataset.recipe import data_mark
from relight_core.dataset.stream import SampleStream
from relight_core.errors import InputError
from relight_core.face.find import find_faces, find_small_faces
from relight_core.face.parsing import FACE_LABELS
from relight_core.imaging.colour import luminance, srgb_decode, srgb_encode
from relight_core.imaging.files import whole_file
from relight_core.imaging.photo import Photo
from relight_core.imaging.read import read_photo
from relight_core.imaging.tensor_images import as_image, as_tensor
from relight_core.networks.bundle import BundleConfig, NetworkBundle, load_bundle
from relight_core.networks.delight import DelightConfig
from relight_core.pipeline.per_photo.choosing_faces import choose_faces
from relight_core.pipeline.per_photo.portrait import frame
from relight_core.pipeline.relighter import WEIGHTS
from relight_core.pipeline.results.channel_view import channel_to_srgb
from relight_core.resources import resource_path
from relight_core.training.loop import Budget, is_begun, state_path, train_stage
from relight_core.training.run import denormals_flushed
from relight_core.training.stages import STAGES

_PARSED_SIZE = 256
_NOTE = ".lesson.json"
"""Beside a network's weights, by the name that it has had in all folders after --work."""


@dataclass(frozen=True)
class TrainingSettings:
    """How the network is trained.

    Attributes:
        size: side of the images in pixels.
        pairs: pairs of photos in a batch.
        width: the network's channels at full resolution.
    """

    steps: int = 600
    size: int = 64
    pairs: int = 8
    width: int = 12
    seed: int = 0
    learning_rate: float = 1.5e-3


@dataclass(frozen=True)
class DelitFace:
    """One face as a network takes it apart; images are float32 (S, S, 3).

    Attributes:
        photo_srgb, albedo_srgb: in [0, 1].
        normal: unit vectors.
        face: (S, S) bool, the same for every network.
    """

    photo_srgb: np.ndarray
    albedo_srgb: np.ndarray
    normal: np.ndarray
    face: np.ndarray


@dataclass(frozen=True)
class DatasetFigures:
    """Means over photos.

    Attributes:
        detail: correlation of the gradients of log luminance of photo and albedo within the face.
        spread: standard deviation between people of the mean log luminance of the face's albedo.
        light_left: the difference in log luminance of the face's halves that stays in the albedo, as a part
            of the photo's, over the photos whose halves differ by more than a quarter of a stop.
    """

    detail: float
    spread: float
    light_left: float


@dataclass(frozen=True)
class Comparison:
    """Networks side by side.

    Attributes:
        figures: by network.
        pictures: labelled, (S, S, 3) sRGB; for every photo itself, then albedos, then normals.
        photos: how many had a face.
    """

    figures: dict[str, DatasetFigures]
    pictures: list[tuple[str, np.ndarray]]
    photos: int


def trained(
    heads: Path, lights: Path, settings: TrainingSettings, checkpoint: Path, report, *, plain: bool
) -> NetworkBundle:
    """A de-lighting network after its training; `plain` takes the samples as the simplest data set would make them.

    Args:
        checkpoint: where the weights go (.safetensors). Weights that are there are not trained again, and a run
            that was stopped goes on.
        report: see `training.loop.train_stage`.

    Raises:
        InputError: what is there was trained otherwise; and as `training.loop.train_stage`.
    """
    data = data_mark(heads, lights)
    _keep_to_one_training(checkpoint, {**asdict(settings), "heads and lights": data, "plain": plain})
    if checkpoint.exists() and not state_path(checkpoint).exists():
        return load_bundle(checkpoint).eval()
    torch.manual_seed(settings.seed)
    config = replace(BundleConfig.tiny(), delight=DelightConfig(width=settings.width, levels=5))

    def batches_from(first_batch: int) -> Iterator[dict[str, torch.Tensor]]:
        stream = SampleStream(
            heads,
            lights,
            "train",
            settings.size,
            settings.seed,
            plain=plain,
            first_batch=first_batch,
            pairs=settings.pairs,
        )
        # Without one of its own it would draw a seed from the stream that a training goes on with.
        generator = torch.Generator().manual_seed(settings.seed)
        return iter(DataLoader(stream, batch_size=settings.pairs, generator=generator))

    budget = Budget(settings.learning_rate, steps=settings.steps, warm_up_steps=min(100, max(1, settings.steps // 6)))
    stage = STAGES["warm-delight"]
    drawn_by = {"size": settings.size, "pairs": settings.pairs, "seed": settings.seed}
    bundle = NetworkBundle(config)
    with denormals_flushed():
        return train_stage(stage, bundle, batches_from, budget, checkpoint, report, drawn_by=drawn_by).eval()


def _keep_to_one_training(checkpoint: Path, told: dict[str, int | float | str]) -> None:
    """Note how a network is trained; raises InputError where there is one that was trained otherwise."""
    note, words = checkpoint.with_suffix(_NOTE), json.dumps(told)
    if is_begun(checkpoint) and note.exists() and note.read_text() != words:
        raise InputError(
            f"{checkpoint}: was trained otherwise ({note.read_text()}); choose another folder after --work"
        )
    with whole_file(note) as beside:
        beside.write_text(words)


def photos_of_people(paths: list[Path]) -> list[Path]:
    """Those photos in which a face is found.

    Raises:
        InputError: a photo can't be read, or none has a face.
    """
    photos = ((path, read_photo(path).seen) for path in paths)
    people = [path for path, photo in photos if find_faces(photo) or find_small_faces(photo)]
    if not people:
        if len(paths) == 1:
            raise InputError(f"{paths[0]}: no face in this photo; give photos of people")
        raise InputError(f"{paths[0].parent}: no face in any of the photos; give photos of people")
    return people


def compare_photos(networks: dict[str, NetworkBundle], paths: list[Path], size: int) -> Comparison:
    """Show every photo's largest face to every network.

    Args:
        paths: of `photos_of_people`.

    Raises:
        InputError: a photo can't be read.
    """
    parser = load_bundle(resource_path(*WEIGHTS)).for_inference()
    seen: dict[str, list[DelitFace]] = {name: [] for name in networks}
    pictures: list[tuple[str, np.ndarray]] = []
    for path in paths:
        photo = read_photo(path).seen
        row = {name: look(network, parser, photo, size) for name, network in networks.items()}
        for name, found in row.items():
            seen[name].append(found)
        pictures.append(("photo", next(iter(row.values())).photo_srgb))
        pictures += [(f"albedo, {name}", found.albedo_srgb) for name, found in row.items()]
        pictures += [(f"normal, {name}", channel_to_srgb("normal", found.normal)) for name, found in row.items()]
    return Comparison({name: measure(found) for name, found in seen.items()}, pictures, len(paths))


@torch.no_grad()
def look(network: NetworkBundle, parser: NetworkBundle, photo: Photo, size: int) -> DelitFace:
    """Take the photo's largest face apart.

    Args:
        parser: the networks whose parsing says where the face is, at 256 pixels.

    Raises:
        InputError: no face.
    """
    view = frame(photo, choose_faces(photo)[0]).view
    linear = np.clip(view.extract(photo.linear, size), 0, None)
    photo_srgb = srgb_encode(np.clip(linear, 0, 1))
    found = network.delight(as_tensor(photo_srgb))
    seen_srgb = srgb_encode(np.clip(view.extract(photo.linear, _PARSED_SIZE), 0, 1))
    labels = parser.delight(as_tensor(seen_srgb)).parsing_logits.argmax(1)[0].numpy()
    at = (np.arange(size) + 0.5) * len(labels) / size
    face = np.isin(labels[np.ix_(at.astype(int), at.astype(int))], FACE_LABELS)
    return DelitFace(photo_srgb, as_image(found.albedo_srgb), as_image(found.normal), face)


def measure(seen: list[DelitFace]) -> DatasetFigures:
    """Figures of a network over photos, one face each; NaN where no photo allows one."""
    details = [_gradient_correlation(s) for s in seen if s.face.sum() > 30]
    tones = [_log_luminance(s.albedo_srgb)[s.face].mean() for s in seen if s.face.any()]
    sides = [_sides(s) for s in seen]
    left = [albedo / photo for photo, albedo in sides if abs(photo) > 0.25]
    return DatasetFigures(
        float(np.mean(details)) if details else np.nan,
        float(np.std(tones)) if tones else np.nan,
        float(np.mean(left)) if left else np.nan,
    )


def _gradient_correlation(seen: DelitFace) -> float:
    inner = seen.face[:-1, :-1] & seen.face[1:, :-1] & seen.face[:-1, 1:]
    slopes = []
    for image in (seen.photo_srgb, seen.albedo_srgb):
        level = _log_luminance(image)
        down, right = level[1:, :-1] - level[:-1, :-1], level[:-1, 1:] - level[:-1, :-1]
        slopes.append(np.concatenate([down[inner], right[inner]]))
    return float(np.corrcoef(*slopes)[0, 1]) if min(s.std() for s in slopes) > 0 else 0.0


def _sides(seen: DelitFace) -> tuple[float, float]:
    """Left half less right half of the face, in stops: of the photo and of the albedo."""
    columns = np.nonzero(seen.face)[1]
    if len(columns) == 0:
        return 0.0, 0.0
    left = seen.face & (np.arange(seen.face.shape[1]) < np.median(columns))
    right = seen.face & ~left
    if not (left.any() and right.any()):
        return 0.0, 0.0
    levels = [_log_luminance(image) for image in (seen.photo_srgb, seen.albedo_srgb)]
    photo, albedo = (float(level[left].mean() - level[right].mean()) for level in levels)
    return photo, albedo


def _log_luminance(srgb: np.ndarray) -> np.ndarray:
    """Stops; what is darker than 1 % counts as 1 %."""
    return np.log2(np.maximum(luminance(srgb_decode(srgb)), 0.01))
