"""Where the panels lie."""

from __future__ import annotations

from dataclasses import dataclass

_LIGHT_EM, _EFFECTS_EM, _FILMSTRIP_EM, _STATUS_EM = 17.0, 16.0, 7.4, 2.0


@dataclass(frozen=True)
class Rect:
    """x, y: top left corner; all in window units."""

    x: float
    y: float
    width: float
    height: float

    @property
    def corners(self) -> tuple[float, float, float, float]:
        """x0, y0, x1, y1."""
        return self.x, self.y, self.x + self.width, self.y + self.height


@dataclass(frozen=True)
class Layout:
    """The rectangle of every panel."""

    light: Rect
    effects: Rect
    viewport: Rect
    filmstrip: Rect
    status: Rect


def arrange(width: float, height: float, em: float) -> Layout:
    """Divide a window of the given size; `em` is the font's height."""
    left, right = round(_LIGHT_EM * em), round(_EFFECTS_EM * em)
    strip, line = round(_FILMSTRIP_EM * em), round(_STATUS_EM * em)
    middle = max(1.0, height - strip - line)
    centre = max(1.0, width - left - right)
    return Layout(
        light=Rect(0, 0, left, middle),
        effects=Rect(left + centre, 0, right, middle),
        viewport=Rect(left, 0, centre, middle),
        filmstrip=Rect(0, middle, width, strip),
        status=Rect(0, middle + strip, width, line),
    )
