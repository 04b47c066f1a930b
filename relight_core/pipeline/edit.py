"""What the user has set: one immutable record that every stage reads its own fields of."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from numbers import Real

from relight_core.errors import InputError
from relight_core.pipeline.quality import Tier

EFFECTS = (
    "foreign_shadow",
    "flattening",
    "source_light",
    "relief",
    "shadow",
    "hard_shadow",
    "specular",
    "correction",
    "residual",
    "sliders",
    "detail",
    "catchlights",
    "background",
    "channels",
)
"""What a plan decides about, in the order in which it would run."""

BACKGROUNDS = ("keep", "match", "light", "transparent")
"""Beside colours: the photo's own, the same dimmed and tinted as the person is, the light itself, none."""

SURFACE_CHANNELS = ("photo", "albedo", "normal", "parsing", "foreign_shadow")
LIGHT_CHANNELS = ("specular", "shadow", "composition")
CHANNELS = (*SURFACE_CHANNELS, *LIGHT_CHANNELS, "source_light", "target_light")
"""What can be looked at beside the picture; "foreign_shadow" is there only where there are such shadows."""

TOLERANCE = 1 / 255
"""The largest change of a displayed value in [0, 1] that leaving something out may cause."""


@dataclass(frozen=True)
class Edit:
    """The state of every control.

    Attributes:
        yaw_deg: turn of the environment map; positive moves its content to the right.
        exposure_ev: display and export exposure in stops; read by no network.
        specular: gain on the specular channel, [0, 2]; 1 is as estimated (paper, Figure 12).
        shadow: gain on the shadow channel, [0, 2]; 1 is as estimated (paper, Figure 12).
        background: "keep", "match" (kept, dimmed and tinted as the person is), "light" (the panorama that
            the camera sees), "transparent" or "#rrggbb" (sRGB).
        background_fov_deg: field of view of the picture's longer side, for "light", in (0, 170].
        background_blur_deg: standard deviation of the blur of what is seen, for "light", in [0, 20].
        quality: "draft", "live" or "final", or a tier of one's own.
        channels: those of CHANNELS that are looked at; None for all of them.
        forced_on: effects (see EFFECTS) that the plan may not skip, nor reuse from a light that is not the same.
        forced_off: effects that are left out of the picture whatever the scene calls for. The photo's own light and
            the relief are found all the same where flattening, the residual or catchlights use them.
        tolerance: the largest change of the displayed picture that the plan may cause, [0, 1].
        specular_tint: colour of the specular channel, [-1, 1], from cool to warm; 0 is the light's own.
        shadow_softness: how far the edges of shadows are softened, [0, 1]; 0 is as estimated.
        strength: how far the new light takes the photo's place on the person, [0, 1]: the share of its picture in the
            sum of both, in linear radiance. No channel depends on it.
        surface_of: a quality whose surface serves in place of `quality`'s own where it is known already, as it is
            to an editor that has shown the finished picture; None for nobody's.
    """

    yaw_deg: float = 0.0
    exposure_ev: float = 0.0
    specular: float = 1.0
    shadow: float = 1.0
    background: str = "keep"
    background_fov_deg: float = 50.0
    background_blur_deg: float = 1.0
    quality: str | Tier = "live"
    channels: tuple[str, ...] | None = None
    forced_on: frozenset[str] = frozenset()
    forced_off: frozenset[str] = frozenset()
    tolerance: float = TOLERANCE
    specular_tint: float = 0.0
    shadow_softness: float = 0.0
    strength: float = 1.0
    surface_of: str | Tier | None = None

    @property
    def sliders(self) -> tuple[float, ...]:
        """What only the slider stage reads: the gains of specular and shadow, the specular's tint, the softness."""
        return self.specular, self.shadow, self.specular_tint, self.shadow_softness

    def looks_at(self, channel: str) -> bool:
        """Whether a channel is asked for."""
        return self.channels is None or channel in self.channels

    def forced(self, effect: str) -> bool | None:
        """True or False where the user has decided about an effect; None where the plan may."""
        if effect in self.forced_off:
            return False
        return True if effect in self.forced_on else None


_ANY = (-math.inf, math.inf)
EDIT_RANGES = {
    "yaw_deg": _ANY,
    "exposure_ev": _ANY,
    "specular": (0.0, 2.0),
    "shadow": (0.0, 2.0),
    "specular_tint": (-1.0, 1.0),
    "shadow_softness": (0.0, 1.0),
    "strength": (0.0, 1.0),
    "background_fov_deg": (0.0, 170.0),
    "background_blur_deg": (0.0, 20.0),
    "tolerance": (0.0, 1.0),
}


def check_edit(edit: Edit) -> None:
    """Raise InputError for a setting that is no finite number or out of its range, or for a name that is unknown."""
    for name, (low, high) in EDIT_RANGES.items():
        value = getattr(edit, name)
        if not (isinstance(value, Real) and math.isfinite(value)):
            raise InputError(f"{name} is a finite number, not {value!r}")
        if not low <= value <= high:
            raise InputError(f"{name} is from {low:g} to {high:g}, not {value:g}")
    if edit.background_fov_deg == 0:
        raise InputError("background_fov_deg is above 0: nothing is seen in 0 degrees")
    check_background(edit.background)
    for name in edit.channels or ():
        if name not in CHANNELS:
            raise InputError(f"unknown channel {name!r}: the channels are {', '.join(CHANNELS)}")


def is_plain_colour(background: str) -> bool:
    """Whether a background is a colour, "#rrggbb"."""
    return re.fullmatch("#[0-9a-fA-F]{6}", background) is not None


def check_background(background: str) -> None:
    """Raise InputError unless it is "keep", "match", "light", "transparent" or "#rrggbb"."""
    if background not in BACKGROUNDS and not (isinstance(background, str) and is_plain_colour(background)):
        names = ", ".join(BACKGROUNDS)
        raise InputError(f"unknown background {background!r}: use {names} or a colour such as #30343a")


def check_effects(names: frozenset[str]) -> None:
    """Raise InputError for a name that is no effect."""
    for name in sorted(names):
        if name not in EFFECTS:
            raise InputError(f"unknown effect {name!r}: the effects are {', '.join(EFFECTS)}")
