"""The picture under a light that turns once around it, as a film or as numbered pictures."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from app.engine.jobs import JobControl
from app.engine.sources import RelighterLike
from relight_core.errors import InputError
from relight_core.imaging.files import whole_file
from relight_core.imaging.view_transform import apply_view
from relight_core.lighting.environment import Environment
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.layers import shrunk_picture

FRAMES, FRAMES_PER_SECOND = 120, 24
_CODECS = ("avc1", "mp4v")


def turning(
    relighter: RelighterLike, light: Environment, edit: Edit, longest_side: int | None, frames: int = FRAMES
) -> Iterator[np.ndarray]:
    """The frames of one turn, the first at the edit's own yaw.

    Returns:
        (H, W, 3) uint8 sRGB each; height and width even, as films need them. Transparency becomes black.
    """
    for index in range(frames):
        turned = replace(edit, yaw_deg=edit.yaw_deg + 360.0 * index / frames, channels=())
        image, alpha = shrunk_picture(relighter.relight(light, turned), longest_side)
        if alpha is not None:
            image = image * alpha[..., None]
        codes = np.rint(apply_view(image, edit.exposure_ev) * 255).astype(np.uint8)
        height, width = (side - side % 2 for side in codes.shape[:2])
        yield np.ascontiguousarray(codes[:height, :width])


def write_film(path: Path, frames: Iterator[np.ndarray], count: int, control: JobControl) -> None:
    """Write an MP4, whole or not at all; replaces what is there.

    Raises:
        InputError: this system has no codec for it, or the place can't be written.
    """
    writer = None
    with whole_file(path, ".mp4") as beside:
        try:
            for index, frame in enumerate(frames):
                if writer is None:
                    writer = _film_writer(beside, (frame.shape[1], frame.shape[0]))
                writer.write(frame[..., ::-1])
                control.step(index + 1, count)
        finally:
            if writer is not None:
                writer.release()
        _check_film(beside, path, index + 1)


def write_pictures(
    folder: Path,
    frames: Iterator[np.ndarray],
    count: int,
    control: JobControl,
    write: Callable[[Path, np.ndarray], None],
) -> None:
    """Write numbered PNG files into a new folder, which takes its name once all of them are in it.

    Args:
        write: writes one frame.

    Raises:
        InputError: the folder is there already or can't be made.
    """
    if os.path.lexists(folder):
        raise InputError(f"{folder}: is there already; choose another name")
    beside = folder.with_name(f".{folder.name[:100]}-{secrets.token_hex(6)}.part")
    try:
        beside.mkdir()
        for index, frame in enumerate(frames):
            write(beside / f"{index + 1:04d}.png", frame)
            control.step(index + 1, count)
        os.rename(beside, folder)
    except InterruptedError:  # Cancel, which happens to be an OSError
        raise
    except OSError as error:
        raise InputError(f"{folder}: can't be made ({error.strerror}); choose another place") from error
    finally:
        shutil.rmtree(beside, ignore_errors=True)


def _check_film(film: Path, path: Path, count: int) -> None:
    """The codec says nothing when the disk is full; a film that is short of frames does."""
    reader = cv2.VideoCapture(str(film))
    found = round(reader.get(cv2.CAP_PROP_FRAME_COUNT))
    reader.release()
    if found != count:
        raise InputError(f"{path}: only {max(found, 0)} of {count} frames could be written; make room on the disk")


def _film_writer(path: Path, size: tuple[int, int]) -> cv2.VideoWriter:
    before = cv2.utils.logging.getLogLevel() if hasattr(cv2.utils, "logging") else None
    if before is not None:
        cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        for codec in _CODECS:
            writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*codec), FRAMES_PER_SECOND, size)
            if writer.isOpened():
                return writer
    finally:
        if before is not None:
            cv2.utils.logging.setLogLevel(before)
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise InputError(f"{path.parent}: can't be written to; choose another folder")
    raise InputError("this system has no codec for MP4; export the turntable as pictures instead")
