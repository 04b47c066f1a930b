"""The light a photo was taken under: the network's estimate, fitted until it explains the photo."""

from __future__ import annotations

import torch
import torch.nn.functional as F

from relight_core.face.parsing import FEWEST_PIXELS, SURELY, skin_share
from relight_core.imaging.ramp import ramp
from relight_core.imaging.tensor_colour import grey, luminance_weights
from relight_core.imaging.tensor_images import enlarge
from relight_core.lighting.inverse import explain_photo
from relight_core.lighting.relief import ReliefTransport
from relight_core.pipeline.per_light.hints import gloss_share
from relight_core.pipeline.per_photo.face_paint import with_paint
from relight_core.pipeline.per_photo.saturation import log_colour, middle_colour, of_camera, saturation
from relight_core.pipeline.stages import Reflector, Surface, reflect

_CLIPPED, _NEARLY_CLIPPED = 0.9, 0.97
"""Values of a channel from which on a pixel isn't used: in the fit, and otherwise."""
_DARKEST_ALBEDO = 0.03
"""Smallest divisor."""
_LEAST_MATTE = 0.4
"""At least this share of a pixel is diffuse: where the model has more gloss, it is wrong."""
_BY_CAMERA, _MOST_BY_CAMERA = 0.9, 0.45
"""Share of the camera's saturation that is kept out of the light, and the largest saturation that is attributed to a
camera. Held-out heads, whose lights have all colours, don't need this; but photographs, which cameras balance and
develop, would turn grey in a white light."""
_LEAST_BY_CAMERA, _SURELY_LIT = 0.2, 1.0
"""With a saturation of the second number, twice that of the skin, only the first is attributed to the camera: candles
and sodium lamps without white balance."""


@torch.inference_mode()
def explain_source_light(surface: Surface, reflector: Reflector, relief: ReliefTransport) -> torch.Tensor:
    """The light the photo was taken under, (1, 16, 32, 3), at the level that gives the photo its brightness.

    The network's estimate is the first guess, which is fitted until albedo, normals and relief look as in the photo
    (see `lighting.inverse`). Before the fit:

    - A face that is painted all over gets its paint as albedo (see `face_paint`).
    - The guess's gloss is subtracted from the photo. It has the light's colour, so skin below it would look as if it
      were in a bluer light.
    - If all of the skin has a colour cast that is more than a camera's, the whole guess gets it. Otherwise texels that
      little of the face sees would stay white in a tungsten lamp's light, and a nose would be taken to be yellower than
      the cheeks beside it.

    After it, saturation that is attributed to the camera is removed from the light.

    Args:
        surface: of the photo.
        reflector: of the same surface.
        relief: transport of its relief.
    """
    surface = with_paint(surface)
    reflected = reflect(reflector, surface.source_light)
    level = exposure_of_photo(surface, reflected)
    guess, cast = surface.source_light * level, _cast(surface, reflected)
    gloss = reflected[:, 3:] * level * cast[:, None, None]
    matte = _without_gloss(surface.photo, gloss, relief.shadow_fraction(guess.cpu()))
    small = [
        F.interpolate(image, size=relief.size, mode="area").cpu()
        for image in (surface.photo, matte, surface.albedo, surface.person * gloss_share(surface.parsing))
    ]
    photo, matte, albedo, person = (image[0].flatten(1).T for image in small)
    unclipped = (photo.amax(1) < _CLIPPED).float()
    weight = person[:, 0] * unclipped * albedo.mean(1)
    texels = guess[0].flatten(0, 1).cpu()
    shading = matte / albedo.clamp_min(_DARKEST_ALBEDO)
    light = explain_photo(texels * cast.cpu(), relief.shadowed, shading, weight)
    light = _left_to_light(surface, texels, light, by_camera=_BY_CAMERA)
    return light.reshape(guess.shape).to(guess.device)


def _without_gloss(photo: torch.Tensor, gloss: torch.Tensor, hidden: torch.Tensor) -> torch.Tensor:
    """The photo (1, 3, S, S) minus its gloss (1, 3, S, S), of which a share `hidden` (1, 1, R, R) is occluded."""
    hidden = enlarge(hidden, photo.shape[-2:]).to(photo.device)
    return torch.maximum(photo - gloss * (1 - hidden), _LEAST_MATTE * photo)


def _cast(surface: Surface, reflected: torch.Tensor) -> torch.Tensor:
    """The colour cast of all the skin relative to the guess, without the camera's part, (3,) of luminance 1.

    Args:
        surface: of the photo.
        reflected: (1, 6, S, S) irradiance over pi and gloss of the guess.
    """
    known = seen_of_person(surface) & (skin_share(surface.parsing) > SURELY)
    plain = surface.photo.new_ones(3)
    if int(known.sum()) < FEWEST_PIXELS:
        return plain
    lit = surface.albedo * reflected[:, :3] + reflected[:, 3:]
    seen, guessed = ((image * known).sum((0, 2, 3)) for image in (surface.photo, lit))
    if float(torch.minimum(seen, guessed).min()) <= 0:
        return plain
    cast = _left_to_light(surface, plain[None], (seen / guessed)[None], by_camera=1.0)[0]
    return cast / (cast @ luminance_weights(cast))


def _left_to_light(surface: Surface, guess: torch.Tensor, explained: torch.Tensor, by_camera: float) -> torch.Tensor:
    """A fitted light (T, 3) without a share, `by_camera`, of the change from the guess (T, 3) that is the camera's."""
    skin = middle_colour(surface.albedo, skin_share(surface.parsing))
    if skin is None:
        return explained
    skin = skin.to(explained.device)
    change = log_colour(explained) - log_colour(guess)
    more = saturation(change, skin)
    most = _MOST_BY_CAMERA + (_LEAST_BY_CAMERA - _MOST_BY_CAMERA) * ramp(more, _MOST_BY_CAMERA, _SURELY_LIT)
    cameras = of_camera(change, skin, torch.minimum(more.clamp_min(0), most))
    luminance = luminance_weights(explained)
    balanced = explained * torch.exp(-by_camera * cameras)
    return balanced * ((explained @ luminance) / (balanced @ luminance).clamp_min(1e-12))[:, None]


def seen_of_person(surface: Surface) -> torch.Tensor:
    """Where the photo shows the person unclipped, (1, 1, S, S) bool."""
    return (surface.person > 0.5) & (surface.photo.amax(1, keepdim=True) < _NEARLY_CLIPPED)


def level_over_person(surface: Surface, model: torch.Tensor) -> float | None:
    """The factor at which a model (1, 3, S, S) is on average as bright as the photo over the person.

    Returns:
        None if too little of the person can be compared.
    """
    seen = seen_of_person(surface)
    lit = float(grey(model)[seen].sum())
    if int(seen.sum()) < FEWEST_PIXELS or lit <= 0:
        return None
    return float(grey(surface.photo)[seen].sum()) / lit


def exposure_of_photo(surface: Surface, reflected: torch.Tensor) -> float:
    """The level at which a light gives the photo its brightness.

    It is the median ratio, over the person, of the photo to what the surface reflects of the light, where the photo is
    neither black nor clipped.

    Args:
        surface: of the photo.
        reflected: (1, 6, S, S) irradiance over pi and gloss.

    Returns:
        1 if too little of the person can be compared.
    """
    lit = grey(surface.albedo * reflected[:, :3] + reflected[:, 3:])
    seen = grey(surface.photo)
    known = seen_of_person(surface) & (seen > 0.02) & (lit > 1e-3)
    if int(known.sum()) < FEWEST_PIXELS:
        return 1.0
    return float((seen[known] / lit[known]).median())
