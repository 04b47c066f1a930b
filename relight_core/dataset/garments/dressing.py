"""Dressing heads for portraits: a wardrobe that is fitted once and follows every head."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from relight_core.dataset.garments.adornments import NeckAndEars
from relight_core.dataset.garments.beard_shell import BeardPatch
from relight_core.dataset.garments.fitted_items import FittedItem, load_fitted_items
from relight_core.dataset.garments.garment import Garment
from relight_core.dataset.garments.garment_binding import HeadSurface, fit_affine
from relight_core.dataset.garments.garment_mesh import fractal, smoothstep, vertex_normals
from relight_core.dataset.garments.hair_mass import grow_mass
from relight_core.dataset.garments.hair_shell import ScalpGrid, grow_hair, sample_style
from relight_core.dataset.garments.headwear.wardrobe import Headwear, put_on, sample_kind
from relight_core.dataset.garments.lashes import LashStrips
from relight_core.dataset.garments.raised_arm import raise_arm
from relight_core.dataset.heads import OUTER_SKIN, HeadModel

_HAIR, _BEARD, _GLASSES, _CLOTH, _BROWS = 0.90, 0.20, 0.15, 0.95, 0.85
_LASHES = 0.8
_FEDORA_SHARE = 0.04
_SHELL_SHARE = 0.5
_UNDER_HAT = ("long01", "ponytail01", "Braid01", "short04")
_DARK_LENSES = 0.3
_THICKEST_FRAME_CM = 0.14
_HAT_SCALE = np.array([1.1, 1.05, 1.08])
_HAT_SHIFT_CM = np.array([0.0, -1.6, -0.4])
_GLASSES_LANDMARKS = (0, 1, 15, 16, 27, 28, 36, 39, 42, 45)


@dataclass(frozen=True)
class Shares:
    """How many heads have what most lack, each in [0, 1].

    Attributes:
        headwear: wear something on them.
        arms: have an arm raised to them.
        hair_mass: of those without headwear, have a great mass of hair.
    """

    headwear: float = 0.15
    arms: float = 0.1
    hair_mass: float = 0.08


class Wardrobe:
    """Everything to wear, fitted to the mean head of a model; `dress` puts a random outfit on any head."""

    def __init__(self, makehuman_folder: Path, model: HeadModel, shares: Shares | None = None):
        """Fit all items; the first time takes a while, later ones read a cache beside the data.

        Args:
            makehuman_folder: where the MakeHuman archive was unpacked.

        Raises:
            InputError: the folder holds no MakeHuman data.
        """
        self._model, self._shares = model, shares or Shares()
        self._skin_triangles = model.triangles[model.has_triangles_of(*OUTER_SKIN)]
        self._skin_vertices = np.unique(self._skin_triangles)
        self.items = load_fitted_items(Path(makehuman_folder), model)
        self._grid, self._beards = ScalpGrid(model), BeardPatch(model)
        self._lashes, self._neck_and_ears = LashStrips(model), NeckAndEars(model)
        self._ears = [np.flatnonzero(_on_ear(model.mean) & (sign * model.mean[:, 0] > 0)) for sign in (-1, 1)]

    def dress(self, head_vertices: np.ndarray, rng: np.random.Generator) -> list[Garment]:
        """A random outfit.

        Args:
            head_vertices: (26719, 3) identity and expression applied, pose not.

        Returns:
            Garments in the frame of `head_vertices`, at most about 150,000 triangles together.
        """
        head = head_vertices.astype(np.float32)
        normals = vertex_normals(head, self._skin_triangles)
        skin = HeadSurface(head[self._skin_vertices], normals[self._skin_vertices])
        wears_headwear = rng.random() < self._shares.headwear
        headwear = self._headwear(head, skin, rng.spawn(1)[0]) if wears_headwear else None
        hair = []
        if rng.random() < _HAIR and not (headwear is not None and headwear.hides_hair):
            hair.append(self._hair(head, skin, headwear, rng))
        worn = [] if headwear is None else list(headwear.garments)
        worn += self._usual(head, normals, skin, rng)
        extra = rng.spawn(1)[0]
        if extra.random() < _LASHES:
            worn += self._lashes.grow(head, extra)
        if headwear is None or not headwear.hides_hair:
            worn += self._neck_and_ears.adorn(head, skin, extra)
        late = rng.spawn(1)[0]
        if headwear is None and late.random() < self._shares.hair_mass:
            hair = [grow_mass(late)]
        if late.random() < self._shares.arms:
            worn += raise_arm(skin, late)
        return hair + worn

    def _usual(self, head, normals, skin, rng) -> list[Garment]:
        """Beard, glasses, clothes and brows, each at times."""
        worn = []
        if rng.random() < _BEARD:
            worn.append(self._beard(head, normals, skin, rng))
        if rng.random() < _GLASSES:
            worn.append(self._glasses(head, rng))
        if rng.random() < _CLOTH:
            worn.append(self._cloth(head, skin, rng))
        if rng.random() < _BROWS:
            worn.append(self._follow(self._pick("brow", rng), head, skin, 0.05))
        return worn

    def _pick(self, kind: str, rng: np.random.Generator, names: tuple[str, ...] | None = None) -> FittedItem:
        choice = [i for i in self.items if i.kind == kind and (names is None or i.name in names)]
        return choice[rng.integers(len(choice))]

    def _follow(self, item: FittedItem, head: np.ndarray, skin: HeadSurface, margin_cm: float) -> Garment:
        vertices = item.binding.follow(item.vertices, head - self._model.mean)
        return item.as_garment(skin.push_out(vertices, margin_cm))

    def _hair(self, head, skin, headwear: Headwear | None, rng) -> Garment:
        flat = headwear is not None and headwear.presses
        if rng.random() < _SHELL_SHARE:
            worn = grow_hair(self._grid, head, skin, sample_style(rng), rng)
        else:
            worn = self._follow(self._pick("hair", rng, _UNDER_HAT if flat else None), head, skin, 0.15)
        if headwear is None:
            return worn
        return replace(worn, vertices=skin.press_down(worn.vertices, headwear.ceiling_cm(worn.vertices)))

    def _beard(self, head, normals, skin, rng) -> Garment:
        if rng.random() < 0.7:
            return self._beards.grow(head, normals, rng)
        return self._follow(self._pick("beard", rng), head, skin, 0.06)

    def _glasses(self, head, rng) -> Garment:
        dark = rng.random() < _DARK_LENSES
        item = self._pick("glasses", rng, ("sunglasses",) if dark else ("glasses",))
        bridge = self._model.mean[self._model.landmarks[28]]
        thicker = vertex_normals(item.vertices, item.faces) * rng.spawn(1)[0].uniform(0, _THICKEST_FRAME_CM)
        reshaped = (item.vertices + thicker - bridge) * [1, rng.uniform(0.8, 1.25), 1] + bridge
        return self._place_glasses(replace(item, vertices=reshaped), head)

    def _place_glasses(self, item: FittedItem, head: np.ndarray) -> Garment:
        """Glasses do not bend: they are only scaled per axis and shifted to the nose, temples and ears."""
        at = self._model.landmarks[list(_GLASSES_LANDMARKS)]
        scale, shift = fit_affine(self._model.mean[at], head[at], 0.1)
        return item.as_garment(item.vertices * scale + shift)

    def _headwear(self, head, skin, rng) -> Headwear:
        if rng.random() < _FEDORA_SHARE:
            return Headwear("fedora", [self._place_hat(self._pick("hat", rng), head, skin)], False, True)
        ears = np.stack([head[ear].mean(0) for ear in self._ears])
        return put_on(sample_kind(rng), head, ears, self._grid, skin, rng)

    def _place_hat(self, item: FittedItem, head: np.ndarray, skin: HeadSurface) -> Garment:
        """A stiff hat, drawn lower and wider than its maker set it, scaled and shifted with the skull."""
        middle = item.vertices.mean(0)
        worn = (item.vertices - middle) * _HAT_SCALE + middle + _HAT_SHIFT_CM
        top = np.flatnonzero(self._model.mean[:, 1] > 8)
        scale, shift = fit_affine(self._model.mean[top], head[top], 0.1)
        return item.as_garment(skin.push_out(worn * scale + shift, 0.5))

    def _cloth(self, head, skin, rng) -> Garment:
        """A shirt or jacket with shoulders of a random breadth and folds of its own."""
        worn = self._follow(self._pick("cloth", rng), head, skin, 0.25)
        away = smoothstep(-14, -22, worn.vertices[:, 1])
        vertices = worn.vertices.copy()
        vertices[:, 0] *= 1 + rng.uniform(-0.08, 0.15) * away
        vertices[:, 1] += rng.normal(0, 0.07) * (np.abs(vertices[:, 0]) - 8) * (np.abs(vertices[:, 0]) > 8)
        folds = fractal(vertices, rng, rng.uniform(4, 10), 3) * rng.uniform(0.05, 0.35)
        normals = vertex_normals(vertices, worn.faces)
        vertices += normals * (folds * smoothstep(-10, -17, vertices[:, 1]))[:, None]
        return replace(worn, vertices=skin.push_out(vertices, 0.3))


def _on_ear(mean: np.ndarray) -> np.ndarray:
    """(V,) bool: the outer sides of the ears of a mean head."""
    return (np.abs(mean[:, 0]) > 7.9) & (mean[:, 1] > -6) & (mean[:, 1] < 7)
