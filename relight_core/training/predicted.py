"""What the relighting networks are really given: normals and relief as de-lighting finds them in photos."""

from __future__ import annotations

import torch

from relight_core.dataset.samples import RELIEF_SIZE
from relight_core.face.parsing import INDEX
from relight_core.imaging.tensor_colour import srgb_decode
from relight_core.imaging.tensor_images import enlarge
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import NetworkBundle
from relight_core.networks.delight import Delit
from relight_core.pipeline import stages
from relight_core.training.coarser import shrunk, shrunk_heads


def surface_size(bundle: NetworkBundle, photo: torch.Tensor) -> int:
    """Side of the surfaces that are found in photos (..., S, S): S, or half of it where de-lighting sharpens.

    The relighting networks work at the size of de-lighting's encoder-decoder.
    """
    return photo.shape[-1] // (1 if bundle.delight.detail is None else 2)


def on_predicted_surface(
    bundle: NetworkBundle, table: ReflectionTable, batch: dict[str, torch.Tensor]
) -> dict[str, torch.Tensor]:
    """Every photo of a batch of pairs with the surface found in it, and the truth under both lights of its pair.

    The albedo stays the true one. These networks cannot see how far off a found albedo is; learning on it
    would teach them to hedge toward a mean portrait.

    Args:
        bundle: its de-lighting network in evaluation mode.
        batch: pairs as `dataset.stream` gives them, of S x S pixels.

    Returns:
        (4 * pairs, C, T, T): by pair, photo and light; T as `surface_size` has it. "reflected" is what the editor
        makes of the surface and the light, but for the gloss of black hair, which the truth has: networks that miss
        it there would learn to put it back.
    """
    photo = srgb_decode(batch["photo_srgb"].flatten(0, 1).float())
    size, both_lights = surface_size(bundle, photo), batch["light"].repeat_interleave(2, 0)
    surfaces = stages.delight_views(bundle, photo, shrunk(photo, size))
    parts = {n: torch.cat([getattr(s, n) for s in surfaces]) for n in ("normal", "relief", "parsing", "person")}
    shadow = relief_shadows(parts["relief"], parts["normal"], parts.pop("person"), both_lights, size)
    reflected = []
    for surface, lights in zip(surfaces, both_lights, strict=True):
        reflector = stages.reflector(table, surface, black_is_dull=False)
        reflected += [stages.reflect(reflector, light[None]) for light in lights]
    truth = {name: _for_both_photos(batch[name]) for name in batch.keys() - {"photo_srgb", "label"}}
    seen = {name: value.repeat_interleave(2, 0) for name, value in parts.items()}
    lit = {"relief_shadow": shadow, "reflected": torch.cat(reflected)}
    return shrunk_heads(truth, size) | seen | lit


@torch.no_grad()
def found_hints(bundle: NetworkBundle, found: Delit, light: torch.Tensor, size: int) -> dict[str, torch.Tensor]:
    """What SS is told of a surface beside its normals, of what de-lighting is there to find.

    Args:
        found: of B photos of one size.
        light: (B, 16, 32, 3), which each of them is to be relit with.
        size: T of the hints.

    Returns:
        "parsing" (B, classes, T, T), "relief" and the "relief_shadow" that it casts, (B, 1, T, T).
    """
    hints, config = {}, bundle.config.delight
    if config.classes:
        parsing = torch.softmax(found.parsing_logits.float(), 1)
        hints["parsing"] = shrunk(parsing, size)
    if config.relief:
        relief = stages.height_of(found.relief.float(), found.albedo_srgb.shape[-1])
        hints["relief"] = shrunk(relief, size)
    if config.relief and config.classes:
        person = 1 - parsing[:, INDEX["background"], None]
        hints["relief_shadow"] = relief_shadows(relief, found.normal.float(), person, light[:, None], size)
    return hints


def relief_shadows(
    relief: torch.Tensor, normal: torch.Tensor, person: torch.Tensor, lights: torch.Tensor, size: int
) -> torch.Tensor:
    """Shadow fractions (B * L, 1, size, size) of B surfaces, each under its own lights (B, L, 16, 32, 3).

    Args:
        relief, normal, person: (B, C, S, S) as `stages.Surface` has them.
    """
    transports = stages.march_views(normal, relief, person, RELIEF_SIZE)
    shadow = torch.cat([part.shadow_fraction(own) for part, own in zip(transports, lights, strict=True)])
    return enlarge(shadow, size)


def _for_both_photos(value: torch.Tensor) -> torch.Tensor:
    """(pairs, 2, ...) of both lights, or (pairs, ...) of all, as one batch by pair, photo and light."""
    return value.repeat_interleave(2, 0).flatten(0, 1) if value.ndim == 5 else value.repeat_interleave(4, 0)
