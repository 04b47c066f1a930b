"""Shadows on a person that come from outside: found by a network, and taken off before the person is taken apart.

De-lighting knows what a head does to light, and leaves half of the shadow of a hand or of leaves in the albedo.
"""

from __future__ import annotations

import torch
import torch.nn.functional as F

from relight_core.face.parsing import share_of
from relight_core.imaging.ramp import ramp
from relight_core.imaging.tensor_colour import srgb_encode
from relight_core.imaging.tensor_logs import BLACK
from relight_core.networks.bundle import NetworkBundle
from relight_core.networks.foreign_shadow import PARTS
from relight_core.pipeline.stages import in_precision

_SIZE = 256
"""Side of the view that the network sees."""

_DEEPEST = 3.0
_HARDLY, _SURELY = 0.06, 0.16
_LEAST_SHARE = 0.002


@torch.inference_mode()
def find_foreign_shadow(
    bundle: NetworkBundle, view: torch.Tensor, parsing: torch.Tensor, precision: str
) -> torch.Tensor | None:
    """What shadows from outside do to a view (1, 3, D, D), linear.

    Args:
        parsing: (1, classes, S, S) probabilities of the view.

    Returns:
        (1, 3, 256, 256) logs of light that arrives over light that would without them, [-3, 0]; None where there
        are none, or no network that knows.
    """
    if bundle.foreign_shadow is None:
        return None
    network = in_precision(bundle, view.device.type, precision).foreign_shadow
    photo = srgb_encode(at_size(view, _SIZE).clamp(0, 1))
    parts = at_size(torch.cat([share_of(parsing, names) for names in PARTS], 1), _SIZE)
    one, other = network(*(torch.cat([image, image.flip(-1)]) for image in (photo, parts))).split(1)
    logs = ((one + other.flip(-1)) / 2).clamp(-_DEEPEST, 0)
    depth = -logs.mean(1, keepdim=True)
    person = at_size(1 - parsing[:, :1], _SIZE)
    logs = logs * ramp(depth, _HARDLY, _SURELY)
    return logs if float(((depth > _SURELY) * person).mean()) > _LEAST_SHARE else None


def without_shadow(view: torch.Tensor, logs: torch.Tensor) -> torch.Tensor:
    """A view (1, 3, D, D), linear, as it would be without shadows of those logs, of any size."""
    return ((view + BLACK) * at_size(-logs, view.shape[-1]).exp() - BLACK).clamp_min(0)


def at_size(image: torch.Tensor, size: int) -> torch.Tensor:
    """(1, C, S, S) as (1, C, size, size)."""
    if image.shape[-1] == size:
        return image
    if image.shape[-1] > size:
        return F.interpolate(image, size=(size, size), mode="area")
    return F.interpolate(image, size=(size, size), mode="bilinear", align_corners=False)
