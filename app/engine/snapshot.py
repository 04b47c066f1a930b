"""What the engine publishes: immutable records of plain arrays, ready for the screen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from app.engine.sources import LightSource, PhotoSource, RelitLike
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.lighting.environment import Environment
from relight_core.lighting.light_edit import LightEdit
from relight_core.lighting.soft_box import SoftBox
from relight_core.pipeline.auto_quality import TierCost
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.results.display import DisplayRecipe

_MOST_ERRORS = 50
"""More than anybody reads one by one."""


@dataclass(frozen=True, eq=False)
class OpenPhoto:
    """The portrait in force.

    Attributes:
        source: the wish it answers.
        photo: its pixels.
        screen: (h, w, 3) float16 linear, small enough for a texture; (h, w, 4) with the alpha of a photo that has one.
    """

    source: PhotoSource
    photo: Photo
    screen: np.ndarray

    def shows(self, source: PhotoSource) -> bool:
        """Whether a wish is for these pixels, whoever in them is to be relit."""
        return source is self.source or source.place is self.photo


@dataclass(frozen=True, eq=False)
class OpenLight:
    """The light in force.

    Attributes:
        source: the wish it answers.
        environment: the light, edited.
        panorama: (h, 2h, 3) uint8 sRGB, edited and unturned.
        ball: (s, s, 4) uint8 sRGB and coverage, of the light before it was edited.
        base: the light before it was edited.
        edit: what was changed about it.
        is_draft: it was drawn coarsely, while the hand was moving.
        lamps: of the base, that could be taken out of it.
    """

    source: LightSource
    environment: Environment
    panorama: np.ndarray
    ball: np.ndarray
    base: Environment
    edit: LightEdit = field(default_factory=LightEdit)
    is_draft: bool = False
    lamps: tuple[SoftBox, ...] = ()


@dataclass(frozen=True, eq=False)
class Picture:
    """One result.

    Attributes:
        opened: the portrait it shows.
        light: the light it shows it under.
        edit: the edit it was computed with; exposure not applied.
        longest_side_px: how large it was made; None is as large as the photo.
        relit: the result as the library gave it.
        screen: what a shader draws it from, or (h, w, 3 or 4) float16 linear radiance, small enough for a texture.
        channels: name -> (h, w, 3) uint8 sRGB, as channels are looked at.
        is_stale: it shows the faces as they were before; the next one is on its way.
        outline: the people's, as of `RelitLike.outline`; None where it was not asked for yet.
    """

    opened: OpenPhoto
    light: OpenLight
    edit: Edit
    longest_side_px: int | None
    relit: RelitLike
    screen: DisplayRecipe | np.ndarray
    channels: dict[str, np.ndarray]
    is_stale: bool = False
    outline: list[np.ndarray] | None = None

    @property
    def is_passing(self) -> bool:
        """Whether it was made while a hand moved something, and another follows when that rests."""
        return self.edit.channels is not None


@dataclass(frozen=True)
class Message:
    """A line for the user; the same text said twice has two numbers."""

    number: int
    text: str
    is_error: bool = False


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The engine's whole state at one moment.

    Attributes:
        opened, light, picture: in force; None until there is one.
        coming: the first photo, to be looked at while its face is being read; None once it is open.
        own_light: the light of the open photo, once it has been estimated.
        awaited: a wish for the photo's own light that was in force with the photo before, while there is no face to
            estimate it from.
        faces: everyone in the open photo, by hand or as found; none where nobody is seen and nobody was shown.
        refused: wishes that failed since the engine started and must not be wished again.
        tier_costs: what the quality tiers cost on this machine, as far as it is known.
        activity: what runs now, or None.
        message: the newest line for the user, or None.
        errors: the newest lines that tell of an error, oldest first.
    """

    opened: OpenPhoto | None = None
    coming: OpenPhoto | None = None
    light: OpenLight | None = None
    picture: Picture | None = None
    own_light: OpenLight | None = None
    awaited: LightSource | None = None
    faces: tuple[FaceBox, ...] = ()
    refused: frozenset[PhotoSource | LightSource] = field(default_factory=frozenset)
    tier_costs: Mapping[str, TierCost] = field(default_factory=dict)
    activity: str | None = None
    message: Message | None = None
    errors: tuple[Message, ...] = ()

    def telling(self, message: Message) -> Snapshot:
        """The same with a newer line for the user; an error whose every line it says again is one with it."""
        if not message.is_error:
            return replace(self, message=message)
        lines = {*message.text.split("\n")}
        others = [error for error in self.errors if not {*error.text.split("\n")} <= lines]
        return replace(self, message=message, errors=(*others, message)[-_MOST_ERRORS:])

    @property
    def picture_in_sight(self) -> Picture | None:
        """The picture, if it is of the portrait in force: one of the portrait before stays in `picture` for a while."""
        return self.picture if self.picture is not None and self.picture.opened is self.opened else None
