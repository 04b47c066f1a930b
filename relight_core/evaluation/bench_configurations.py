"""What the bench compares: the quality tiers, and each of them with one thing changed."""

from __future__ import annotations

from dataclasses import dataclass, replace

from relight_core.pipeline.quality import TIERS, Tier

_MULTIPLE = 32


@dataclass(frozen=True)
class Configuration:
    """One setting of everything that trades accuracy for time.

    Attributes:
        name: in words.
        tier: what runs.
        tier_name: the quality tier that is exactly this, or the one it was derived from.
        is_tier: whether it is that tier itself.
    """

    name: str
    tier: Tier
    tier_name: str
    is_tier: bool


def configurations(*, quick: bool = False) -> list[Configuration]:
    """The tiers first, as the editor uses them in motion next, then their variants; no two are the same setting.

    Args:
        quick: of the variants only those of "live" that leave a network out.
    """
    live = replace(TIERS["live"], shadow_network=True, correction=True)
    settings = [
        *(Configuration(name, tier, name, True) for name, tier in TIERS.items()),
        *(Configuration(f"{name}, on final's surface", tier, name, False) for name, tier in _in_motion()),
        *(Configuration(f"live, {name}", tier, "live", False) for name, tier in _variants(live, quick)),
    ]
    by_tier: dict[Tier, Configuration] = {}
    for setting in settings:
        by_tier.setdefault(setting.tier, setting)
    return list(by_tier.values())


def _in_motion() -> list[tuple[str, Tier]]:
    """The quick tiers on the surface that the picture at rest has found."""
    return [(name, TIERS[name].on_surface_of(TIERS["final"])) for name in ("draft", "live")]


def _variants(live: Tier, quick: bool) -> list[tuple[str, Tier]]:
    fewer = [
        ("no correction", replace(live, correction=False)),
        ("relief's shadow, corrected", replace(live, shadow_network=False)),
        ("no network per light", replace(live, shadow_network=False, correction=False)),
    ]
    if quick:
        return fewer
    half, smaller, larger = (_scaled(live.network_size, factor) for factor in (0.5, 0.75, 1.5))
    return [
        *fewer,
        ("wide networks", replace(live, pair="wide")),
        ("networks in fp32", replace(live, precision="fp32")),
        (f"light at {half}", replace(live, network_size=half)),
        (f"light at {smaller}", replace(live, network_size=smaller)),
        (f"light at {larger}", replace(live, network_size=larger, delight_size=max(live.delight_size, larger))),
        ("relief at 32", replace(live, relief_size=32)),
        ("relief at 96", replace(live, relief_size=96)),
        ("mirrored", replace(live, mirrored=True)),
        ("second look", replace(live, looks_twice=True)),
        (
            "no network per light, relief at 128",
            replace(live, shadow_network=False, correction=False, relief_size=128),
        ),
    ]


def _scaled(size: int, factor: float) -> int:
    """A size the networks take."""
    return max(round(size * factor / _MULTIPLE), 1) * _MULTIPLE
