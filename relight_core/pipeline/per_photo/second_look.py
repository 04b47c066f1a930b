"""De-lighting of a view, with a second look at skin after most of the shading has been removed from the photo.

De-lighting leaves a fraction of a photo's shading in the albedo. So the first look's result is used to bring the photo
most of the way to how it would look in an even light, and this is de-lit again: the same fraction of much less shading
is left. On held-out heads this removes a twelfth of the error of a face's albedo, apart from its level. Hair and cloth,
which may have any colour, gain nothing and keep the first look's albedo.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch

from relight_core.face.parsing import skin_share
from relight_core.imaging.resampling import resize_area
from relight_core.imaging.tensor_constants import constant
from relight_core.imaging.tensor_images import as_image, as_tensor, enlarge
from relight_core.imaging.tensor_logs import exact_logs
from relight_core.imaging.tensor_means import local_means
from relight_core.networks.bundle import NetworkBundle
from relight_core.pipeline import stages
from relight_core.pipeline.per_photo.cropped_hair import with_cropped_hair
from relight_core.pipeline.per_photo.face_covering import find_face_covering
from relight_core.pipeline.per_photo.foreign_shadow import find_foreign_shadow, without_shadow
from relight_core.pipeline.per_photo.hair_on_scalp import with_hair_on_scalp
from relight_core.pipeline.per_photo.held_before_face import find_held_before_face
from relight_core.pipeline.per_photo.white_hair import with_white_hair
from relight_core.pipeline.quality import Tier

_AHEAD = (0.0, 0.2, 0.65)
"""The almost even light gives a normal n an irradiance of 1 + n . a: most from the front and above, least from
behind."""
_MOST_OF_THE_WAY = 0.7
"""Share of the way to that light, in logs."""
_STRONGEST_GAIN = 10.0
"""Limit of the gain to that light, and of its inverse."""
_DARKEST_PHOTO = 4e-3
"""Smallest divisor."""


@torch.inference_mode()
def take_apart(bundle: NetworkBundle, photo_view: np.ndarray, tier: Tier, device: str) -> stages.Surface:
    """De-light a view (S, S, 3), linear, at a tier of quality.

    As the tier says, shadows from outside are removed first, and skin gets a second look. Hair that the parsing takes
    for scalp is corrected before that. A mask, or what is held before the face, has the colour of skin in the meantime.
    """
    whole = resize_area(photo_view, (tier.delight_size, tier.delight_size))
    how = {"mirrored": tier.mirrored, "precision": tier.precision}
    found = stages.delight(bundle, whole, tier.network_size, device, **how)
    covering, shadow, seen = find_face_covering(found) or find_held_before_face(found), None, whole
    if covering is not None:
        seen = covering.taken_off(whole)
        found = stages.delight(bundle, seen, tier.network_size, device, **how)
    if tier.takes_foreign_shadow_off:
        shadow = find_foreign_shadow(bundle, as_tensor(seen, device), found.parsing, tier.precision)
    if shadow is not None:
        seen = _without(shadow, seen)
        found = replace(stages.delight(bundle, seen, tier.network_size, device, **how), foreign_shadow=shadow)
    found = with_cropped_hair(with_hair_on_scalp(with_white_hair(found)))
    if tier.looks_twice:
        even = evenly_lit(seen, found)
        found = with_skin_of(found, stages.delight(bundle, even, tier.network_size, device, **how))
    if covering is None:
        return found
    return covering.put_on(found, whole if shadow is None else _without(shadow, whole))


def _without(shadow: torch.Tensor, view: np.ndarray) -> np.ndarray:
    """A view (D, D, 3), linear, with the shadows from outside removed."""
    return as_image(without_shadow(as_tensor(view, shadow.device), shadow))


def evenly_lit(photo: np.ndarray, found: stages.Surface) -> np.ndarray:
    """A photo (D, D, 3), linear in [0, 1], with the person's lighting most of the way to an even one."""
    parts = {"albedo": found.albedo, "normal": found.normal, "photo": found.photo, "person": found.person}
    return as_image(evened_out(as_tensor(photo, found.normal.device), **parts))


def evened_out(
    views: torch.Tensor, *, albedo: torch.Tensor, normal: torch.Tensor, photo: torch.Tensor, person: torch.Tensor
) -> torch.Tensor:
    """`evenly_lit` for a batch of views (B, 3, D, D), given these parts of their surfaces, (B, C, S, S) each.

    The gain's brightness is each pixel's own. Its colour is a mean over some hundredths of the view, since lights have
    one colour over a cheek. What de-lighting takes for coloured light on a smaller area is more often paint, make-up or
    a plaster, which would be gone before the second look.
    """
    ahead = constant(_AHEAD, normal.device, torch.float32)
    received = 1 + (normal * ahead[:, None, None]).sum(1, keepdim=True)
    wanted = albedo * received / (1 + ahead.norm())
    gain = (wanted / photo.clamp_min(_DARKEST_PHOTO)).clamp(1 / _STRONGEST_GAIN, _STRONGEST_GAIN).log()
    seen = person > 0.5
    gain = _MOST_OF_THE_WAY * torch.where(seen, gain, 0.0)
    brightness = gain.mean(1, keepdim=True)
    gain = brightness + seen * local_means(gain - brightness, seen.to(gain))
    return (views * enlarge(gain, views.shape[-2:]).exp()).clamp(0, 1)


def with_skin_of(found: stages.Surface, again: stages.Surface) -> stages.Surface:
    """A surface with its skin's albedo from a second look, at the mean level of the first, which knows that better."""
    skin = skin_share(found.parsing)
    first, second = (exact_logs(surface.albedo) for surface in (found, again))
    change = second - first
    level = (change * skin).sum() / (3 * skin.sum()).clamp_min(1)
    return replace(found, albedo=(found.albedo * torch.exp(skin * (change - level))).clamp(0, 1))
