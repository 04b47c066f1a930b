"""What the user has set: one immutable record that every stage reads its own fields of."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Edit:
    """The state of every slider.

    Attributes:
        yaw_deg: turn of the environment map; positive moves its content to the right.
        exposure_ev: display and export exposure in stops; read by no network.
        specular: gain on the specular channel, [0, 2]; 1 is as estimated (paper, Figure 12).
        shadow: gain on the shadow channel, [0, 2]; 1 is as estimated (paper, Figure 12).
        background: "keep", "light", "transparent" or "#rrggbb" (sRGB).
        quality: "draft", "live" or "final".
    """

    yaw_deg: float = 0.0
    exposure_ev: float = 0.0
    specular: float = 1.0
    shadow: float = 1.0
    background: str = "keep"
    quality: str = "live"
