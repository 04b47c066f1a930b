"""What the relighting networks are really given: normals and relief as de-lighting finds them in photos."""

from __future__ import annotations

import torch
import torch.nn.functional as F

from relight_core.imaging.tensor_colour import srgb_decode
from relight_core.networks.bundle import NetworkBundle
from relight_core.pipeline import stages

_RELIEF_SIZE = 64


def on_predicted_surface(bundle: NetworkBundle, batch: dict[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    """Every photo of a batch of pairs with the surface found in it, and the truth under its pair's other light.

    The albedo stays the true one. These networks cannot see how far off a found albedo is; learning on it
    would teach them to hedge toward a mean portrait.

    Args:
        bundle: its de-lighting network in evaluation mode.
        batch: pairs as `dataset.stream` gives them, of S x S pixels.

    Returns:
        (2 * pairs, C, T, T), T being S, or half of it where de-lighting has a sharpening pass, since the
        relighting networks work at the size of its encoder-decoder.
    """
    photo = batch["photo_srgb"].flatten(0, 1)
    flat = {name: _both_lights_swapped(value) for name, value in batch.items() if name != "photo_srgb"}
    size = photo.shape[-1] // (1 if bundle.delight.detail is None else 2)
    surfaces, shadows = [], []
    for linear, light in zip(srgb_decode(photo), flat["light"], strict=True):
        view = linear.permute(1, 2, 0).float().cpu().numpy()
        surface = stages.delight(bundle, view, size, photo.device.type)
        transport = stages.march(surface, _RELIEF_SIZE)
        surfaces.append(surface)
        shadows.append(transport.shadow_fraction(light[None].cpu()))
    shadow = torch.cat(shadows).to(photo.device)
    return {name: _shrunk(value, size) for name, value in flat.items() if name != "label"} | {
        **{name: torch.cat([getattr(s, name) for s in surfaces]) for name in ("normal", "relief", "parsing")},
        "relief_shadow": F.interpolate(shadow, size=size, mode="bilinear", align_corners=False),
    }


def _both_lights_swapped(value: torch.Tensor) -> torch.Tensor:
    """(pairs, 2, C, H, W) as one batch with each pair turned round; (pairs, ...) repeated."""
    return value.flip(1).flatten(0, 1) if value.ndim == 5 else value.repeat_interleave(2, 0)


def _shrunk(value: torch.Tensor, size: int) -> torch.Tensor:
    if value.shape[1:] == (16, 32, 3) or value.shape[-1] == size:
        return value
    return F.interpolate(value, size=size, mode="area")
