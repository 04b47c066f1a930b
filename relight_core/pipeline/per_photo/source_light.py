"""The light a photo was taken under: the network's guess, turned and coloured until it explains the photo."""

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
_DARKEST_ALBEDO = 0.03
_LEAST_MATTE = 0.4
"""Share of a pixel that is not gloss, at the least: where the model has more gloss than that, it is wrong."""
_BY_CAMERA, _MOST_BY_CAMERA = 0.9, 0.45
"""How much of skin that is too saturated is the camera's doing and not the light's. Held-out heads, whose lights are
of all colours, ask for none of it; photographs, which cameras balance and develop, would turn grey in a white light."""
_LEAST_BY_CAMERA, _SURELY_LIT = 0.2, 1.0
"""So much is the camera's in a light that makes skin twice as saturated: candles and sodium lamps, left unbalanced."""


@torch.inference_mode()
def explain_source_light(surface: Surface, reflector: Reflector, relief: ReliefTransport) -> torch.Tensor:
    """The light the photo was taken under, (1, 16, 32, 3), at the level that gives the photo its brightness.

    The network's estimate is the first guess; least squares over the face then turn and colour it until albedo,
    normals and relief look as they do in the photo (see `lighting.inverse`). What the guess mirrors is taken off the
    photo first: gloss has the light's colour, and skin below it would pass for skin in a bluer light.

    A cast over all of the skin that is more than a camera's doing is one of the whole guess: what little of the face
    sees or mirrors would else stay white in a tungsten lamp's light, and a nose be taken for yellower than its cheeks.

    A face that is painted all over (see `face_paint`) has its paint's colour, whatever its albedo is taken for.

    Args:
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
    """The photo (1, 3, S, S) without gloss that lies over it where the light, (1, 1, R, R), is not hidden."""
    hidden = enlarge(hidden, photo.shape[-2:]).to(photo.device)
    return torch.maximum(photo - gloss * (1 - hidden), _LEAST_MATTE * photo)


def _cast(surface: Surface, reflected: torch.Tensor) -> torch.Tensor:
    """The colour (3,), of luminance 1, that all of the skin has beside the guess, where it is more than a camera's.

    Args:
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
    """The explained light (T, 3), of a guess (T, 3), without the colours that are the camera's, or a share of them."""
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
    """(1, 1, S, S) bool, where the photo shows the person and isn't clipped."""
    return (surface.person > 0.5) & (surface.photo.amax(1, keepdim=True) < _NEARLY_CLIPPED)


def level_over_person(surface: Surface, model: torch.Tensor) -> float | None:
    """The level at which a model (1, 3, S, S) is as bright as the photo over all of the person.

    None where nothing can be said.
    """
    seen = seen_of_person(surface)
    lit = float(grey(model)[seen].sum())
    if int(seen.sum()) < FEWEST_PIXELS or lit <= 0:
        return None
    return float(grey(surface.photo)[seen].sum()) / lit


def exposure_of_photo(surface: Surface, reflected: torch.Tensor) -> float:
    """The level at which a light gives the photo its brightness.

    The median ratio over the person of the photo to what the surface reflects of the light, (1, 6, S, S), where the
    photo is neither black nor clipped; 1 where nothing can be said.
    """
    lit = grey(surface.albedo * reflected[:, :3] + reflected[:, 3:])
    seen = grey(surface.photo)
    known = seen_of_person(surface) & (seen > 0.02) & (lit > 1e-3)
    if int(known.sum()) < FEWEST_PIXELS:
        return 1.0
    return float((seen[known] / lit[known]).median())
