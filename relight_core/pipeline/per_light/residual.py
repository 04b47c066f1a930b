"""The residual: what the model misses of the photo, carried over to other lights.

Under the photo's own light the model's picture should be the photo. The residual is measured once, as the log of the
photo over the model (a ratio image: Liu, Shan and Zhang 2001), and multiplies the model's picture under any other
light. So a portrait under its own estimated light is the photo again.

Not all of the residual belongs to the surface. It is split by likely cause, and each part is kept under another light
to the degree that its cause remains. In these parts, *broad* is what extends over more than a mole:

- **Narrow darkening** (brows, lashes, stubble, dark cloth) mostly belongs to the surface. It is kept in proportion to
  how similarly a place is lit in both lights, since it may also be a cast shadow that the model missed.
- **Everything else**, such as a highlight that the model missed, fades in the same way, and faster on skin. There,
  what is brighter than the model, has another colour or is broad belongs more often to the light than to the surface.
- **Missed light and shadow** (`missed`), the broad part on skin, fades as the whole light becomes different
  (`lighting.likeness`), and the faster the more of it there is. So do colours that come from lamps or the sky (see
  `lamp_colours`), which also lie on lips, eyes and brows.
- **Fleeting parts** (`fleeting`) are kept only under a light that is very similar to the photo's. One is glare: skin or
  hair that is far brighter than its model because a light from behind grazes it. No model of the face's front can know
  that light, and how similarly the place is lit says little about it. The other is colours in deep shadow that the
  skin's albedo doesn't have, which come from another lamp.
- **The tint** (`tint`) is kept under any light: what a camera adds to the colour of all skin (`per_photo.saturation`),
  and the colours of everything that isn't skin, which photo and skin together determine better than the albedo does.
  Here, a mask or paint over all of a face (`per_photo.face_paint`), broad paint on skin (`per_photo.skin_colour`) and
  skin that is red by itself (`per_photo.own_redness`) don't count as skin, whatever the parsing takes them for. Nearly
  black hair and cloth keep the colour in which the photo shows them (`per_photo.black_colour`).
- **Dark hair** (`stays_dark`) stays dark under any light, since its strands shade each other. So does the edge of a
  beard that the parsing takes for neck: with half the albedo of skin, and far darker than its model, it is likelier
  hair.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import torch

from relight_core.face.parsing import FEWEST_PIXELS, INDEX, SURELY, likely, skin_share
from relight_core.imaging.ramp import ramp
from relight_core.imaging.tensor_colour import grey
from relight_core.imaging.tensor_logs import BLACK, LARGEST_LOG, log_ratios, without_mean
from relight_core.imaging.tensor_means import local_medians, local_range, middle_values
from relight_core.lighting.likeness import likeness
from relight_core.lighting.panorama import mean_luminance
from relight_core.pipeline.per_light.hints import Effects
from relight_core.pipeline.per_light.lamp_colours import MOLE, colours_of_lamps, colours_of_shade
from relight_core.pipeline.per_photo.blown import at_least, clipped_share, flesh_share
from relight_core.pipeline.per_photo.face_paint import face_paint
from relight_core.pipeline.per_photo.own_redness import own_redness
from relight_core.pipeline.per_photo.saturation import middle_colour, of_camera, saturation
from relight_core.pipeline.per_photo.seen_colour import not_as_seen
from relight_core.pipeline.per_photo.skin_colour import deep_shadow, painted
from relight_core.pipeline.per_photo.source_light import level_over_person, seen_of_person
from relight_core.pipeline.stages import Composed, Surface

_BEYOND, _PILED_UP = 0.05, 0.02
"""A value this far above 1 shows that the photo was not clipped there; one this near to 1 that it was."""
_FEW = 1e-4
"""If only this share of a photo's pixels is above 1 or at 1, it says little about clipping."""
_DARK_HAIR = 0.8
"""The share of hair's darkening that is kept under any light."""
_DARK_NECK, _DIM_NECK = (0.6, 1.2), (0.2, 0.8)
"""Ramps, in logs, over which a pixel of the neck becomes likelier hair: how much darker it is than its model, and its
albedo than that of most skin. Both must hold, since skin in a shadow that the model missed keeps its albedo."""
_HAIR_LOG_ODDS = 4.0
"""At the end of both ramps, this is added to the log odds of hair over neck."""
_FADES = 2.0
"""All but darkening is kept by a power of how similarly a place is lit: 1, and so much more on bare skin."""
_MOST_SATURATED = 0.6
"""A camera adds at most this share of skin's own colour to it."""
_GLARE_OF_SKIN, _GLARE_OF_HAIR = (0.2, 0.5), (0.5, 0.8)
"""Ramps of the log ratio over which what is brighter than the model becomes glare."""
_GLARE_FADES = 6
"""Fleeting parts are kept by this power of the likeness of two lights."""
_FOREIGN_FADES = 8
"""The same for shadows from outside, whose causes stand in front of the photo's own light or one very similar to it."""
_MISSED_FADES, _MUCH_MISSED = (2.0, 8.0), (0.22, 0.34)
"""Missed light is kept by a power of the likeness of two lights. It ramps from the first power to the second while the
standard deviation of missed light over the face's skin, in logs, goes from the first to the second. If a hat, leaves
or blinds cast shadows that the model doesn't know, the estimate of the photo's own light is wrong, and likeness to it
says little."""
_MISSED_ELSEWHERE = (0.26, 0.4)
"""Ramp of that deviation over which hair and cloth are taken to lie in such shadows too, instead of having that albedo.
"""
_BROAD = 2 * MOLE
"""As a share of the view's side, to each side: an area of other colours that is broader than this is surely paint."""
_STEP = (0.1, 0.3)
"""Ramp of the difference, in logs, of two medians a mole apart, over which there is the edge of a shadow."""


@dataclass(frozen=True)
class Residual:
    """Photo over model under the photo's own light; the module describes the parts.

    Attributes:
        log_ratio: (1, 3, S, S) the whole residual in [-3, 3], or up to 3 above the largest log radiance of a photo that
            exceeds 1.
        shading: (1, 1, S, S) luminance of the model's explicit sum under that light, normalised.
        stays_dark: (1, 1, S, S) in [0, 1], the share of a darkening that is kept under any light.
        skin: (1, 1, S, S) probability of bare skin.
        broad: (1, 1, S, S) the broad part of the log ratio's mean over channels: on skin, and elsewhere too if skin
            lies in shadows that the model missed. At such a shadow's edge it is all of the mean.
        missed: (1, 3, S, S) light and shadow that the model missed: the broad part without glare, and the colours that
            lamps or the sky give a face.
        missed_fades: `missed` is kept by this power of another light's likeness to the photo's.
        tint: (1, 3, S, S) the part of the log ratio, of mean 0 over channels, that is kept under any light.
        fleeting: (1, 3, S, S) the part of the log ratio that is kept only under the photo's own light or one very
            similar to it.
        light: (1, 16, 32, 3) the photo's own light, linear radiance.
        level: of that light, such that model and photo are equally bright over the person.
        largest_log: upper limit of the log ratio.
        foreign_shadow: (1, 3, S, S) logs of what shadows from outside leave of the photo's light, which no other part
            contains; None if there are none.
    """

    log_ratio: torch.Tensor
    shading: torch.Tensor
    stays_dark: torch.Tensor
    skin: torch.Tensor
    broad: torch.Tensor
    missed: torch.Tensor
    missed_fades: float
    tint: torch.Tensor
    fleeting: torch.Tensor
    light: torch.Tensor
    level: float
    largest_log: float = LARGEST_LOG
    foreign_shadow: torch.Tensor | None = None


@torch.inference_mode()
def find_residual(
    surface: Surface,
    recorded: torch.Tensor,
    source_light: torch.Tensor,
    compose: Callable[[torch.Tensor], Composed],
) -> Residual:
    """Compare a photo with its model.

    Args:
        recorded: (1, 3, S, S) the view at the surface's size, linear, without shadows from outside. Unlike the
            surface's own photo it is not clipped, and may exceed 1.
        source_light: (1, 16, 32, 3) the photo's estimated light.
        compose: the model, from a normalised light to a composed image.
    """
    level = mean_luminance(source_light[0].cpu().numpy())
    model = compose(source_light / max(level, 1e-12))
    over_person = level_over_person(surface, model.image.float())
    level = level if over_person is None else over_person
    log_ratio, largest_log = _photo_over_model(surface, recorded, level, model.image.float())
    mean = log_ratio.mean(1, keepdim=True)
    hair, skin = _hair_and_skin(surface, mean)
    colour = without_mean(log_ratio)
    known = seen_of_person(surface)
    skin = _unpainted_skin(surface, colour, skin, known)
    seen_skin = skin * known
    of_lamps = colours_of_lamps(surface, model.plain, colour, skin, seen_skin)
    glare = _glare_share(mean, skin, hair)
    of_other_lamps = torch.maximum(glare, deep_shadow(surface.photo, skin))
    broad, missed, much = _missed_light(mean, skin, seen_skin, glare)
    of_shade = much * colours_of_shade(surface, missed, colour, skin, seen_skin) if much else torch.zeros_like(colour)
    by_camera = _by_camera(log_ratio - of_shade, surface.albedo, seen_skin)
    of_lamps = of_lamps + of_shade
    tint = colour + skin * (by_camera - colour) - (1 - skin) * of_lamps
    of_light = not_as_seen(surface, tint)
    tint = tint - of_light
    few, many = _MISSED_FADES
    return Residual(
        log_ratio=log_ratio,
        shading=grey(model.plain),
        stays_dark=_DARK_HAIR * hair,
        skin=skin,
        broad=broad,
        missed=missed + (1 - of_other_lamps) * of_lamps,
        missed_fades=few + (many - few) * much,
        tint=tint,
        fleeting=glare * mean + of_other_lamps * (colour - tint - of_light) + of_light,
        light=source_light,
        level=level,
        largest_log=largest_log,
    )


def at_light_level(residual: Residual, level: float) -> Residual:
    """The residual for another level of the photo's light; the ratio makes up for the change of brightness."""
    if not (level > 0 and residual.level > 0):
        return residual
    brighter = math.log(residual.level / level)
    log_ratio = (residual.log_ratio + brighter).clamp(-LARGEST_LOG, residual.largest_log)
    return replace(residual, log_ratio=log_ratio, broad=residual.broad + brighter * residual.skin, level=level)


def _photo_over_model(
    surface: Surface, recorded: torch.Tensor, level: float, image: torch.Tensor
) -> tuple[torch.Tensor, float]:
    """`log_ratio` and `largest_log` of a residual.

    Args:
        surface, recorded: as of `find_residual`.
        level: of the photo's light.
        image: (1, 3, S, S) the model's image under it, normalised.
    """
    # The model saw a photo that was clipped to 1, so a recorded value above 1 may exceed it by that much more.
    largest_log = LARGEST_LOG + math.log(max(float(recorded.max()), 1.0))
    log_ratio = log_ratios(recorded / max(level, 1e-4), image).clamp(-LARGEST_LOG, largest_log)
    if was_clipped := _was_clipped(recorded):
        log_ratio = at_least(log_ratio, was_clipped * clipped_share(recorded), flesh_share(surface.parsing))
    return log_ratio, largest_log


def _hair_and_skin(surface: Surface, mean: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """Probabilities of hair and skin, (1, 1, S, S) each, after parts of the neck that are likelier hair became hair.

    Args:
        mean: (1, 1, S, S) of the log ratio over its channels.
    """
    hair, neck = (surface.parsing[:, INDEX[name], None] for name in ("hair", "neck"))
    skin = skin_share(surface.parsing)
    surely = skin > SURELY
    if int(surely.sum()) < FEWEST_PIXELS:
        return hair, skin
    albedo = grey(surface.albedo).clamp_min(BLACK).log()
    dark, dim = -mean, albedo[surely].median() - albedo
    both = torch.minimum(ramp(dark, *_DARK_NECK), ramp(dim, *_DIM_NECK))
    likelier = hair * torch.exp(_HAIR_LOG_ODDS * both)
    mistaken = (hair + neck) * likelier / (likelier + neck).clamp_min(1e-6) - hair
    return hair + mistaken, skin - mistaken


def _unpainted_skin(surface: Surface, colour: torch.Tensor, skin: torch.Tensor, known: torch.Tensor) -> torch.Tensor:
    """The probability of skin without paint, masks or burns, which have a colour of their own, (1, 1, S, S).

    Args:
        surface: of the view.
        colour: (1, 3, S, S) logs of photo over model, of mean 0.
        skin: (1, 1, S, S) probability of bare skin.
        known: of `seen_of_person`.
    """
    skin = skin * (1 - face_paint(surface))
    seen = surface.albedo.clamp_min(BLACK).log() + colour
    ratios = seen - seen[:, 1:2]
    skin = skin * ~_broadly_painted(surface, ratios, skin)
    return skin * (1 - _broad_part(own_redness(surface, ratios, skin * known)))


def _broadly_painted(surface: Surface, ratios: torch.Tensor, skin: torch.Tensor) -> torch.Tensor:
    """Where the photo shows broad paint on skin or a mask over it, (1, 1, S, S) bool, whether the albedo has it or not.

    Narrow areas don't count: a line may be the rim of a light from behind, and ears are red where light shines through.

    Args:
        surface: of the view.
        ratios: (1, 3, S, S) log ratios to green of the photo's colours, with the known colour of the light removed.
        skin: (1, 1, S, S) probability of what the parsing takes for bare skin.
    """
    sure = (skin > SURELY)[0, 0]
    if int(sure.sum()) < FEWEST_PIXELS:
        return torch.zeros_like(skin, dtype=torch.bool)
    paint = painted(ratios - middle_values(ratios, sure), surface.photo, skin).to(skin)
    return _broad_part(paint) > 0


def _broad_part(share: torch.Tensor) -> torch.Tensor:
    """A share (1, 1, S, S), limited to what its broad areas have within reach: a soft morphological opening."""
    return torch.minimum(share, local_range(local_range(share, _BROAD)[0], 2 * _BROAD)[1])


def _missed_light(
    mean: torch.Tensor, skin: torch.Tensor, seen_skin: torch.Tensor, glare: torch.Tensor
) -> tuple[torch.Tensor, torch.Tensor, float]:
    """`broad` and, without colours, `missed` of a residual, and the degree in [0, 1] to which much light was missed.

    Args:
        mean: (1, 1, S, S) of the log ratio over its channels.
        skin, seen_skin: (1, 1, S, S) probability of bare skin, and of skin that the photo shows unclipped.
        glare: (1, 1, S, S) the share of the log ratio that is glare.
    """
    broad = skin * _broad_log_ratio(mean, skin)
    sure = (seen_skin > SURELY)[0, 0]
    known = int(sure.sum()) >= FEWEST_PIXELS
    middle = middle_values(broad, sure) if known else 0.0
    missed = (1 - glare) * (broad - skin * middle)
    spread = float(missed[0][:, sure].std()) if known else 0.0
    if elsewhere := ramp(spread, *_MISSED_ELSEWHERE):
        rest = elsewhere * (1 - skin) * _broad_log_ratio(mean, 1 - skin)
        broad, missed = broad + rest, missed + (1 - glare) * rest
    return broad, missed, ramp(spread, *_MUCH_MISSED)


def _broad_log_ratio(mean: torch.Tensor, part: torch.Tensor) -> torch.Tensor:
    """The part of a log ratio (1, 1, S, S) that is shared by an area larger than a mole, (1, 1, S, S).

    It is a local median, which can't follow the bends of a shadow's edge. So at an edge everything between the medians
    of both sides counts.
    """
    middle = local_medians(mean, part, MOLE)
    least, most = local_range(middle, MOLE)
    at_step = ramp(most - least, *_STEP)
    return mean.clamp(middle + at_step * (least - middle), middle + at_step * (most - middle))


def _glare_share(mean: torch.Tensor, skin: torch.Tensor, hair: torch.Tensor) -> torch.Tensor:
    """Certainty, (1, 1, S, S) in [0, 1], that a log ratio with a mean (1, 1, S, S) is glare of a light from behind."""
    share = torch.zeros_like(skin)
    for kind, (start, full) in ((skin, _GLARE_OF_SKIN), (hair, _GLARE_OF_HAIR)):
        share = share + likely(kind) * ramp(mean, start, full)
    return share.clamp_max(1)


def _by_camera(log_ratio: torch.Tensor, albedo: torch.Tensor, skin: torch.Tensor) -> torch.Tensor:
    """The log colour that the camera adds to all skin, (1, 3, 1, 1): the part of skin's colour that the model lacks."""
    own, off = (middle_colour(image, skin) for image in (albedo, log_ratio.exp()))
    if own is None:
        return torch.zeros_like(log_ratio[..., :1, :1])
    return of_camera(off, own, saturation(off, own).clamp(0, _MOST_SATURATED))[None, :, None, None]


def _was_clipped(recorded: torch.Tensor) -> float:
    """Certainty, in [0, 1], that a photo was clipped at 1: lower the more pixels exceed 1, relative to those at 1.

    A few pixels above 1 may be overshoot of a resampling, or a glint that was edited in.
    """
    brightest = recorded.amax(1)
    beyond = ((brightest - 1) / _BEYOND).clamp(0, 1).sum()
    piled_up = (1 - (brightest - 1).abs() / _PILED_UP).clamp(0, 1).sum()
    return float(1 - (2 * beyond / (beyond + piled_up + _FEW * brightest.numel())).clamp_max(1))


@torch.inference_mode()
def add_residual(
    residual: Residual, composed: Composed, effects: Effects, light: torch.Tensor
) -> tuple[torch.Tensor, Effects]:
    """Multiply the model's image under another light by what is kept of the residual, and its effects by its luminance.

    Args:
        residual: of the photo.
        composed, effects: the model's, under the other light.
        light: (1, 16, 32, 3) the other light.

    Returns:
        The image (1, 3, S, S), linear, >= 0, and the effects.
    """
    shading = grey(composed.plain)
    darker, brighter = torch.minimum(shading, residual.shading), torch.maximum(shading, residual.shading)
    alike = (darker + BLACK) / (brighter + BLACK)
    narrow = residual.log_ratio.mean(1, keepdim=True) - residual.broad
    darkening = narrow.clamp_max(0)
    kept = darkening * torch.maximum(alike, residual.stays_dark) + residual.tint
    shared = likeness(residual.light, light)
    of_light = (1 - shared**_GLARE_FADES) * residual.fleeting + (1 - shared**residual.missed_fades) * residual.missed
    all_else = residual.log_ratio - darkening - residual.tint - of_light
    logs = kept + all_else * alike ** (1 + _FADES * residual.skin)
    if residual.foreign_shadow is not None:
        logs = logs + shared**_FOREIGN_FADES * residual.foreign_shadow
    ratio = torch.exp(logs)
    image = ((composed.image.float() + BLACK) * ratio - BLACK).clamp_min(0)
    return image, replace(effects, specular=effects.specular * grey(ratio), shadow=effects.shadow * grey(ratio))
