"""From a seed to a baked head: who it is, what it does and wears, where it looks."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from relight_core.dataset.bake import BakedHead, bake
from relight_core.dataset.dressing import Wardrobe
from relight_core.dataset.face_map import face_label_map, face_vertices
from relight_core.dataset.framing import Framing, sample_framing
from relight_core.dataset.heads import (
    HeadModel,
    load_head_model,
    pose,
    sample_expression,
    sample_pose,
    shape_head,
    turn_eyes,
)
from relight_core.dataset.scene import Scene, build_scene
from relight_core.dataset.shard import read_shard, write_shard

SPLIT_SEEDS = {"train": 0, "validation": 1_000_000, "test": 2_000_000}
"""First seed of each split: identities never repeat across splits."""
_WIDEST_IDENTITY = 2.5


@dataclass(frozen=True)
class PosedHead:
    """A dressed head before the camera; `rng` goes on to the shadow rays' jitter."""

    scene: Scene
    framing: Framing
    rng: np.random.Generator


@dataclass
class Casting:
    """Everything that is loaded once to make heads; `wardrobe` None leaves them bald and bare."""

    model: HeadModel
    wardrobe: Wardrobe | None
    face_labels: np.ndarray
    face_vertices: np.ndarray

    @classmethod
    def load(cls, head_model: Path, makehuman: Path | None) -> Casting:
        """Read the head model (.npz) and, where given, the unpacked MakeHuman folder."""
        model = load_head_model(head_model)
        labels = face_label_map(model)
        wardrobe = Wardrobe(makehuman, model) if makehuman is not None else None
        return cls(model, wardrobe, labels, face_vertices(model, labels))

    def bake_head(self, seed: int, size: int = 256) -> BakedHead:
        """The head that belongs to a seed: the same on every machine with the same sources."""
        return self.bake(self.pose_head(seed, size), size)

    def bake(self, posed: PosedHead, size: int) -> BakedHead:
        """Bake a head that stands before the camera."""
        return bake(posed.scene, posed.framing, self.face_labels, size, posed.rng)

    def pose_head(self, seed: int, size: int = 256) -> PosedHead:
        """The person of a seed, dressed, before the camera."""
        rng = np.random.default_rng(seed)
        modes = len(self.model.identity)
        identity = np.clip(rng.standard_normal(modes), -_WIDEST_IDENTITY, _WIDEST_IDENTITY)
        vertices = shape_head(self.model, identity, sample_expression(self.model, rng))
        vertices = turn_eyes(self.model, vertices, rng.uniform(-25, 25), rng.uniform(-12, 12))
        rotation = sample_pose(rng)
        garments = self.wardrobe.dress(vertices, rng) if self.wardrobe is not None else []
        framing = sample_framing(pose(vertices, rotation)[self.face_vertices], rng, size)
        return PosedHead(build_scene(self.model, vertices, garments, rotation), framing, rng)


def shard_path(folder: Path, seed: int) -> Path:
    """Where the head of a seed is stored."""
    return folder / f"head-{seed:07d}.npz"


def bake_missing(casting: Casting, folder: Path, seeds: range, size: int = 256):
    """Bake the heads that are not there yet; a killed run goes on where it stopped.

    Yields:
        The path of each finished head.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for seed in seeds:
        path = shard_path(folder, seed)
        if not path.exists():
            write_shard(path, casting.bake_head(seed, size))
        yield path


def load_split(folder: Path, split: str) -> list[Path]:
    """Paths of the heads of one split that are baked, in order of seed."""
    first = SPLIT_SEEDS[split]
    last = min((s for s in SPLIT_SEEDS.values() if s > first), default=first + 1_000_000)
    paths = sorted(folder.glob("head-*.npz"))
    return [path for path in paths if first <= int(path.stem.split("-")[1]) < last]


__all__ = ["SPLIT_SEEDS", "Casting", "bake_missing", "load_split", "read_shard", "shard_path"]
