"""A sheet of samples: what the networks make of a batch, beside the truth."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch

from relight_core.imaging.contact_sheet import contact_sheet
from relight_core.imaging.photo import Photo
from relight_core.imaging.tensor_colour import srgb_encode
from relight_core.imaging.write import write_image
from relight_core.lighting.reflection import ReflectionTable
from relight_core.networks.bundle import NetworkBundle
from relight_core.networks.pair import BothNetworks
from relight_core.pipeline.results.channel_view import channel_to_srgb
from relight_core.training.distillation import under_some_lights
from relight_core.training.relight_steps import composition_losses, flatten_pairs, specular_shadow_losses

Column = tuple[str, list[np.ndarray]]
"""What it shows, and an image (S, S, 3), sRGB, for each row."""

_ROWS = 6
_LEAST_CELL_PX = 112
"""For the longest name."""


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
    columns = _columns_of_photos(bundle, batch) if "person" in batch else _columns(bundle, table, batch)
    rows = zip(*(images for _, images in columns), strict=True)
    pictures = [(name, image) for row in rows for (name, _), image in zip(columns, row, strict=True)]
    cell_px = max(pictures[0][1].shape[0], _LEAST_CELL_PX)
    write_image(path, Photo.from_srgb(contact_sheet(pictures, len(columns), cell_px)).linear)


def _columns_of_photos(bundle: NetworkBundle, batch: dict[str, torch.Tensor]) -> list[Column]:
    few = {name: value[:_ROWS].cpu().float() for name, value in batch.items()}
    if "foreign_shadow" in few:
        found, true = bundle.foreign_shadow(few["photo_srgb"], few["kinds"]) * few["person"], few["foreign_shadow"]
        shown = ("photo", few["photo_srgb"]), ("light that arrives", found.exp()), ("truth", true.exp())
        return [(name, list(_images(values.clamp(0, 1)))) for name, values in shown]
    likely = torch.sigmoid(bundle.person(few["photo_srgb"], few["inside"], few["face"]))
    columns = ("photo", few["photo_srgb"]), ("person", likely), ("true person", few["person"])
    return [(name, list(_images(values.expand(-1, 3, -1, -1)))) for name, values in columns]


def _columns(bundle: NetworkBundle, table: ReflectionTable, batch: dict[str, torch.Tensor]) -> list[Column]:
    taught = "reflected" in batch
    if not taught:
        batch = {name: value[:_ROWS] for name, value in batch.items()}
    flattened = (under_some_lights if taught else flatten_pairs)({name: value.cpu() for name, value in batch.items()})
    flat = {
        name: value[:_ROWS].float() if value.is_floating_point() else value[:_ROWS] for name, value in flattened.items()
    }
    pair = bundle.pair("narrow" if taught else "wide")
    return _taken_apart(bundle, flat) + _put_together(pair, table, flat, "wide" if taught else "true")


def _taken_apart(bundle: NetworkBundle, flat: dict[str, torch.Tensor]) -> list[Column]:
    if "photo_srgb" not in flat:
        return []
    found = bundle.delight(flat["photo_srgb"])
    columns = [
        ("photo", list(_images(flat["photo_srgb"]))),
        ("albedo", list(_images(found.albedo_srgb))),
        ("true albedo", list(_images(srgb_encode(flat["albedo"])))),
        ("normals", _shown("normal", _images(found.normal))),
        ("true normals", _shown("normal", _images(flat["normal"]))),
    ]
    if bundle.config.delight.classes:
        labels = found.parsing_logits.argmax(1)
        columns += [
            ("parsing", _shown("parsing", labels.numpy())),
            ("true parsing", _shown("parsing", flat["label"].numpy())),
        ]
    return columns


def _put_together(
    pair: BothNetworks, table: ReflectionTable, flat: dict[str, torch.Tensor], reference: str
) -> list[Column]:
    effects, _ = specular_shadow_losses(pair.specular_shadow, table, _with_hint(flat))
    image, _ = composition_losses(pair.composition, table, flat, effects)
    pairs = ((effects.specular, "specular"), (effects.shadow, "shadow"), (image, "image"))
    columns = []
    for estimate, name in pairs:
        for label, values in ((name, estimate * flat["covered"]), (f"{reference} {name}", flat[name])):
            images = _images(values)
            shown = _shown("photo", images) if name == "image" else _shown(name, images[..., 0])
            columns.append((label, shown))
    return columns


def _with_hint(flat: dict[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    """De-lighting's batches carry no shadow of the relief: the SS network is told of none."""
    return {"relief_shadow": torch.zeros_like(flat["covered"]), **flat}


def _images(values: torch.Tensor) -> np.ndarray:
    return values.float().permute(0, 2, 3, 1).numpy()


def _shown(channel: str, images: np.ndarray) -> list[np.ndarray]:
    return [channel_to_srgb(channel, image) for image in images]
