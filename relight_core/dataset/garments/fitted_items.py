"""The MakeHuman items that suit a portrait, fitted to the mean head and bound to it; kept in a cache."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from relight_core.dataset.archive import DAMAGE
from relight_core.dataset.garments.garment import Garment
from relight_core.dataset.garments.garment_binding import Binding, bind, scattered
from relight_core.dataset.garments.garment_mesh import compact
from relight_core.dataset.garments.makehuman import Item, cut_by_opacity, find_root, read_base, read_item, refine
from relight_core.dataset.garments.makehuman_fit import HeadWarp
from relight_core.dataset.heads import OUTER_SKIN, HeadModel
from relight_core.errors import InputError
from relight_core.imaging.files import whole_file

_CACHE_VERSION = 3
_FIELDS = ("vertices", "faces", "uv", "opacity", "colour_srgb")
"""Of an item, as they are kept."""
_FOLDERS = {"hair": "hair", "eyebrows": "brow"}
_CLOTHES = {
    "glasses": "glasses",
    "fedora": "hat",
    "male_casualsuit01": "cloth",
    "female_casualsuit01": "cloth",
}
_BEARDS = ("Full_beard", "Moustache")
# Its layers of loose cards do not survive as opaque triangles; a hair shell stands in for it.
_LEFT_OUT = ("afro01",)
_MOST_FACES = {
    "hair": 60_000,
    "beard": 15_000,
    "brow": 6_000,
    "glasses": 30_000,
    "hat": 30_000,
    "cloth": 60_000,
}
_DEEPEST = {"brow": 3}
# Coarse meshes that have to yield to the shape beneath them.
_REFINED = {"cloth": 1, "hat": 2}
_LOWEST_CM = -45.0
_OPAQUE_FRAME = 0.9


@dataclass(frozen=True)
class FittedItem:
    """An item on the mean head. `kind` is "hair", "beard", "brow", "glasses", "hat" or "cloth"."""

    name: str
    kind: str
    vertices: np.ndarray
    faces: np.ndarray
    uv: np.ndarray
    opacity: np.ndarray | None
    colour_srgb: np.ndarray | None
    binding: Binding

    @property
    def label(self) -> str:
        """The garment's label: a beard is hair."""
        return "hair" if self.kind == "beard" else self.kind

    def as_garment(self, vertices: np.ndarray) -> Garment:
        """The item with other vertex positions (V, 3)."""
        return Garment(
            vertices.astype(np.float32),
            self.faces,
            self.uv,
            self.label,
            self.opacity,
            self.colour_srgb,
            self.name,
        )


def load_fitted_items(folder: Path, model: HeadModel) -> list[FittedItem]:
    """All items, from the cache beside the data where it belongs to this head model, else fitted now.

    Raises:
        InputError: the folder holds no MakeHuman data, damaged data, or not all of it: some head
            would find nothing to put on.
    """
    root = find_root(folder)
    digest = hashlib.sha256(model.mean.tobytes() + bytes([_CACHE_VERSION])).hexdigest()[:12]
    cache = root / f"fitted-{digest}.npz"
    stored = _read_cache(cache) if cache.is_file() else None
    if stored is None or _missing(stored):
        stored = _fit_all(root, model)
        if missing := _missing(stored):
            kinds = " and no ".join(missing)
            raise InputError(f"{folder}: no {kinds} here; give the whole MakeHuman archive, unpacked")
        _write_cache(cache, stored)
    return [
        FittedItem(i.name, kind, i.vertices, i.faces, i.uv, i.opacity, i.colour_srgb, _bind(kind, i.vertices, model))
        for kind, i in stored
    ]


def _missing(stored: list[tuple[str, Item]]) -> list[str]:
    """The kinds of which there is no item."""
    there = {kind for kind, _ in stored}
    return [kind for kind in _MOST_FACES if kind not in there]


def _fit_all(root: Path, model: HeadModel) -> list[tuple[str, Item]]:
    base, body = read_base(root)
    warp = HeadWarp(base, body, model)
    fitted = []
    for path in sorted((root / "proxies").glob("*/*/*.json")):
        kind = _CLOTHES.get(path.stem) or _FOLDERS.get(path.parent.parent.name)
        if kind is None or path.stem in _LEFT_OUT:
            continue
        kind = "beard" if path.stem in _BEARDS else kind
        whole = read_item(path, base)
        for _ in range(_REFINED.get(kind, 0)):
            whole = refine(whole)
        item = cut_by_opacity(whole, _MOST_FACES[kind], _DEEPEST.get(kind, 2))
        if kind == "glasses":
            fitted.append((kind, _placed(replace(item, name="sunglasses"), warp)))
            item = cut_by_opacity(whole, _MOST_FACES[kind], least_opacity=_OPAQUE_FRAME)
        fitted.append((kind, _placed(item, warp)))
    return fitted


def _placed(item: Item, warp: HeadWarp) -> Item:
    """The item on the mean head, without what hangs far below any portrait's edge."""
    vertices = warp(item.vertices)
    faces = item.faces[(vertices[item.faces][..., 1] > _LOWEST_CM).all(1)]
    faces, vertices, uv = compact(faces, vertices, item.uv)
    return replace(item, vertices=vertices, faces=faces, uv=uv)


def _bind(kind: str, vertices: np.ndarray, model: HeadModel) -> Binding:
    """Bind brows and beards to the skin under them, hair to the skull, cloth to the neck."""
    skin = model.vertices_of(*OUTER_SKIN)
    points = model.mean[skin]
    if kind in ("brow", "beard"):
        return bind(vertices, model.mean, skin, 8)
    if kind == "cloth":
        near = skin[points[:, 1] < -9]
    else:
        near = skin[((points[:, 1] > 6) | (points[:, 2] < 5)) & (np.abs(points[:, 0]) < 8)]
    near = near[scattered(model.mean[near], 1.2)]
    return bind(vertices, model.mean, near, 24)


def _write_cache(path: Path, stored: list[tuple[str, Item]]) -> None:
    arrays = {"names": np.array([f"{kind}/{item.name}" for kind, item in stored])}
    for number, (_, item) in enumerate(stored):
        for field in _FIELDS:
            value = getattr(item, field)
            if value is not None:
                arrays[f"{number}/{field}"] = value
    with whole_file(path) as beside, open(beside, "wb") as file:
        np.savez(file, **arrays)


def _read_cache(path: Path) -> list[tuple[str, Item]] | None:
    """What `_write_cache` wrote; None where that is damaged, for it can be made again."""
    try:
        with np.load(path, allow_pickle=False) as data:
            arrays = {name: data[name] for name in data.files}
        items = [str(both).split("/") for both in arrays["names"]]
        return [
            (kind, Item(name, *(arrays.get(f"{number}/{field}") for field in _FIELDS)))
            for number, (kind, name) in enumerate(items)
        ]
    except DAMAGE:
        return None
