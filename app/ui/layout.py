"""Where the panels lie, and how the lines between them move."""

from __future__ import annotations

from dataclasses import dataclass, replace

STATUS_EM, SCOPE_EM, TOOLBAR_EM = 2.0, 7.4, 2.1
SIDE_EM = (13.0, 34.0)
"""Narrowest and widest a side panel can be drawn, in font heights."""

STRIP_EM = (5.0, 20.0)
"""Lowest and highest the filmstrip can be drawn, in font heights."""

_VIEWPORT_EM = (14.0, 10.0)
"""What is always left of the viewport, across and down, in font heights; panels give way to it."""

_LEAST_EM = 9.0

_LIGHT_SHARE, _WIDE_LIGHT_EM = 0.2, 26.0
"""Where the user has not sized the light panel, it takes this share of a wide window, up to that many font heights."""


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
class Panels:
    """How large the user made the panels, in font heights, and which of them are in sight."""

    light_em: float = 17.0
    effects_em: float = 16.0
    filmstrip_em: float = 7.4
    light: bool = True
    effects: bool = True
    filmstrip: bool = True

    @property
    def any_shown(self) -> bool:
        """Whether at least one panel is in sight."""
        return self.light or self.effects or self.filmstrip

    def switched(self, name: str) -> Panels:
        """The same with one panel shown or hidden."""
        return replace(self, **{name: not getattr(self, name)})

    def all_shown(self, shown: bool) -> Panels:
        """The same with every panel shown or hidden."""
        return replace(self, light=shown, effects=shown, filmstrip=shown)

    def dragged(self, name: str, em: float) -> Panels:
        """The same with one panel's size changed, within its limits."""
        low, high = STRIP_EM if name == "filmstrip" else SIDE_EM
        return replace(self, **{f"{name}_em": min(max(em, low), high)})

    def reset(self, name: str) -> Panels:
        """The same with one panel at its first size."""
        return replace(self, **{f"{name}_em": getattr(Panels(), f"{name}_em")})


@dataclass(frozen=True)
class OpenGroups:
    """Which groups of the panels are open; the others show only their title."""

    effects: bool = True
    background: bool = True
    quality: bool = False
    export: bool = True
    history: bool = True
    adjust: bool = False


@dataclass(frozen=True)
class Divider:
    """The draggable line at a panel's inner edge.

    Attributes:
        panel: whose size it changes.
        line: the line itself, one unit thick.
        size_em: the panel's size as it is drawn.
        sign: 1 where the panel grows with the mouse's x or y, -1 where it shrinks.
    """

    panel: str
    line: Rect
    size_em: float
    sign: float


@dataclass(frozen=True)
class Layout:
    """The rectangle of every panel; None for one that is hidden."""

    light: Rect | None
    effects: Rect | None
    scope: Rect | None
    filmstrip: Rect | None
    toolbar: Rect | None
    viewport: Rect
    status: Rect
    dividers: tuple[Divider, ...]


def arrange(width: float, height: float, em: float, panels: Panels | None = None, scope: bool = False) -> Layout:
    """Divide a window of the given size; `em` is the font's height.

    The viewport keeps a least size: in a small window the panels are drawn smaller than the user made
    them, and come back when there is room.

    Args:
        scope: whether histogram or waveform stand above the effects.
    """
    panels = panels or Panels()
    line = round(STATUS_EM * em)
    strip = _strip(panels, height - line, em)
    left, right = _sides(panels, width, em)
    middle = max(1.0, height - strip - line)
    centre = max(1.0, width - left - right)
    bar = round(TOOLBAR_EM * em) if panels.any_shown else 0
    scope_height = min(round(SCOPE_EM * em), middle) if scope and right else 0
    return Layout(
        light=Rect(0, 0, left, middle) if left else None,
        effects=Rect(left + centre, scope_height, right, middle - scope_height) if right else None,
        scope=Rect(left + centre, 0, right, scope_height) if scope_height else None,
        filmstrip=Rect(0, middle, width, strip) if strip else None,
        toolbar=Rect(left, 0, centre, bar) if bar else None,
        viewport=Rect(left, bar, centre, max(1, middle - bar)),
        status=Rect(0, middle + strip, width, line),
        dividers=_dividers(left, right, strip, width, middle, em),
    )


def _strip(panels: Panels, room: float, em: float) -> int:
    if not panels.filmstrip:
        return 0
    return round(max(min(panels.filmstrip_em * em, room - _VIEWPORT_EM[1] * em), STRIP_EM[0] * em))


def _sides(panels: Panels, width: float, em: float) -> tuple[int, int]:
    left = _light_em(panels, width / em) * em if panels.light else 0.0
    right = panels.effects_em * em if panels.effects else 0.0
    room = max(width - _VIEWPORT_EM[0] * em, 0.0)
    if left + right > room:
        left, right = (side and max(side * room / (left + right), _LEAST_EM * em) for side in (left, right))
    return round(left), round(right)


def _light_em(panels: Panels, width_em: float) -> float:
    if panels.light_em != Panels().light_em:
        return panels.light_em
    return max(panels.light_em, min(_LIGHT_SHARE * width_em, _WIDE_LIGHT_EM))


def _dividers(left: int, right: int, strip: int, width: float, middle: float, em: float) -> tuple[Divider, ...]:
    every = (
        Divider("light", Rect(left, 0, 1, middle), left / em, 1.0) if left else None,
        Divider("effects", Rect(width - right, 0, 1, middle), right / em, -1.0) if right else None,
        Divider("filmstrip", Rect(0, middle, width, 1), strip / em, -1.0) if strip else None,
    )
    return tuple(divider for divider in every if divider)
