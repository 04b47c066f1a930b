"""How the picture is looked at: comparison, overlays and readings. Nothing here changes the picture."""

from __future__ import annotations

from dataclasses import dataclass

SCOPES = ("off", "histogram", "waveform")


@dataclass
class LookState:
    """What the user has switched on for looking.

    Attributes:
        viewport_px: width and height of the viewport as drawn last, in framebuffer pixels.
        pointer_px: the mouse in the viewport, in framebuffer pixels; None while it is elsewhere.
        compare: the photo beside the picture, "off", "wipe" or "side".
        wipe_at: where the wipe divides, along the picture from 0 at its left edge to 1.
        wipe_held: the wipe's line is being dragged.
        spot: the point of the photo under the mouse, in its pixels; None while there is none.
        spot_in: which picture the mouse is over there: with the photo beside the picture, one of the two.
        clipping: stripes over what is too bright or too dark for the screen or not a number.
        false_colour: specular and shadow as a colour scale.
        difference: how many stops the result is brighter or darker than the photo, in colour.
        probe: the values of every channel under the mouse.
        scope: one of SCOPES.
        light_ball: the lit ball and the compass.
        covered: how far down the viewport open questions reach, in window units.
        ball_at: the ball's middle, in window units.
        timings: what each stage took.
        help, palette: these overlays are open.
        palette_text: what was typed into the palette.
        palette_row: the row of the palette that Enter runs.
    """

    viewport_px: tuple[int, int] = (1, 1)
    pointer_px: tuple[float, float] | None = None
    compare: str = "off"
    wipe_at: float = 0.5
    wipe_held: bool = False
    spot: tuple[float, float] | None = None
    spot_in: str = ""
    clipping: bool = False
    false_colour: bool = False
    difference: bool = False
    probe: bool = False
    scope: str = "histogram"
    light_ball: bool = True
    covered: float = 0.0
    ball_at: tuple[float, float] = (0.0, 0.0)
    timings: bool = False
    help: bool = False
    palette: bool = False
    palette_text: str = ""
    palette_row: int = 0

    def switch(self, name: str) -> None:
        """Turn one of the switches over."""
        setattr(self, name, not getattr(self, name))

    def choose(self, name: str, value: str) -> None:
        """Set `compare` or `scope`, or switch it off if it has that value already."""
        setattr(self, name, "off" if getattr(self, name) == value else value)
