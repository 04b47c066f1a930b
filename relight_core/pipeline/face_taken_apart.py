"""One face of a photo, as the networks take it apart; what neither a light nor the photo's other faces change."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from typing import Self
from weakref import proxy

import numpy as np

from relight_core.face.crop import Crop
from relight_core.face.irises import find_irises
from relight_core.face.parsing import INDEX, PAPER_CLASSES, share_of
from relight_core.face.person_view import person_view, upright, wider_view
from relight_core.face.silhouette import person_with_headwear
from relight_core.imaging.resampling import resize_area
from relight_core.lighting.reflection import ReflectionTable
from relight_core.lighting.relief import ReliefTransport
from relight_core.networks.bundle import NetworkBundle
from relight_core.networks.pair import BothNetworks
from relight_core.pipeline import stages
from relight_core.pipeline.cache import StageCache
from relight_core.pipeline.per_photo.corneas import Cornea, find_cornea
from relight_core.pipeline.per_photo.nearer_look import nearer_view, with_nearer_look
from relight_core.pipeline.per_photo.network_view import (
    as_networks_see,
    in_photo,
    in_picture,
    picture_size,
    picture_view,
)
from relight_core.pipeline.per_photo.outline import Outline, outline_person, parsing_within
from relight_core.pipeline.per_photo.portrait import Portrait
from relight_core.pipeline.per_photo.second_look import take_apart
from relight_core.pipeline.per_photo.strands import Hair
from relight_core.pipeline.prepared import Prepared
from relight_core.pipeline.quality import Tier, tier_of

KEPT_TIERS = 16
"""As many tiers may be compared side by side without any of them being prepared twice."""


@dataclass(frozen=True, eq=False)
class Workshop:
    """What all faces share: the networks, what open surfaces reflect, and where both live."""

    bundle: NetworkBundle
    table: ReflectionTable
    device: str

    def delight(self, photo_view: np.ndarray, tier: Tier) -> stages.Surface:
        """Take a view (S, S, 3) apart."""
        return take_apart(self.bundle, photo_view, tier, self.device)

    def pair(self, tier: Tier) -> BothNetworks:
        """The networks that relight at a tier."""
        return stages.pair_of(self.bundle, tier, self.device)


class FaceTakenApart:
    """The first stages of one face, each result kept in a cache under what it was made from.

    Attributes:
        portrait: the photo and where the face is in it.
        cache: of this face alone.
        nearer: the same face in a view of little else; None where its own is near enough.
        wider: whose nearer view this one is; None for a face's own view.
    """

    wider: Self | None = None

    def __init__(self, workshop: Workshop, portrait: Portrait, cache: StageCache, *, outlined: bool = True):
        """Compute nothing yet.

        Args:
            outlined: the person network, where there is one, has a say in the parsing.
        """
        self.portrait = portrait
        self._shop = workshop
        self.cache = cache
        self._outlined = outlined
        nearer, self.nearer = nearer_view(portrait), None
        if nearer is not None:
            self.nearer = type(self)(workshop, replace(portrait, view=nearer), StageCache(), outlined=False)
            # Weakly: in a circle both would keep their photo until Python looks for circles, some photos later.
            self.nearer.wider = proxy(self)

    @property
    def caches(self) -> tuple[StageCache, ...]:
        """Its own, and that of the nearer view."""
        return (self.cache,) if self.nearer is None else (self.cache, self.nearer.cache)

    def forget(self, stage: str) -> None:
        """Drop a stage's results."""
        for cache in self.caches:
            cache.forget(stage)

    def forget_lights(self) -> None:
        """Drop what came with a light or an edit."""
        for cache in self.caches:
            cache.forget_lights()

    def _once(self, name: str, key: Hashable, make):
        """A stage that only a new photo or another quality makes run again."""
        return self.cache.of_photo(name, key, make, "new photo or quality", keep=KEPT_TIERS)

    def prepare(self, tier: Tier) -> Prepared:
        """The face as one tier of quality sees it."""
        size = tier.size
        photo_view, seen = self._view(size), self._seen_view(size)
        small = (tier.network_size, tier.network_size)
        photo_small = self._once("network_view", (size, tier.network_size), lambda: resize_area(seen, small))
        take_apart = lambda: self._within_outline(self._seen_view(tier.size_apart), tier)  # noqa: E731
        found = self._once("delight", tier.surface_key, take_apart)
        return Prepared(self.portrait, tier, found, found, photo_view, seen, photo_small)

    def knows_surface(self, tier: Tier) -> bool:
        """Whether the face has been taken apart as a tier does it."""
        return self.cache.has("delight", tier.surface_key)

    def _view(self, size: int) -> np.ndarray:
        return self._once("view", size, lambda: picture_view(self.portrait.photo, self.portrait.view, size))

    def _seen_view(self, size: int) -> np.ndarray:
        view, monochrome, exposure = self._view(size), self.portrait.monochrome, self.portrait.exposure
        if not monochrome and exposure == 1.0:
            return view
        return self._once("seen_view", size, lambda: as_networks_see(view, monochrome, exposure))

    def _within_outline(self, photo_view: np.ndarray, tier: Tier) -> stages.Surface:
        found, outline = self._shop.delight(photo_view, tier), self.outline()
        if self.nearer is not None:
            seen_nearer = self.nearer.prepare(tier).found
            found = with_nearer_look(found, seen_nearer, self.portrait.view, self.nearer.portrait.view)
        if self.portrait.monochrome:
            found = stages.without_colour(found)
        if outline is None:
            return found
        return stages.reparsed(found, parsing_within(found.parsing, outline, self.portrait.view))

    def _parsing(self) -> np.ndarray:
        """(classes, S, S) probabilities as one tier sees them, whichever is asked for: they depend on no history."""
        return self.prepare(tier_of("live")).found.parsing[0].cpu().numpy()

    def mask(self) -> tuple[np.ndarray, Crop]:
        """Probability (S, S) of person, gaps between hair and shoulders left open, and the view it lies in."""
        parsing, view = self._parsing(), self.portrait.view
        outline = self.outline()
        if outline is None:
            return person_with_headwear(parsing), view
        whole = outline.corrected(1 - parsing[INDEX["background"]], view)
        return whole.likely, whole.view

    def face_mask(self) -> tuple[np.ndarray, Crop]:
        """Probability (s, s) of face, and the view it lies in."""
        face = share_of(self.prepare(tier_of("live")).found.parsing, PAPER_CLASSES)
        return face[0, 0].cpu().numpy(), self.portrait.view

    def hair(self) -> Hair:
        """Where the head's hair is, and what else of a person."""
        parsing, portrait = self._parsing(), self.portrait
        hair = parsing[INDEX["hair"]]
        return Hair(hair, 1 - parsing[INDEX["background"]] - hair, portrait.view, portrait.crop.side)

    def corneas(self) -> tuple[Cornea, ...]:
        """The fronts of the eyes; none where one that is seen can't be taken apart, or none is seen well enough.

        As one tier sees them, whichever is asked for, so that they depend on no history.
        """
        return self._once("corneas", "photo", self._find_corneas)

    def _find_corneas(self) -> tuple[Cornea, ...]:
        photo, exposure, view = self.portrait.photo, self.portrait.exposure, self.portrait.view
        irises = find_irises(photo.linear, exposure, self._parsing(), view)
        found = [find_cornea(photo.linear, exposure, iris) for iris in irises]
        return () if None in found else tuple(found)

    def outline(self) -> Outline | None:
        """The person as the person network sees them; None where there is no such network, or it isn't asked.

        It looks twice, as the head leans and, at the mirror image, as the photo lies: what it doesn't make out of an
        arm or a coat is seldom the same in both.
        """
        if self._shop.bundle.person is None or not self._outlined:
            return None
        return self._once("outline", "photo", self._look_twice)

    def _look_twice(self) -> Outline:
        photo, crop = self.portrait.photo, self.portrait.crop

        def view_about(crop: Crop) -> Crop:
            return in_photo(photo, person_view(in_picture(photo, crop), picture_size(photo)))

        leaning = self._look(crop, view_about(crop))
        return leaning.agreed(self._look(upright(crop), view_about(upright(crop)), mirrors=(True,)))

    def looks(self) -> list[tuple[np.ndarray, Crop]]:
        """`mask`, and the same of a wider view where there is a person network and the photo shows more."""
        return [self.mask(), *self._wider_looks()]

    def glances(self) -> list[tuple[np.ndarray, Crop]]:
        """`looks` by the person network alone where there is one: in a fraction of the time, hair less exactly."""
        outline = self.outline()
        return self.looks() if outline is None else [(outline.likely, outline.view), *self._wider_looks()]

    def _wider_looks(self) -> list[tuple[np.ndarray, Crop]]:
        photo, crop = self.portrait.photo, upright(self.portrait.crop)
        view = wider_view(in_picture(photo, crop), picture_size(photo))
        if self.outline() is None or view is None:
            return []
        look = lambda: self._look(crop, in_photo(photo, view), mirrors=(False, True))  # noqa: E731
        wider = self._once("wider_outline", "photo", look)
        return [(wider.likely, wider.view)]

    def _look(self, crop: Crop, view: Crop, mirrors: tuple[bool, ...] = (False,)) -> Outline:
        """What the person network says in a view; see `outline_person`."""
        how = {"mirrors": mirrors, "exposure": self.portrait.exposure}
        return outline_person(self._shop.bundle, self.portrait.photo, crop, view, self._shop.device, **how)

    def _relief(self, ready: Prepared) -> ReliefTransport:
        return self._once("relief", ready.tier.relief_key, lambda: stages.march(ready.found, ready.tier.relief_size))

    def _reflector(self, ready: Prepared) -> stages.Reflector:
        make = lambda: stages.reflector(self._shop.table, ready.found)  # noqa: E731
        return self._once("normals", ready.tier.surface_key, make)
