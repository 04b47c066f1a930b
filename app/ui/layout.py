"""Where the panels lie, how the lines between them move, and to which edges they can be moved."""

from __future__ import annotations

from dataclasses import dataclass, replace

STATUS_EM, SCOPE_EM, TOOLBAR_EM = 2.0, 7.0, 2.1
SIDE_EM = (13.0, 34.0)
"""Narrowest and widest a side panel can be drawn, in font heights."""

STRIP_EM = (5.0, 20.0)
"""Lowest and highest the filmstrip can be drawn, in font heights."""

_VIEWPORT_EM = (14.0, 10.0)
"""What is always left of the viewport, across and down, in font heights; panels give way to it."""

_LEAST_EM = 9.0
_BELOW_SCOPE_EM = 8.0
"""What is left of the effects below histogram or waveform at least, in font heights; else those give way."""

EDGES = {"light": ("left", "right"), "effects": ("left", "right"), "filmstrip": ("top", "bottom")}
"""The edges of the window at which each panel can be."""

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
    """How large the user made the panels, in font heights, which of them are in sight, and at which edges they are."""

    light_em: float = 17.0
    effects_em: float = 16.0
    filmstrip_em: float = 7.4
    light: bool = True
    effects: bool = True
    filmstrip: bool = True
    light_at: str = "left"
    effects_at: str = "right"
    filmstrip_at: str = "bottom"

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

    def shown_like(self, others: Panels) -> Panels:
        """The same with those panels in sight that are so of others."""
        return replace(self, light=others.light, effects=others.effects, filmstrip=others.filmstrip)

    def moved(self, name: str, edge: str) -> Panels:
        """The same with one panel at another edge, one of its EDGES."""
        return replace(self, **{f"{name}_at": edge})

    def across(self, name: str) -> Panels:
        """The same with one panel at the edge opposite to where it is."""
        first, second = EDGES[name]
        return self.moved(name, second if getattr(self, f"{name}_at") == first else first)

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
    """The rectangle of every panel; None for one that is hidden.

    Attributes:
        parts: what can be moved and is in sight, by name: light, filmstrip, and the effects with the scope above them.
    """

    light: Rect | None
    effects: Rect | None
    scope: Rect | None
    filmstrip: Rect | None
    toolbar: Rect | None
    viewport: Rect
    status: Rect
    dividers: tuple[Divider, ...]
    parts: dict[str, Rect]


def arrange(width: float, height: float, em: float, panels: Panels | None = None, scope: bool = False) -> Layout:
    """Divide a window of the given size; `em` is the font's height.

    The viewport keeps a least size: in a small window the panels are drawn smaller than the user made
    them, and come back when there is room. Panels at the same side stand beside each other, the light on the left.

    Args:
        scope: whether histogram or waveform stand above the effects, where there is room.
    """
    panels = panels or Panels()
    line = round(STATUS_EM * em)
    strip = _strip(panels, height - line, em)
    middle = max(1.0, height - strip - line)
    top = strip if panels.filmstrip_at == "top" else 0
    light, effects, left, centre = _columns(panels, width, em)
    right, lower = left + centre, top + middle
    bar = round(TOOLBAR_EM * em) if panels.any_shown else 0
    scope_height = round(SCOPE_EM * em) if scope and effects and middle >= (SCOPE_EM + _BELOW_SCOPE_EM) * em else 0
    strip_y = 0 if panels.filmstrip_at == "top" else lower
    parts = {
        "light": Rect(light[0], top, light[1], middle) if light else None,
        "effects": Rect(effects[0], top, effects[1], middle) if effects else None,
        "filmstrip": Rect(0, strip_y, width, strip) if strip else None,
    }
    below = effects and Rect(effects[0], top + scope_height, effects[1], middle - scope_height)
    return Layout(
        light=parts["light"],
        effects=below,
        scope=Rect(effects[0], top, effects[1], scope_height) if scope_height else None,
        filmstrip=parts["filmstrip"],
        toolbar=Rect(left, top, right - left, bar) if bar else None,
        viewport=Rect(left, top + bar, centre, max(1, middle - bar)),
        status=Rect(0, height - line, width, line),
        dividers=tuple(_divider(panels, name, rect, em) for name, rect in parts.items() if rect),
        parts={name: rect for name, rect in parts.items() if rect},
    )


Column = tuple[float, float]
"""x and width."""


def _columns(panels: Panels, width: float, em: float) -> tuple[Column | None, Column | None, float, float]:
    """The light's and the effects' columns, where the centre begins, and how wide it is."""
    light, effects = _sides(panels, width, em)
    centre = max(1.0, width - light - effects)
    at_left = {name: getattr(panels, f"{name}_at") == "left" for name in ("light", "effects")}
    left = light * at_left["light"] + effects * at_left["effects"]
    light_x = 0.0 if at_left["light"] else left + centre
    effects_x = light * at_left["light"] if at_left["effects"] else width - effects
    return (light_x, light) if light else None, (effects_x, effects) if effects else None, left, centre


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


def _divider(panels: Panels, name: str, rect: Rect, em: float) -> Divider:
    """The line at the edge of a panel that looks toward the picture."""
    edge = getattr(panels, f"{name}_at")
    x0, y0, x1, y1 = rect.corners
    if name == "filmstrip":
        line = Rect(x0, y1 if edge == "top" else y0, rect.width, 1)
        return Divider(name, line, rect.height / em, 1.0 if edge == "top" else -1.0)
    line = Rect(x1 if edge == "left" else x0, y0, 1, rect.height)
    return Divider(name, line, rect.width / em, 1.0 if edge == "left" else -1.0)
