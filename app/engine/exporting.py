"""Saving what is shown: file names that overwrite nothing, and the writing itself on its own thread."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.engine.desk import error_line
from app.engine.snapshot import Picture
from relight_core import __version__
from relight_core.errors import InputError
from relight_core.imaging.write import write_exr_layers, write_image

_CHANNELS = "-channels"
_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class ExportJob:
    """One file to write.

    Attributes:
        picture: what to save.
        exposure_ev: stops, baked into 8-bit files and noted in EXR ones.
        path: the wished name; a number is added rather than anything overwritten.
    """

    picture: Picture
    exposure_ev: float
    path: Path


class Exporter:
    """Writes files one after the other, off the window's thread.

    Args:
        say: told what became of each job: a line, and whether it is an error.
    """

    def __init__(self, say: Callable[[str, bool], None]) -> None:
        self._say = say
        self._pool = ThreadPoolExecutor(max_workers=1, thread_name_prefix="relight-export")

    def submit(self, job: ExportJob) -> None:
        """Queue a job."""
        self._pool.submit(self._run, job)

    def close(self) -> None:
        """Finish what was queued."""
        self._pool.shutdown(wait=True)

    def _run(self, job: ExportJob) -> None:
        try:
            written = export(job)
        except InputError as error:
            self._say(error_line(error), True)
        except Exception as error:
            _log.error("export failed", exc_info=error)
            self._say(error_line(error), True)
        else:
            self._say("Saved " + " and ".join(str(path) for path in written), False)


def export(job: ExportJob) -> list[Path]:
    """Write the job's file, and for an EXR the channels beside it; returns what was written.

    The channels have the size of the face crop and the light maps a third one, while the layers of one EXR
    share a size: so the result is one file and the channels another.

    Raises:
        InputError: a place or kind of file that can't be written.
    """
    relit = job.picture.relit
    if job.path.suffix.lower() != ".exr":
        path = free_path(job.path)
        write_image(path, *_whole(job), exposure_ev=job.exposure_ev)
        return [path]
    path = free_path(job.path, _CHANNELS)
    beside = companion_path(path, _CHANNELS)
    header = _header(job)
    write_exr_layers(path, {"RGB" if relit.alpha is None else "RGBA": _premultiplied(job)}, header=header)
    channels = channel_layers(relit.channels)
    if not channels:
        return [path]
    write_exr_layers(beside, channels, header=header)
    return [path, beside]


def channel_layers(channels: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The channels of the face crop, which share a size; composition is the picture of the file."""
    crop_sized = {name: array for name, array in channels.items() if not name.endswith("_light")}
    return {"RGB" if name == "composition" else name: array for name, array in crop_sized.items()}


def default_export_path(photo_path: Path | None) -> Path:
    """<photo>-relit.png beside the photo; in the current folder where the photo's own is no place for it."""
    if photo_path is None:
        return Path.cwd() / "portrait-relit.png"
    folder = photo_path.absolute().parent
    installed = folder.is_relative_to(Path(sys.prefix).absolute())
    if installed or not os.access(folder, os.W_OK | os.X_OK):
        folder = Path.cwd()
    return folder / f"{photo_path.stem}-relit.png"


def free_path(path: Path, companion: str = "") -> Path:
    """The path, or the first of path-2, path-3 ... that doesn't exist, nor its companion."""
    path = path.expanduser()
    number = 1
    candidate = path
    while _taken(candidate) or (companion and _taken(companion_path(candidate, companion))):
        number += 1
        candidate = path.with_name(f"{path.stem}-{number}{path.suffix}")
    return candidate


def companion_path(path: Path, companion: str) -> Path:
    """The file that goes with another: its name with the companion's ending, an EXR."""
    return path.with_name(f"{path.stem}{companion}.exr")


def _taken(path: Path) -> bool:
    return os.path.lexists(path)


def _premultiplied(job: ExportJob) -> np.ndarray:
    image, alpha = _whole(job)
    return image if alpha is None else np.dstack([image * alpha[..., None], alpha])


def _whole(job: ExportJob) -> tuple[np.ndarray, np.ndarray | None]:
    """The result at the photo's size, which a preview made while the hand moved does not have."""
    relit = job.picture.relit
    if relit.image.shape[:2] == job.picture.opened.photo.linear.shape[:2]:
        return relit.image, relit.alpha
    return relit.full.render()


def _header(job: ExportJob) -> dict[str, str | float | int]:
    edit = job.picture.edit
    return {
        "software": f"relight {__version__}",
        "relightLight": job.picture.light.source.title,
        "relightYawDeg": float(edit.yaw_deg),
        "relightExposureEv": float(job.exposure_ev),
        "relightSpecular": float(edit.specular),
        "relightShadow": float(edit.shadow),
        "relightBackground": edit.background,
    }
