"""Inputs of SS and composition beyond the paper's: light looked up by the normal, and the explicit sum.

Training and the editor share these functions, so that a network sees the same inputs in both.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import torch
import torch.nn.functional as F

from relight_core.face.gloss import GLOSS_SHARE
from relight_core.imaging.ramp import ramp
from relight_core.imaging.tensor_colour import grey
from relight_core.imaging.tensor_constants import constant
from relight_core.imaging.tensor_means import with_neighbours
from relight_core.networks.specular_shadow import Occlusion, SpecularShadowConfig

if TYPE_CHECKING:
    import numpy as np

    from relight_core.pipeline.per_light.fine_edges import ShadowEdges

_NOTHING = 1e-6
"""Smallest divisor."""
_CERTAIN = (0.5, 0.9)
"""Ramp of the share of light that the relief hides, over which a shadow becomes certain."""


def specular_shadow_hints(
    config: SpecularShadowConfig,
    reflected: torch.Tensor,
    relief_shadow: torch.Tensor | None,
    relief: torch.Tensor | None = None,
    parsing: torch.Tensor | None = None,
) -> torch.Tensor | None:
    """The SS network's inputs besides the normal.

    Args:
        config: which of them the network has.
        reflected: (B, 6, H, W) unoccluded irradiance over pi and gloss (see `lighting.reflection`).
        relief_shadow: (B, 1, H, W) shadow fraction cast by the relief, if configured.
        relief: (B, 1, H, W) height toward the camera in half-widths of the view, if configured.
        parsing: (B, classes, H, W) probabilities, the background first, if configured.

    Returns:
        (B, C, H, W), or None if there are none.

    Raises:
        ValueError: a configured input is missing.
    """
    both = (surface_hints(config, relief, parsing), light_hints(config, reflected, relief_shadow))
    hints = [part for part in both if part is not None]
    return torch.cat(hints, 1) if hints else None


def surface_hints(
    config: SpecularShadowConfig, relief: torch.Tensor | None, parsing: torch.Tensor | None
) -> torch.Tensor | None:
    """The part of `specular_shadow_hints` that doesn't depend on the light, (B, 1 + classes, H, W); it comes first."""
    if not config.parsing_classes:
        return None
    if relief is None or parsing is None:
        raise ValueError("this SS network expects the relief and the parsing")
    return torch.cat([relief * (1 - parsing[:, :1]), parsing], 1)


def light_hints(
    config: SpecularShadowConfig, reflected: torch.Tensor, relief_shadow: torch.Tensor | None
) -> torch.Tensor | None:
    """The part of `specular_shadow_hints` that depends on the light, (B, up to 3, H, W)."""
    hints = []
    if config.per_pixel_light:
        hints += [torch.log1p(grey(reflected[:, :3])), torch.log1p(4 * grey(reflected[:, 3:]))]
    if config.relief_shadow:
        if relief_shadow is None:
            raise ValueError("this SS network expects the shadow of the relief")
        hints.append(relief_shadow)
    return torch.cat(hints, 1) if hints else None


def gloss_share(parsing: torch.Tensor) -> torch.Tensor:
    """Gloss as a share of that of skin, (B, 1, H, W) in (0, 1], from parsing probabilities (B, classes, H, W)."""
    return torch.tensordot(parsing, constant(GLOSS_SHARE, parsing.device, parsing.dtype), ([1], [0]))[:, None]


def with_dull_parts(reflected: torch.Tensor, parsing: torch.Tensor) -> torch.Tensor:
    """Irradiance and gloss (B, 6, H, W), with the gloss of skin reduced to that of hair, cloth and so on."""
    return torch.cat([reflected[:, :3], reflected[:, 3:] * gloss_share(parsing)], 1)


@dataclass
class Effects:
    """The paper's two additive effect channels, (B, 1, H, W) >= 0, in units of the normalised light.

    Attributes:
        colour_odds: (B, 3, H, W) > 0, odds that each colour's light is hidden, over the odds for all light together;
            None if colours don't differ. The shadow's mean over colours, weighted by luminance, stays `shadow`.
        by_relief: (B, 1, H, W) in [0, 1], the share of the diffuse light that the relief alone hides; None if it is
            not known.
        gloss_by_relief: the same for the gloss, of which a lamp may give a larger share than of the diffuse light;
            None if it equals `by_relief`.
        interreflection: (B, 3, H, W) >= 0, light of small lamps that other skin reflects (see `skin_bounce`); None if
            the shadow already contains it, as the network's does.
        edges: the ends of small lamps' shadows, for drawing them at a higher resolution; None if there are none.
    """

    specular: torch.Tensor
    shadow: torch.Tensor
    colour_odds: torch.Tensor | None = None
    by_relief: torch.Tensor | None = None
    gloss_by_relief: torch.Tensor | None = None
    interreflection: torch.Tensor | None = None
    edges: ShadowEdges | None = None


def as_channels(effects: Effects) -> Effects:
    """The effects as the paper's channels: the shadow is what the picture lacks, so the bounce is subtracted."""
    if effects.interreflection is None:
        return effects
    return Effects(effects.specular, (effects.shadow - grey(effects.interreflection)).clamp_min(0))


def effects_of(occlusion: Occlusion, reflected: torch.Tensor, albedo: torch.Tensor) -> Effects:
    """Additive specular and shadow (paper, section 3.2) from the occluded fractions.

    I_sp is the gloss that is not occluded; I_sh is what occlusion takes from albedo * irradiance + gloss.

    Args:
        occlusion: logits.
        reflected, albedo: as of `explicit_sum`.
    """
    shadow_fraction, gloss_fraction = torch.sigmoid(occlusion.shadow), torch.sigmoid(occlusion.gloss)
    gloss = grey(reflected[:, 3:])
    specular = gloss * (1 - gloss_fraction)
    shadow = grey(albedo * reflected[:, :3]) * shadow_fraction + gloss * gloss_fraction
    return Effects(specular, shadow)


def estimated_effects(
    config: SpecularShadowConfig, estimate: Occlusion, reflected: torch.Tensor, albedo: torch.Tensor
) -> Effects:
    """The effect channels from the output of an SS network of this configuration.

    Args:
        reflected, albedo: as of `explicit_sum`.
    """
    if config.additive:
        return Effects(F.softplus(estimate.gloss.float()), F.softplus(estimate.shadow.float()))
    return effects_of(estimate, reflected, albedo)


def smooth_gloss(gloss: torch.Tensor) -> torch.Tensor:
    """Gloss (B, C, H, W), averaged with that of the neighbouring pixels' normals.

    A small lamp's highlight on a sharp ridge falls on single pixels. Upsampled, these would be streaks and steps.
    """
    return with_neighbours(gloss, 1 / 3)


def hidden_gloss(effects: Effects, gloss: torch.Tensor) -> torch.Tensor:
    """The part of the grey unoccluded gloss that is hidden, (B, 1, H, W) >= 0; the shadow contains it."""
    return (gloss - effects.specular).clamp_min(0)


def hidden_share(effects: Effects, diffuse: torch.Tensor, gloss: torch.Tensor) -> torch.Tensor:
    """Share of the diffuse light that the shadow takes, (B, 1, H, W) in [0, 1].

    The hidden gloss, which the shadow contains too, is subtracted first.

    Args:
        effects: of the light.
        diffuse, gloss: (B, 1, H, W), luminance of albedo times irradiance, and of gloss, both unoccluded.
    """
    return ((effects.shadow - hidden_gloss(effects, gloss)) / diffuse.clamp_min(1e-4)).clamp(0, 1)


def with_hidden_share(effects: Effects, hidden: torch.Tensor, diffuse: torch.Tensor, gloss: torch.Tensor) -> Effects:
    """The effects with a shadow for which `hidden_share` returns `hidden`."""
    return replace(effects, shadow=hidden * diffuse + hidden_gloss(effects, gloss))


def doubtful_shadow(
    effects: Effects, diffuse: torch.Tensor, gloss: torch.Tensor, trusted: torch.Tensor
) -> torch.Tensor:
    """The shadow without its certain part, (B, 1, H, W) >= 0, as composition sees it.

    Light that network and relief both take to be hidden is certain where the relief hides nearly all light. To
    composition such a place then looks as if it faced away from the light.

    Args:
        effects: of the light.
        diffuse, gloss: as of `hidden_share`.
        trusted: (B, 1, H, W) in [0, 1], trust in the relief.
    """
    if effects.by_relief is None:
        return effects.shadow
    by_relief = effects.by_relief * trusted
    gloss_by_relief = by_relief if effects.gloss_by_relief is None else effects.gloss_by_relief * trusted
    of_diffuse = torch.minimum(hidden_share(effects, diffuse, gloss), by_relief) * diffuse
    of_gloss = torch.minimum(hidden_gloss(effects, gloss), gloss_by_relief * gloss)
    certain = ramp(by_relief, *_CERTAIN) * of_diffuse + ramp(gloss_by_relief, *_CERTAIN) * of_gloss
    return (effects.shadow - certain).clamp_min(0)


def explicit_sum(
    albedo: torch.Tensor, reflected: torch.Tensor, effects: Effects, specular_gain=1.0, shadow_gain=1.0
) -> torch.Tensor:
    """albedo * irradiance - shadow + specular, (B, 3, H, W) >= 0.

    The additive shadow is grey. It is applied as a share of each colour, modified by the colour's odds, so that it
    never takes more of a colour than there is. Gains above 1 are powers of what is left: if they multiplied the hidden
    share, a gain of 2 would turn everything black of which half is hidden.

    Args:
        albedo: (B, 3, H, W) linear, [0, 1].
        reflected: (B, 6, H, W) >= 0, unoccluded irradiance over pi and gloss (see `lighting.reflection`).
        effects: of the same light.
        specular_gain, shadow_gain: the sliders' values, [0, 2].
    """
    matt, gloss = explicit_parts(albedo, reflected, effects, shadow_gain)
    return matt + specular_gain * gloss


def explicit_parts(
    albedo: torch.Tensor, reflected: torch.Tensor, effects: Effects, shadow_gain: float = 1.0
) -> tuple[torch.Tensor, torch.Tensor]:
    """The two parts of `explicit_sum`, (B, 3, H, W) >= 0 each: diffuse, and specular at a gain of 1.

    The gain of the shadow does not affect the light that is reflected into it.
    """
    diffuse = albedo * reflected[:, :3]
    gloss = grey(reflected[:, 3:])
    fraction = hidden_share(effects, grey(diffuse), gloss)
    if effects.colour_odds is not None:
        fraction = hidden_by_colour(fraction, effects.colour_odds, diffuse)
    colour = reflected[:, 3:] / gloss.clamp_min(1e-6)
    matt = diffuse * light_left(fraction, shadow_gain)
    return matt if effects.interreflection is None else matt + effects.interreflection, effects.specular * colour


def light_left(hidden: torch.Tensor | np.ndarray, shadow_gain: float) -> torch.Tensor | np.ndarray:
    """Share of the diffuse light that a shadow leaves, in [0, 1].

    Args:
        hidden: of any shape, the share in [0, 1] that is hidden at a gain of 1.
        shadow_gain: [0, 2].
    """
    return 1 - shadow_gain * hidden if shadow_gain <= 1 else (1 - hidden) ** shadow_gain


def hidden_by_colour(hidden: torch.Tensor, colour_odds: torch.Tensor, diffuse: torch.Tensor) -> torch.Tensor:
    """The hidden share of each colour of the diffuse light, (B, 3, H, W) in [0, 1], from that of all light together.

    It uses ratios of odds. A ratio of shares only holds for one depth of shadow: where more is hidden than the relief
    hides, it would take all blue from half a shadow. A ratio of odds is the same where little is hidden, and leaves
    nothing of any colour where everything is.

    Args:
        hidden: (B, 1, H, W) in [0, 1], which stays the mean over the colours, weighted by luminance.
        colour_odds: as of `Effects`.
        diffuse: (B, 3, H, W) >= 0, unoccluded.
    """
    all_light = grey(diffuse).clamp_min(_NOTHING)
    by_colour = _at_odds(hidden, colour_odds)
    by_colour = _at_odds(by_colour, _odds_ratio(hidden, grey(diffuse * by_colour) / all_light))
    # The odds bring the mean only near `hidden`. The rest is corrected by scaling the hidden shares, or what is left.
    mean = grey(diffuse * by_colour) / all_light
    fewer = (hidden / mean.clamp_min(_NOTHING)).clamp_max(1)
    less_left = ((1 - hidden) / (1 - mean).clamp_min(_NOTHING)).clamp(0, 1)
    return 1 - (1 - by_colour * fewer) * less_left


def _at_odds(share: torch.Tensor, ratio: torch.Tensor) -> torch.Tensor:
    """The share whose odds are `ratio` times those of `share`."""
    return share * ratio / (1 - share + share * ratio).clamp_min(_NOTHING)


def _odds_ratio(one: torch.Tensor, other: torch.Tensor) -> torch.Tensor:
    """The odds of one share over those of another."""
    return (one * (1 - other)).clamp_min(_NOTHING) / (other * (1 - one)).clamp_min(_NOTHING)
