"""What the panels need of the window's textures: opaque numbers to hand to the binding."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from app.engine.sources import LightSource
from app.ui.viewport.panes import Pane
from relight_core.imaging.scopes import Extremes


@dataclass(frozen=True)
class Shown:
    """A texture: the graphics system's number for it, and its size in pixels."""

    number: int
    width: int
    height: int


@dataclass(frozen=True)
class Paint:
    """How pictures are painted beyond showing them as they are; the fields are those of LookState.

    Attributes:
        stripe_px: width of the clipping stripes, in framebuffer pixels.
        check_px: side of a check of the checkerboard behind what is transparent, in framebuffer pixels.
        supersampled: where the picture is shown smaller, each pixel of the screen is the mean of 2 x 2 samples, so
            that edges are as clean as in the picture itself; takes three times as long.
    """

    clipping: bool = False
    false_colour: bool = False
    difference: bool = False
    stripe_px: float = 4.0
    check_px: float = 12.0
    supersampled: bool = True


class Pictures(Protocol):
    """Textures of what the engine has published."""

    def size(self, name: str) -> tuple[int, int] | None:
        """Width and height of a picture or channel; None while there is none."""

    def thumbnail(self, name: str, side_px: int) -> Shown | None:
        """A picture or channel, ready to look at, no more than `side_px` high and wide where it has to be drawn."""

    def viewport(self, panes: Sequence[Pane], size: tuple[int, int], paint: Paint) -> Shown:
        """The viewport, `size` pixels large, with the panes' pictures; drawn now if anything changed."""

    def colours(self, kind: str) -> Shown:
        """The colours of "scale" (false colour) or "difference", from the least to the most."""

    def scope(self, kind: str, name: str) -> Shown | None:
        """The "histogram" or "waveform" of a picture or channel; computed now if it is another one."""

    def extremes(self, name: str) -> Extremes | None:
        """How much of the photo or the result the screen can't show; None for a channel."""

    def panorama(self) -> Shown | None:
        """The light in force; repeats sideways."""

    def ball(self, light: LightSource) -> Shown | None:
        """A ball lit by a light, as far as it has been drawn yet."""

    def light_ball(self, side: int, yaw_deg: float) -> Shown | None:
        """A ball in the light in force, turned, `side` pixels large; None while there is no light."""
