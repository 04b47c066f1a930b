"""One command's worth of training: a stage, its data, its networks."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import torch
from torch.utils.data import DataLoader, default_collate

from relight_core.dataset.cutouts.outlines import OutlineStream
from relight_core.dataset.gobo_photos import GoboStream
from relight_core.dataset.recipe import data_mark
from relight_core.dataset.stream import SampleStream
from relight_core.errors import InputError
from relight_core.idle_threads import keep_numpy_to_one_thread
from relight_core.imaging.files import file_digest
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import (
    BundleConfig,
    NetworkBundle,
    load_bundle,
    with_detail_pass,
    with_foreign_shadow_network,
    with_narrow_width,
    with_person_network,
    with_residual_blocks,
)
from relight_core.networks.folded_unet import FoldedUNet
from relight_core.networks.foreign_shadow import ForeignShadowConfig, ForeignShadowNetwork
from relight_core.networks.person import PersonConfig, PersonNetwork
from relight_core.training.distillation import Teacher
from relight_core.training.half_kept import halved
from relight_core.training.kept_batches import kept_batches
from relight_core.training.loader_worker import begin_worker
from relight_core.training.loop import Budget, train_stage
from relight_core.training.replay import Replay, replayed
from relight_core.training.stages import STAGES, Stage
from relight_core.training.state import Progress

Batches = Callable[[int], Iterator[dict[str, torch.Tensor]]]

_CHUNK = 4
"""Pairs that a worker hands over together, where they are used again: a batch is drawn from many workers' heads."""

_LONGEST_RISE = 200
"""Steps in which the learning rate rises; a short run rises in a tenth of its own."""


@dataclass(frozen=True)
class Run:
    """Everything that decides a run.

    Attributes:
        stage: a name in STAGES.
        heads: folder of baked shards.
        lights: a light library (.npz), or a folder of panoramas.
        checkpoint: where the weights go, (.safetensors).
        start: weights to go on from; None starts from random ones.
        minutes, steps: length, one of them.
        size, pairs, seed: image side, pairs per batch, random seed.
        workers: processes that make samples; which samples come depends on their number. 0 makes them between steps.
        learning_rate: None takes the stage's own.
        detail_width: give the de-lighting network a sharpening pass of this width, if it has none; 0 leaves it.
        residual: give the de-lighting network's encoder so many residual blocks at each level, finest first, which
            change nothing until they are trained; empty leaves it.
        decoder_residual: the same for its decoder, which has one level fewer.
        narrow_width: channels of the narrow pair that "distil-relight" trains; None keeps the one that is there, or
            takes half as many as the wide pair has.
        examples: how many batches of answers that stage learns from, over and over.
        places: a folder of panoramas that the samples of "outline" are put before, beside drawn scenes.
        kept: a folder of batches that runs share: the same ones in every stage and for all networks.
        uses: how often each pair is learnt from, in the mean (see `replay`); 1 makes new ones for every step.
        window: pairs that are kept for it.
    """

    stage: str
    heads: Path
    lights: Path
    checkpoint: Path
    start: Path | None = None
    minutes: float | None = None
    steps: int | None = None
    size: int = 128
    pairs: int = 8
    seed: int = 0
    workers: int = 1
    learning_rate: float | None = None
    detail_width: int = 0
    residual: tuple[int, ...] = ()
    decoder_residual: tuple[int, ...] = ()
    narrow_width: int | None = None
    examples: int = 150
    places: Path | None = None
    kept: Path | None = None
    uses: int = 1
    window: int = 1024
    config: BundleConfig = BundleConfig()


def train(run: Run, report: Callable[[float, Progress], None]) -> NetworkBundle:
    """Run a stage; see `loop.train_stage` for `report` and what is raised.

    Raises:
        InputError: a stage that learns from trained networks begins with random ones; samples that are not pairs of
            lights are to be used more than once; or the stage's network takes no photos of that size.
    """
    torch.manual_seed(run.seed)
    stage = STAGES[run.stage]
    if run.start is None:
        stage.check_trained((), run.config)
    if stage.samples != "pairs" and run.uses > 1:
        raise InputError(f"{run.stage}: its samples are used once each; only pairs of lights can be used again")
    bundle = _networks_to_train(run, stage)
    if stage.samples != "pairs":
        _check_photos(run, bundle.person if stage.samples == "outlines" else bundle.foreign_shadow)
    budget = Budget(
        run.learning_rate or stage.learning_rate,
        minutes=run.minutes,
        steps=run.steps,
        warm_up_steps=_LONGEST_RISE if run.steps is None else min(_LONGEST_RISE, max(run.steps // 10, 1)),
    )
    device = training_device()
    torch.backends.cudnn.benchmark = True  # All batches have the same shapes.
    run.checkpoint.parent.mkdir(parents=True, exist_ok=True)
    samples = nullcontext(partial(training_batches, run, stage))
    batches = _example_batches(run, stage, bundle, device) if stage.distilled else samples
    with denormals_flushed(), batches as batches_from:
        return train_stage(stage, bundle, batches_from, budget, run.checkpoint, report, device, _begun_with(run, stage))


def _networks_to_train(run: Run, stage: Stage) -> NetworkBundle:
    """The networks that a run starts from, with what the run asks to be added and what its stage trains."""
    bundle = load_bundle(run.start) if run.start else NetworkBundle(run.config)
    if run.detail_width and bundle.delight.detail is None:
        bundle = with_detail_pass(bundle, run.detail_width)
    if run.residual or run.decoder_residual:
        bundle = with_residual_blocks(bundle, run.residual, run.decoder_residual, settled=stage.settled)
    if stage.distilled:
        bundle = with_narrow_width(bundle, _narrow_width(run, bundle))
    if stage.samples == "gobos" and bundle.foreign_shadow is None:
        network = ForeignShadowNetwork(run.config.foreign_shadow or ForeignShadowConfig())
        bundle = with_foreign_shadow_network(bundle, network)
    if stage.samples == "outlines" and bundle.person is None:
        bundle = with_person_network(bundle, PersonNetwork(run.config.person or PersonConfig()))
    return bundle


def _check_photos(run: Run, network: FoldedUNet) -> None:
    """Raise InputError for photos that a network over blocks of 2 x 2 pixels can't learn from."""
    if run.size % 2:
        raise InputError(f"{run.stage}: photos of {run.size} pixels have no whole blocks of 2; give an even size")
    if run.pairs == 1 and run.size <= 2**network.config.levels:
        # Its coarsest level is one pixel then, and of one number there is no deviation to normalise by.
        raise InputError(f"{run.stage}: one photo of {run.size} pixels is too little for a batch; give more or larger")


def _begun_with(run: Run, stage: Stage) -> dict[str, int | str]:
    """What a run that goes on has to be given again: what decides its batches, and the weights it began from."""
    start = "random weights" if run.start is None else file_digest(run.start)[:10]
    begun = drawn_by(run) | {"start": start, "heads and lights": data_mark(run.heads, run.lights)}
    if stage.distilled:
        begun["examples"] = run.examples
    if stage.samples == "outlines":
        begun["places"] = "drawn ones" if run.places is None else data_mark(run.heads, run.places)
    return begun


def drawn_by(run: Run) -> dict[str, int]:
    """What decides which batches a run's heads and lights give; one that goes on with others would not be the same."""
    drawn = {"size": run.size, "pairs": run.pairs, "seed": run.seed, "workers": max(run.workers, 1), "uses": run.uses}
    return drawn | ({"window": run.window} if run.uses > 1 else {})


def training_device() -> str:
    """Where networks are trained: "cuda" if there is such a device, else "cpu"."""
    return "cuda" if torch.cuda.is_available() else "cpu"


def _narrow_width(run: Run, bundle: NetworkBundle) -> int:
    if run.narrow_width is None and bundle.config.narrow is not None:
        return bundle.config.narrow.specular_shadow.width
    return run.narrow_width or bundle.config.specular_shadow.width // 2


@contextmanager
def _example_batches(run: Run, stage: Stage, bundle: NetworkBundle, device: str) -> Iterator[Batches]:
    """The wide pair's answers; they lie beside the checkpoint until the stage ends, or in `run.kept` for good."""
    teacher = Teacher(bundle, ReflectionTable().to(device), device)
    place = run.kept or run.checkpoint.with_suffix(".examples")
    # A run that is killed before its first state leaves nothing else that tells which samples it took.
    samples = "-".join(f"{name}-{value}" for name, value in drawn_by(run).items())
    folder = place / f"{samples}-by-{teacher.name}-of-{data_mark(run.heads, run.lights)}"

    def make(first: int) -> Iterator[dict[str, torch.Tensor]]:
        return map(teacher.examples, training_batches(replace(run, kept=None), stage, first))

    yield lambda first: kept_batches(folder, make, first, among=run.examples)
    # A run that goes on with nothing left of its budget asks for none.
    if run.kept is None and place.exists():
        shutil.rmtree(place)


@contextmanager
def denormals_flushed() -> Iterator[None]:
    """Denormals slow a CPU's convolutions manyfold; the setting is the process's, so it is given back."""
    torch.set_flush_denormal(True)
    try:
        yield
    finally:
        torch.set_flush_denormal(False)


def shared_batches(run: Run, first_batch: int) -> Iterator[dict[str, torch.Tensor]]:
    """The batches that `run.kept` holds, with everything that any stage asks for; made as far as they are missing."""
    folder = run.kept / f"{run.size}px-{run.pairs}-pairs"
    return kept_batches(folder, lambda first: _stream(run, first, photographs=True, relief_shadow=True), first_batch)


def training_batches(run: Run, stage: Stage, first_batch: int) -> Iterator[dict[str, torch.Tensor]]:
    """Batches of a stage's samples from the `first_batch` on, as a run takes them."""
    if run.kept is not None:
        return shared_batches(run, first_batch)
    if stage.samples == "gobos":
        return _loaded(run, GoboStream, first_batch)
    if stage.samples == "outlines":
        return _loaded(run, OutlineStream, first_batch, places=run.places)
    contents = {"photographs": stage.photographs, "relief_shadow": stage.relief_shadow}
    if run.uses == 1:
        return _stream(run, first_batch, **contents)
    chunk = min(_CHUNK, run.pairs)
    again = Replay(run.uses, run.pairs, chunk, run.window, run.seed)
    by_chunk = replace(run, pairs=chunk)
    halves = partial(_stream, by_chunk, collate=_collated_by_half, **contents)
    return replayed(halves, again, first_batch, training_device())


def _stream(run: Run, first_batch: int, **contents) -> Iterator[dict[str, torch.Tensor]]:
    return _loaded(run, SampleStream, first_batch, **contents)


def _loaded(
    run: Run,
    kind: type[SampleStream],
    first_batch: int,
    collate: Callable[[list], dict[str, torch.Tensor]] = default_collate,
    **contents: bool | Path | None,
) -> Iterator[dict[str, torch.Tensor]]:
    stream = kind(
        run.heads, run.lights, "train", run.size, run.seed, first_batch=first_batch, pairs=run.pairs, **contents
    )
    if run.workers:
        # The command has asked for it; whoever trains from Python may not have.
        keep_numpy_to_one_thread()
    loader = DataLoader(
        stream,
        batch_size=run.pairs,
        num_workers=run.workers,
        # Forked off a process that has threads, a worker may wait for ever for a lock that one of them held.
        multiprocessing_context="forkserver" if run.workers else None,
        worker_init_fn=begin_worker,
        prefetch_factor=4 if run.workers else None,
        collate_fn=collate,
        pin_memory=training_device() == "cuda",
        # It draws a seed for its workers, and would draw it from the stream that a run goes on with.
        generator=torch.Generator().manual_seed(run.seed),
    )
    return _in_plain_words(loader)


def _in_plain_words(batches: Iterable[dict[str, torch.Tensor]]) -> Iterator[dict[str, torch.Tensor]]:
    """A loader's batches; what is wrong is told as it was in the worker, without the way there."""
    try:
        yield from batches
    except InputError as error:
        words = str(error.args[0]).strip().splitlines()[-1]
        raise InputError(words.removeprefix(f"{InputError.__module__}.{InputError.__qualname__}: ")) from error
    except RuntimeError as error:
        # PyTorch's own words: of a worker that could not take any or was killed as it wrote there, and of any other.
        if "shared memory" in str(error):
            raise InputError(
                "too little shared memory (/dev/shm) for the samples that the workers hand over; "
                "make it larger (of a container with --shm-size), or give fewer --workers or --pairs"
            ) from error
        if "exited unexpectedly" in str(error) or "signal: Killed" in str(error):
            raise InputError(
                "a process that makes samples was killed, as systems do where memory or /dev/shm runs out; "
                "make room and give the command again, or begin anew with fewer --workers"
            ) from error
        raise


def _collated_by_half(samples: list[dict[str, torch.Tensor]]) -> dict[str, torch.Tensor]:
    """Half as much to hand over from one process to another."""
    return halved(default_collate(samples))
