"""From a seed to a baked head: identity, expression, clothes, gaze and pose."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from relight_core.dataset.baking.bake import BakedHead, bake
from relight_core.dataset.baking.framing import Framing, sample_framing
from relight_core.dataset.baking.scene import FROM_FACE_MAP, Scene, build_scene
from relight_core.dataset.baking.shard import shard_size, write_shard
from relight_core.dataset.face_map import face_label_map, face_vertices
from relight_core.dataset.garments.dressing import Shares, Wardrobe
from relight_core.dataset.heads import (
    HeadModel,
    load_head_model,
    pose,
    sample_expression,
    sample_pose,
    shape_head,
    turn_eyes,
)
from relight_core.dataset.lighting.light_folder import panoramas_in
from relight_core.dataset.painting.skin_textures import FILE_NAME as SKINS
from relight_core.dataset.painting.texture import look_up
from relight_core.dataset.scans import names_of_people, people_of, read_scan
from relight_core.errors import InputError
from relight_core.imaging.file_lock import let_go, locked
from relight_core.imaging.files import file_bytes, remove_unfinished, whole_file

SPLIT_SEEDS = {"train": 0, "validation": 1_000_000, "test": 2_000_000}
"""First seed of each split: identities never repeat across splits."""
SPLIT_SIZE = 1_000_000
"""Seeds of each split."""

_WIDEST_IDENTITY = 2.5
_NAMES = "people.txt"


@dataclass(frozen=True)
class PosedHead:
    """A head before the camera.

    Attributes:
        face_labels: label map for the parts that the scene labels `FROM_FACE_MAP`.
        rng: the seed's random generator, which goes on to jitter the shadow rays.
        texture: (T, T, 3) linear albedo of a scan; None where albedo is painted.
    """

    scene: Scene
    framing: Framing
    face_labels: np.ndarray
    rng: np.random.Generator
    texture: np.ndarray | None = None

    def bake(self, size: int) -> BakedHead:
        """The head's transport for any light, as an image of size x size pixels."""
        head = bake(self.scene, self.framing, self.face_labels, size, self.rng)
        return head if self.texture is None else replace(head, albedo=look_up(self.texture, head.uv))


def load_casting(heads: Path, makehuman: Path | None, shares: Shares | None = None) -> Casting | ScanCasting:
    """The source of heads: a head model (.npz), dressed from MakeHuman, or a folder of scans.

    Args:
        shares: how many heads wear the rarer garments; None for the defaults.

    Raises:
        InputError: neither is there, it is damaged, or a wardrobe is given for scans, which wear what they were scanned
            in.
    """
    if not heads.is_dir():
        return Casting.load(heads, makehuman, shares)
    if makehuman is not None:
        raise InputError(f"{heads}: scans wear what they were scanned in; leave --wardrobe out")
    people_of(heads, "train")
    return ScanCasting(heads)


@dataclass
class Casting:
    """A head model and what dresses it, loaded once; `wardrobe` None leaves heads bald and bare."""

    model: HeadModel
    wardrobe: Wardrobe | None
    face_labels: np.ndarray
    face_vertices: np.ndarray

    @classmethod
    def load(cls, head_model: Path, makehuman: Path | None, shares: Shares | None = None) -> Casting:
        """Read the head model (.npz) and, where given, the unpacked MakeHuman folder (see `Wardrobe`)."""
        model = load_head_model(head_model)
        labels = face_label_map(model)
        wardrobe = Wardrobe(makehuman, model, shares) if makehuman is not None else None
        return cls(model, wardrobe, labels, face_vertices(model, labels))

    def pose_head(self, seed: int) -> PosedHead:
        """The person of a seed, dressed and posed; the same wherever sources and shares are the same."""
        rng = np.random.default_rng(seed)
        modes = len(self.model.identity)
        identity = np.clip(rng.standard_normal(modes), -_WIDEST_IDENTITY, _WIDEST_IDENTITY)
        vertices = shape_head(self.model, identity, sample_expression(self.model, rng))
        vertices = turn_eyes(self.model, vertices, rng.uniform(-25, 25), rng.uniform(-12, 12))
        rotation = sample_pose(rng)
        garments = self.wardrobe.dress(vertices, rng) if self.wardrobe is not None else []
        framing = sample_framing(pose(vertices, rotation)[self.face_vertices], rng)
        scene = build_scene(self.model, vertices, garments, rotation)
        return PosedHead(scene, framing, self.face_labels, rng)


@dataclass
class ScanCasting:
    """A folder of scanned people (see `scans`)."""

    folder: Path

    def keep_to_people(self, heads: Path) -> None:
        """Make sure that all heads of a folder come from the same people, since the splits depend on all of them.

        Raises:
            InputError: the folder has heads of other people, or the note on them can't be written.
        """
        note, names = heads / _NAMES, "\n".join(names_of_people(self.folder)).encode(errors="surrogateescape")
        if not note.exists():
            with whole_file(note) as beside:
                beside.write_bytes(names)
        elif file_bytes(note) != names:
            raise InputError(f"{heads}: its heads are of other people than {self.folder} holds; choose a new folder")

    def pose_head(self, seed: int) -> PosedHead:
        """One scan of the person of a seed, posed; consecutive seeds take the people in turn.

        Raises:
            InputError: the scan can't be read, or nobody is in the seed's split.
        """
        rng = np.random.default_rng(seed)
        split = max((name for name in SPLIT_SEEDS if SPLIT_SEEDS[name] <= seed), key=SPLIT_SEEDS.get)
        people = people_of(self.folder, split)
        meshes = people[(seed - SPLIT_SEEDS[split]) % len(people)]
        scan = read_scan(meshes[rng.integers(len(meshes))])
        vertices = pose(scan.vertices, sample_pose(rng))
        scene = Scene(
            vertices,
            scan.triangles,
            scan.corner_uv,
            scan.material,
            np.full(len(scan.triangles), FROM_FACE_MAP, np.uint8),
        )
        return PosedHead(scene, sample_framing(vertices[scan.face], rng), scan.labels, rng, scan.albedo)


def shard_path(folder: Path, seed: int) -> Path:
    """Where the head of a seed is stored."""
    return folder / f"head-{seed:07d}.npz"


def bake_missing(casting: Casting | ScanCasting, folder: Path, seeds: range, size: int = 256):
    """Bake the heads that are not there yet, so that a killed run can be resumed.

    Yields:
        The path of each finished head.

    Raises:
        InputError: as `keep_to_people` and `pose_head` of scans; or a head is there in another size.
    """
    folder.mkdir(parents=True, exist_ok=True)
    if isinstance(casting, ScanCasting):
        casting.keep_to_people(folder)
    for seed in seeds:
        path = shard_path(folder, seed)
        if not path.exists():
            with _only_bake(path):
                write_shard(path, casting.pose_head(seed).bake(size))
        elif (found := shard_size(path)) != size:
            raise InputError(f"{path}: is {found} pixels wide and not {size}; choose a new folder, or delete it")
        yield path


@contextmanager
def _only_bake(path: Path) -> Iterator[None]:
    """Remove the unfinished file of a bake that was killed, unless another process is baking the same head now.

    That process is not waited for: both bake the same.
    """
    lock, file = path.with_suffix(".lock"), None
    with suppress(OSError):
        file = locked(lock)
    if file is not None:
        remove_unfinished(path)
    try:
        yield
    finally:
        if file is not None:
            let_go(file, lock)


def load_split(folder: Path, split: str) -> list[Path]:
    """Paths of the heads of one split that are baked, in order of seed."""
    first = SPLIT_SEEDS[split]
    seeds = ((path, path.stem.removeprefix("head-")) for path in sorted(folder.glob("head-*.npz")))
    # Copies made by a file manager have other names.
    return [path for path, seed in seeds if seed.isdecimal() and first <= int(seed) < first + SPLIT_SIZE]


def data_mark(heads: Path, lights: Path) -> str:
    """A hash of the names and sizes of all files of a training set: heads, painted skins and lights."""
    skins = heads / SKINS
    beside = [skins] if skins.exists() else []
    files = [*load_split(heads, "train"), *beside, *(panoramas_in(lights) if lights.is_dir() else [lights])]
    listed = json.dumps([[path.name, path.stat().st_size] for path in files])
    return hashlib.sha256(listed.encode()).hexdigest()[:10]
