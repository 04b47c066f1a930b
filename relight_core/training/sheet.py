"""A sheet of samples: what the networks make of a batch, beside the truth."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch

from relight_core.imaging.colour import srgb_decode
from relight_core.imaging.tensor_colour import srgb_encode
from relight_core.imaging.write import write_image
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import NetworkBundle
from relight_core.networks.pair import BothNetworks
from relight_core.pipeline.results.channel_view import channel_to_srgb
from relight_core.training.distillation import under_some_lights
from relight_core.training.relight_steps import composition_losses, flatten_pairs, specular_shadow_losses

_ROWS = 6


@torch.no_grad()
def draw_samples(bundle: NetworkBundle, table: ReflectionTable, batch: dict[str, torch.Tensor], path: Path) -> None:
    """Write a picture with a row for each of the first samples, every channel followed by the true one.

    Of examples for a narrow pair (see `training.distillation`), it is that pair's answers beside the wide one's. Else
    de-lighting starts from the photo where the batch has photos; specular, shadow and the image start
    from the true surface, as in the warm-ups.

    Args:
        bundle: in evaluation mode, on the CPU.
        batch: pairs from `dataset.stream.SampleStream`.
        path: a .png, written whole or not at all.
    """
    if "person" in batch:
        return _draw_outlines(bundle, batch, path)
    taught = "reflected" in batch
    if not taught:
        batch = {name: value[:_ROWS] for name, value in batch.items()}
    flattened = (under_some_lights if taught else flatten_pairs)({name: value.cpu() for name, value in batch.items()})
    flat = {
        name: value[:_ROWS].float() if value.is_floating_point() else value[:_ROWS] for name, value in flattened.items()
    }
    pair = bundle.pair("narrow" if taught else "wide")
    columns = _taken_apart(bundle, flat) + _put_together(pair, table, flat)
    rows = [np.hstack([column[row] for column in columns]) for row in range(len(columns[0]))]
    write_image(path, srgb_decode(np.vstack(rows)))


def _draw_outlines(bundle: NetworkBundle, batch: dict[str, torch.Tensor], path: Path) -> None:
    few = {name: value[:_ROWS].cpu().float() for name, value in batch.items()}
    likely = torch.sigmoid(bundle.person(few["photo_srgb"], few["inside"], few["face"]))
    columns = [_images(values.expand(-1, 3, -1, -1)) for values in (few["photo_srgb"], likely, few["person"])]
    write_image(path, srgb_decode(np.vstack([np.hstack(row) for row in zip(*columns, strict=True)])))


def _taken_apart(bundle: NetworkBundle, flat: dict[str, torch.Tensor]) -> list[list[np.ndarray]]:
    if "photo_srgb" not in flat:
        return []
    found = bundle.delight(flat["photo_srgb"])
    columns = [
        list(_images(flat["photo_srgb"])),
        list(_images(found.albedo_srgb)),
        list(_images(srgb_encode(flat["albedo"]))),
        _shown("normal", _images(found.normal)),
        _shown("normal", _images(flat["normal"])),
    ]
    if bundle.config.delight.classes:
        labels = found.parsing_logits.argmax(1)
        columns += [_shown("parsing", labels.numpy()), _shown("parsing", flat["label"].numpy())]
    return columns


def _put_together(pair: BothNetworks, table: ReflectionTable, flat: dict[str, torch.Tensor]) -> list[list[np.ndarray]]:
    effects, _ = specular_shadow_losses(pair.specular_shadow, table, _with_hint(flat))
    image, _ = composition_losses(pair.composition, table, flat, effects)
    pairs = ((effects.specular, "specular"), (effects.shadow, "shadow"), (image, "image"))
    columns = []
    for estimate, name in pairs:
        for values in (estimate * flat["covered"], flat[name]):
            images = _images(values)
            columns.append(_shown("photo" if name == "image" else name, images if name == "image" else images[..., 0]))
    return columns


def _with_hint(flat: dict[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    """De-lighting's batches carry no shadow of the relief: the SS network is told of none."""
    return {"relief_shadow": torch.zeros_like(flat["covered"]), **flat}


def _images(values: torch.Tensor) -> np.ndarray:
    return values.float().permute(0, 2, 3, 1).numpy()


def _shown(channel: str, images: np.ndarray) -> list[np.ndarray]:
    return [channel_to_srgb(channel, image) for image in images]
