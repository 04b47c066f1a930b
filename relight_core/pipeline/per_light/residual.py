"""What the model misses of the photo, carried over to other lights.

Under the light that the photo was taken in, the model's picture should be the photo. What it misses is measured once,
as the log of the photo over the model (a ratio image: Liu, Shan and Zhang 2001), and multiplies what the model makes of
any other light. So a portrait under its own estimated light is the photo again.

Not all of that belongs to the surface. Each part stays under another light as far as its cause does:

- **Narrow darkening** (brows, lashes, stubble, dark cloth) is mostly the surface's. It stays in proportion to how
  alike a place is lit in both lights: a cast shadow that the model missed belongs to the photo's light.
- **All else**, such as a highlight that the model missed, fades likewise, on skin faster: what is brighter there than
  the model, of another colour, or off over more than a mole is the light's more often than the surface's.
- **Missed light and shadow** (`missed`), which is what is off over more than a mole on skin, fades as the whole light
  becomes another (`lighting.likeness`), the faster the more of it there is. So do colours that are a lamp's or the
  sky's: where lamps of several colours light a face, those over more than a mole that flush and tan don't explain, on
  lips, eyes and brows too; and where much of the skin lies in shadows that the model missed, the colour of these.
- **Fleeting parts** (`fleeting`) stay only under a light much like the photo's: glare, which is skin or hair far
  brighter than its model, grazed by a light from behind that no model of the face's front knows, and about which how a
  place is lit says little; and colours in deep shadow that the skin's albedo doesn't have, which are another lamp's.
- **The tint** (`tint`) stays under any light: what a camera adds to the colour of all skin (`per_photo.saturation`),
  and the colours of all that is not skin, of which photo and skin together say more than the albedo does. A mask and
  paint over all of a face (`per_photo.face_paint`), broad paint amid skin (`per_photo.skin_colour`), and what is red by
  itself (`per_photo.own_redness`) are no skin here, whatever the parsing takes them for; nearly black hair and cloth
  keep the colour they are seen in (`per_photo.black_colour`).
- **Dark hair** (`stays_dark`): strands lie in each other's shadow under any light. So does a beard's edge that the
  parsing takes for the neck, and whose albedo is half that of skin: far darker than that model, it is likelier hair.
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
"""How far above 1 a pixel's value says that the photo was not clipped there, and how near to 1 that it was."""
_FEW = 1e-4
"""The share of a photo's pixels that is too few to tell."""
_DARK_HAIR = 0.8
"""The share of hair's darkening that stays under any light."""
_DARK_NECK, _DIM_NECK = (0.6, 1.2), (0.2, 0.8)
"""How much darker than its model a neck's pixel is, and its albedo than that of most skin, in logs, from which on it
is likelier hair, in part and altogether. Both count: skin in a shadow that the model missed keeps its albedo."""
_HAIR_LOG_ODDS = 4.0
"""By how much both at their full raise the log odds of hair over neck."""
_FADES = 2.0
"""By how much the power rises, from elsewhere to bare skin, by which all but darkening follows how alike a place is
lit."""
_MOST_SATURATED = 0.6
"""The largest share of skin's own colour that a camera is believed to add to it."""
_GLARE_OF_SKIN, _GLARE_OF_HAIR = (0.2, 0.5), (0.5, 0.8)
"""Log ratios from which on brighter than the model counts as glare, in part and altogether."""
_GLARE_FADES = 6
"""The power of what two lights share by which fleeting parts stay."""
_FOREIGN_FADES = 8
"""The same for shadows from outside: what throws them stands before the photo's own light, and before one much like
it."""
_MISSED_FADES, _MUCH_MISSED = (2.0, 8.0), (0.22, 0.34)
"""The powers of what two lights share by which missed light stays, and its standard deviations over a face's skin, in
logs: up to the first the first power holds, from the second on the second. Where a hat, leaves or blinds throw shadows
that the model knows nothing of, the photo's own light is not what it seems, and being like that one says little."""
_MISSED_ELSEWHERE = (0.26, 0.4)
"""The deviations from which on hair and cloth lie in such shadows too, perhaps and surely; else it is their albedo."""
_BROAD = 2 * MOLE
"""Of the view's side, to each side: what is broader and of other colours, with plain skin about it, is surely paint."""
_STEP = (0.1, 0.3)
"""By how much, in logs, medians a mole apart differ where there may be, and surely is, the edge of a shadow."""


@dataclass(frozen=True)
class Residual:
    """Photo over model under the photo's own light.

    Attributes:
        log_ratio: (1, 3, S, S), [-3, 3], or up to 3 above the largest log radiance of a photo that exceeds 1.
        shading: (1, 1, S, S) luminance of the model's explicit sum under that light, normalised.
        stays_dark: (1, 1, S, S) in [0, 1], how much of a darkening stays under whatever light.
        skin: (1, 1, S, S) probability of bare skin.
        broad: (1, 1, S, S) the part of the mean log ratio that more than a mole shares, on skin, and on all else
            where skin lies in shadows that the model lacks; at such a shadow's edge, all of it.
        missed: (1, 3, S, S) the part of it that is no glare, and the colours of other lamps and of the sky on a face:
            light and shadow that the model missed, which fade as the whole light becomes another.
        missed_fades: the power of what another light shares with the photo's by which `missed` stays.
        tint: (1, 3, S, S) the part of the log ratio, of mean 0, that stays under whatever light.
        fleeting: (1, 3, S, S) the part of the log ratio that only the photo's own light or one much like it gives.
        light: (1, 16, 32, 3) the photo's own, linear radiance.
        level: of that light, such that model and photo are equally bright over the person.
        largest_log: the largest log ratio there may be.
        foreign_shadow: (1, 3, S, S) logs of what shadows from outside leave of the photo's light, which the other parts
            know nothing of; None where there are none.
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
        recorded: (1, 3, S, S) the view at the surface's size, linear, without shadows from outside, with the radiance
            above 1 that the surface's own photo was clipped to, where the file holds any.
        source_light: (1, 16, 32, 3) the photo's estimated light.
        compose: the model: a normalised light to a composed image.
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
    skin = _of_skins_colour(surface, colour, skin, known)
    seen_skin = skin * known
    of_lamps = colours_of_lamps(surface, model.plain, colour, skin, seen_skin)
    glare = _glare_share(mean, skin, hair)
    of_others = torch.maximum(glare, deep_shadow(surface.photo, skin))
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
        missed=missed + (1 - of_others) * of_lamps,
        missed_fades=few + (many - few) * much,
        tint=tint,
        fleeting=glare * mean + of_others * (colour - tint - of_light) + of_light,
        light=source_light,
        level=level,
        largest_log=largest_log,
    )


def at_light_level(residual: Residual, level: float) -> Residual:
    """The same at another level of the photo's light: what that changes of the whole picture goes into the ratio."""
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
        recorded: as of `find_residual`.
        level, image: of the photo's light, and the model's image (1, 3, S, S) under it, normalised.
    """
    # The model is of a surface in a photo that was clipped to 1.
    largest_log = LARGEST_LOG + math.log(max(float(recorded.max()), 1.0))
    log_ratio = log_ratios(recorded / max(level, 1e-4), image).clamp(-LARGEST_LOG, largest_log)
    if was_clipped := _was_clipped(recorded):
        log_ratio = at_least(log_ratio, was_clipped * clipped_share(recorded), flesh_share(surface.parsing))
    return log_ratio, largest_log


def _hair_and_skin(surface: Surface, mean: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """(1, 1, S, S) each, their probabilities, with what was taken for the neck and is likelier hair moved to hair.

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


def _of_skins_colour(surface: Surface, colour: torch.Tensor, skin: torch.Tensor, known: torch.Tensor) -> torch.Tensor:
    """(1, 1, S, S) probability of skin (1, 1, S, S) that has no colour of its own, as paint, a mask or a burn has.

    Args:
        colour: (1, 3, S, S) logs of photo over model, of mean 0.
        known: of `seen_of_person`.
    """
    skin = skin * (1 - face_paint(surface))
    seen = surface.albedo.clamp_min(BLACK).log() + colour
    ratios = seen - seen[:, 1:2]
    skin = skin * ~_broadly_painted(surface, ratios, skin)
    return skin * (1 - _broad_part(own_redness(surface, ratios, skin * known)))


def _broadly_painted(surface: Surface, ratios: torch.Tensor, skin: torch.Tensor) -> torch.Tensor:
    """(1, 1, S, S) bool, where the photo shows paint on skin, or a mask over it, broader than rims and ears' hollows.

    Whatever the albedo has of it. A narrow line may be a light's from behind, and red in an ear comes of light there.

    Args:
        ratios: (1, 3, S, S) log ratios to green of what the photo shows, in a light as white as is known.
        skin: (1, 1, S, S) probability of what parsing takes for bare skin.
    """
    sure = (skin > SURELY)[0, 0]
    if int(sure.sum()) < FEWEST_PIXELS:
        return torch.zeros_like(skin, dtype=torch.bool)
    paint = painted(ratios - middle_values(ratios, sure), surface.photo, skin).to(skin)
    return _broad_part(paint) > 0


def _broad_part(share: torch.Tensor) -> torch.Tensor:
    """A share (1, 1, S, S) where it hangs together with what is broad, and no more than that there."""
    return torch.minimum(share, local_range(local_range(share, _BROAD)[0], 2 * _BROAD)[1])


def _missed_light(
    mean: torch.Tensor, skin: torch.Tensor, seen_skin: torch.Tensor, glare: torch.Tensor
) -> tuple[torch.Tensor, torch.Tensor, float]:
    """`broad` and, but for colours, `missed` of a residual, and how surely that is much of the skin's light, [0, 1].

    Args:
        mean: (1, 1, S, S) of the log ratio over its channels.
        skin, seen_skin: (1, 1, S, S) all of it and as much as the photo shows.
        glare: (1, 1, S, S) how much of the log ratio fades as such.
    """
    broad = skin * _shared_by_more_than_a_mole(mean, skin)
    sure = (seen_skin > SURELY)[0, 0]
    known = int(sure.sum()) >= FEWEST_PIXELS
    middle = middle_values(broad, sure) if known else 0.0
    missed = (1 - glare) * (broad - skin * middle)
    spread = float(missed[0][:, sure].std()) if known else 0.0
    if elsewhere := ramp(spread, *_MISSED_ELSEWHERE):
        rest = elsewhere * (1 - skin) * _shared_by_more_than_a_mole(mean, 1 - skin)
        broad, missed = broad + rest, missed + (1 - glare) * rest
    return broad, missed, ramp(spread, *_MUCH_MISSED)


def _shared_by_more_than_a_mole(mean: torch.Tensor, part: torch.Tensor) -> torch.Tensor:
    """(1, 1, S, S) what of a log ratio (1, 1, S, S) a mole's surroundings have too; all of it at a shadow's edge.

    What lies between both sides of a step belongs to it, and no median follows its bends.
    """
    middle = local_medians(mean, part, MOLE)
    least, most = local_range(middle, MOLE)
    at_step = ramp(most - least, *_STEP)
    return mean.clamp(middle + at_step * (least - middle), middle + at_step * (most - middle))


def _glare_share(mean: torch.Tensor, skin: torch.Tensor, hair: torch.Tensor) -> torch.Tensor:
    """(1, 1, S, S) how surely a light from behind has caused a log ratio, of that mean (1, 1, S, S), [0, 1]."""
    share = torch.zeros_like(skin)
    for kind, (start, full) in ((skin, _GLARE_OF_SKIN), (hair, _GLARE_OF_HAIR)):
        share = share + likely(kind) * ramp(mean, start, full)
    return share.clamp_max(1)


def _by_camera(log_ratio: torch.Tensor, albedo: torch.Tensor, skin: torch.Tensor) -> torch.Tensor:
    """(1, 3, 1, 1) log colour that the camera adds to all skin: what the model does not make of it."""
    own, off = (middle_colour(image, skin) for image in (albedo, log_ratio.exp()))
    if own is None:
        return torch.zeros_like(log_ratio[..., :1, :1])
    return of_camera(off, own, saturation(off, own).clamp(0, _MOST_SATURATED))[None, :, None, None]


def _was_clipped(recorded: torch.Tensor) -> float:
    """How surely a photo was clipped at 1, [0, 1]: less so the more of it is beyond, beside what has piled up there.

    A few pixels beyond may be the overshoot of a resampling, or a glint that was put in.
    """
    brightest = recorded.amax(1)
    beyond = ((brightest - 1) / _BEYOND).clamp(0, 1).sum()
    piled_up = (1 - (brightest - 1).abs() / _PILED_UP).clamp(0, 1).sum()
    return float(1 - (2 * beyond / (beyond + piled_up + _FEW * brightest.numel())).clamp_max(1))


@torch.inference_mode()
def add_residual(
    residual: Residual, composed: Composed, effects: Effects, light: torch.Tensor
) -> tuple[torch.Tensor, Effects]:
    """Another light's image (1, 3, S, S), linear >= 0, times what stays of the residual; its effects likewise.

    Args:
        composed, effects: the model's, under that other light.
        light: (1, 16, 32, 3) that other light.
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
