"""What the panels need of the window's textures: opaque numbers to hand to the binding."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from app.engine.sources import LightSource
from app.ui.view import Placement


@dataclass(frozen=True)
class Shown:
    """A texture: the graphics system's number for it, and its size in pixels."""

    number: int
    width: int
    height: int


class Pictures(Protocol):
    """Textures of what the engine has published."""

    def size(self, name: str) -> tuple[int, int] | None:
        """Width and height of a picture or channel; None while there is none."""

    def thumbnail(self, name: str) -> Shown | None:
        """A picture or channel, small and ready to look at."""

    def viewport(self, name: str | None, placement: Placement | None, size: tuple[int, int]) -> Shown:
        """The viewport, `size` pixels large, with the picture at its place; drawn now if anything changed."""

    def panorama(self) -> Shown | None:
        """The light in force; repeats sideways."""

    def ball(self, light: LightSource) -> Shown | None:
        """A ball lit by a light, as far as it has been drawn yet."""
