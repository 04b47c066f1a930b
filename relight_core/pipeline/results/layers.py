"""A relit portrait as layers of one size: the picture and its channels, each at its place in the photo."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

import cv2
import numpy as np

from relight_core.face.crop import Crop
from relight_core.face.paste import all_of, bands, update_nearest
from relight_core.imaging.in_order import in_order
from relight_core.imaging.masks import bounds
from relight_core.imaging.resampling import at_size, resize_area, resize_cut_out, shrunk_size
from relight_core.pipeline.per_photo.person import whole_person
from relight_core.pipeline.results.channels import unrolled
from relight_core.pipeline.results.relit import Relit

CHANNEL_LAYERS = ("albedo", "normal", "specular", "shadow", "parsing", "composition", "foreign_shadow")
LAYERS = (*CHANNEL_LAYERS, "matte", "background")
"""What can be had beside the picture itself. Channels are those of all faces that are relit: 0 where no view of the
networks reaches, and all but the composition where it shows no person."""


def photo_layers(
    relit: Relit, names: Iterable[str], longest_side: int | None = None, made: Callable[[], None] = lambda: None
) -> dict[str, np.ndarray]:
    """The picture as "RGB" or, with its alpha multiplied in, "RGBA", and the named layers.

    Args:
        relit: what to take apart.
        names: of LAYERS; those the Relit does not have are left out.
        longest_side: pixels; smaller pictures stay as they are, None keeps the photo's size.
        made: called after the picture and after each name; what it raises ends the work.

    Returns:
        arrays (H, W), (H, W, 3) or (H, W, 4), float32 linear; "normal" in camera space, unit length on the
        person; "parsing" labels; "background" what is seen beside the person, 0 where that was taken away: the picture
        less it is the person times the matte.

    Raises:
        ValueError: a name that is none.
    """
    wanted = list(names)
    unknown = [name for name in wanted if name not in LAYERS]
    if unknown:
        raise ValueError(f"no layer {unknown[0]!r}; there are {', '.join(LAYERS)}")
    image, alpha = _whole(relit, wide=True)
    size = shrunk_size(image.shape[:2], longest_side)
    layers = {"RGB": at_size(image, size)}
    if alpha is not None:
        layers = {"RGBA": at_size(np.dstack([image * alpha[..., None], alpha]), size)}
    faces = _faces(relit) if set(wanted) & set(CHANNEL_LAYERS) else []
    made()
    for name in wanted:
        layer = _beside(relit, name, size) if name in ("matte", "background") else _channel(relit, faces, name, size)
        if layer is not None:
            layers[name] = layer
        made()
    return layers


def channel_at(relit: Relit, name: str, column: int, row: int) -> tuple[np.ndarray, np.ndarray] | None:
    """One of CHANNEL_LAYERS of the first face at a pixel of the photo, () or (3,) float32.

    Returns:
        What the channel holds there, normals in the frame of the view, and the same with normals in camera space; None
        outside the view and where there is no such channel.
    """
    view, channel = channel_view_of(relit), relit.channels.get(name)
    if view is None or channel is None:
        return None
    x, y = view.from_photo(np.array([column + 0.5, row + 0.5]), channel.shape[0])
    if not (0 <= x < channel.shape[1] and 0 <= y < channel.shape[0]):
        return None
    size = _photo_size(relit)
    held = _placed(name, channel, view, size, size, (slice(row, row + 1), slice(column, column + 1)))
    turned = unrolled(held, view.roll_deg) if name == "normal" else held
    return held[0, 0], _of_unit_length(name, turned)[0, 0]


def shrunk_picture(
    relit: Relit, longest_side: int | None, *, wide: bool = False
) -> tuple[np.ndarray, np.ndarray | None]:
    """Image (H, W, 3) linear, not premultiplied, and alpha (H, W) or None, no side longer than asked.

    Args:
        wide: colours outside Rec.709 stay.
    """
    image, alpha = _whole(relit, wide)
    size = shrunk_size(image.shape[:2], longest_side)
    if alpha is None:
        return at_size(image, size), None
    colour, small = resize_cut_out(image, alpha, size)
    return np.ascontiguousarray(colour), small


def channel_view_of(relit: Relit) -> Crop | None:
    """Where the channels lie in the photo."""
    if relit.full is not None and relit.full.changes:
        return relit.full.changes[0].view
    if relit.window is None:
        return None
    x0, y0, x1, y1 = relit.window
    return Crop((x0 + x1) / 2, (y0 + y1) / 2, x1 - x0, relit.roll_deg)


def _whole(relit: Relit, wide: bool = False) -> tuple[np.ndarray, np.ndarray | None]:
    """Image and alpha at the photo's size, whatever size they were made for the screen.

    Args:
        wide: colours outside Rec.709 stay.
    """
    if wide and relit.full is not None and relit.full.canvas.beyond is not None:
        return replace(relit.full, wide=True).render()
    if relit.full is None or (relit.image is not None and relit.full.size == relit.image.shape[:2]):
        return relit.image, relit.alpha
    return relit.full.render()


def _beside(relit: Relit, name: str, size: tuple[int, int]) -> np.ndarray | None:
    """The matte, or what is seen beside the person."""
    if relit.full is None:
        return None
    if name == "matte":
        return at_size(whole_person(relit.full.canvas, relit.full.matte).share, size)
    picture = relit.full if relit.full.canvas.beyond is None else replace(relit.full, wide=True)
    rows = in_order(picture.behind, bands(picture.size, picture.canvas.photo_size))
    return at_size(np.concatenate(list(rows)), size)


def _faces(relit: Relit) -> list[tuple[Mapping[str, np.ndarray], Crop]]:
    """The channels of every face, normals in camera space, and where they lie."""
    together = relit.channels_together()
    if together:
        return list(zip(together, (change.view for change in relit.full.changes), strict=True))
    view = channel_view_of(relit)
    if view is None:
        return []
    channels = dict(relit.channels)
    if "normal" in channels:
        channels["normal"] = unrolled(channels["normal"], view.roll_deg)
    return [(channels, view)]


def _channel(
    relit: Relit, faces: Sequence[tuple[Mapping[str, np.ndarray], Crop]], name: str, size: tuple[int, int]
) -> np.ndarray | None:
    """A channel in a picture of `size`; a place in several views takes the one whose middle is nearest."""
    if not faces or name not in faces[0][0]:
        return None
    photo_size, everywhere = _photo_size(relit), (slice(0, size[0]), slice(0, size[1]))
    if len(faces) == 1:
        placed = _placed(name, faces[0][0][name], faces[0][1], photo_size, size, everywhere)
        return _of_unit_length(name, placed)
    band, nearest = all_of(size, photo_size), np.full(size, 0.5, np.float32)
    inside = [update_nearest(view, band, nearest) for _, view in faces]
    layer = np.zeros((*size, *faces[0][0][name].shape[2:]), np.float32)
    for (channels, view), chosen in zip(faces, inside, strict=True):
        part = bounds(chosen)
        if part[0].stop:
            placed = _placed(name, channels[name], view, photo_size, size, part)
            where = chosen[part].reshape(*placed.shape[:2], *[1] * (placed.ndim - 2))
            np.copyto(layer[part], _of_unit_length(name, placed), where=where)
    return layer


def _placed(
    name: str,
    channel: np.ndarray,
    view: Crop,
    photo_size: tuple[int, int],
    size: tuple[int, int],
    part: tuple[slice, slice],
) -> np.ndarray:
    """A channel where it lies in a picture of `size`, as it holds it, in some rows and columns of that.

    Where it becomes smaller, it is averaged; labels aren't, which have no mean.
    """
    steps = np.array([photo_size[1] / size[1], photo_size[0] / size[0]])
    side = math.ceil(view.side / steps.max())
    if name != "parsing" and side < channel.shape[0]:
        channel = resize_area(channel, (side, side))
    matrix = view.from_photo_matrix(channel.shape[0])
    linear = matrix[:, :2] * steps
    # From pixel centres to pixel centres: half a pixel in on the one side, half a pixel out on the other.
    rows, columns = part
    offset = linear @ np.array([columns.start + 0.5, rows.start + 0.5]) + matrix[:, 2] - 0.5
    sampling = cv2.INTER_NEAREST if name == "parsing" else cv2.INTER_LINEAR
    return cv2.warpAffine(
        np.ascontiguousarray(channel, np.float32),
        np.column_stack([linear, offset]),
        (columns.stop - columns.start, rows.stop - rows.start),
        flags=sampling | cv2.WARP_INVERSE_MAP,
    )


def _of_unit_length(name: str, placed: np.ndarray) -> np.ndarray:
    """Normals of unit length, and none where there is no person; other channels as they are."""
    if name != "normal":
        return placed
    length = np.linalg.norm(placed, axis=2, keepdims=True)
    return placed / np.maximum(length, 1e-6) * (length > 0.25)


def _photo_size(relit: Relit) -> tuple[int, int]:
    return relit.full.canvas.photo_size if relit.full is not None else relit.image.shape[:2]
