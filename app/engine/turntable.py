"""The picture under a light that turns once around it, as a film or as numbered pictures."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from app.engine.sources import RelighterLike
from relight_core.errors import InputError
from relight_core.imaging.view_transform import apply_view
from relight_core.lighting.environment import Environment
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.results.layers import shrunk_picture

FRAMES = 120
FILM_PX = 1080
"""The longer side of the pictures where no other was chosen: those of a camera are too large for a film."""


def turning(
    relighter: RelighterLike,
    light: Environment,
    edit: Edit,
    longest_side: int | None,
    frames: int = FRAMES,
    *,
    for_film: bool = True,
) -> Iterator[np.ndarray]:
    """The frames of one turn, the first at the edit's own yaw.

    Args:
        for_film: height and width are even, and transparency becomes black; films hold nothing else.

    Returns:
        (H, W, 3) uint8 sRGB each, or (H, W, 4) with straight alpha where the picture has one and it is for no film.
    """
    for index in range(frames):
        turned = replace(edit, yaw_deg=edit.yaw_deg + 360.0 * index / frames, channels=())
        image, alpha = shrunk_picture(relighter.relight(light, turned), longest_side)
        if alpha is not None and for_film:
            image, alpha = image * alpha[..., None], None
        shown = apply_view(image, edit.exposure_ev)
        codes = np.rint((shown if alpha is None else np.dstack([shown, alpha])) * 255).astype(np.uint8)
        height, width = (side - side % 2 if for_film else side for side in codes.shape[:2])
        yield np.ascontiguousarray(codes[:height, :width])


def write_pictures(
    folder: Path,
    frames: Iterator[np.ndarray],
    count: int,
    step: Callable[[int, int], None],
    write: Callable[[Path, np.ndarray], None],
) -> None:
    """Write numbered PNG files into a new folder, which takes its name once all of them are in it.

    Args:
        step: told after each how many are done, and `count`; what it raises ends the work.
        write: writes one frame.

    Raises:
        InputError: the folder is there already or can't be made.
    """
    if os.path.lexists(folder):
        raise InputError(f"{folder}: is there already; choose another name")
    beside = folder.with_name(f".{secrets.token_hex(8)}.part")
    try:
        beside.mkdir()
        for index, frame in enumerate(frames):
            write(beside / f"{index + 1:04d}.png", frame)
            step(index + 1, count)
        os.rename(beside, folder)
    except OSError as error:
        raise InputError(f"{folder}: can't be made ({error.strerror}); choose another place") from error
    finally:
        shutil.rmtree(beside, ignore_errors=True)
