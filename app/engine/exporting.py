"""Saving what is shown: kinds of file, names that overwrite nothing, and what is noted in the file."""

from __future__ import annotations

import os
import secrets
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path

import numpy as np

from app.engine.jobs import JobControl, Jobs
from app.engine.places import current_folder, folder_for_outputs, from_home
from app.engine.snapshot import Picture
from app.engine.sources import RelitLike
from relight_core import __version__
from relight_core.errors import InputError
from relight_core.imaging.files import is_same_file, legible
from relight_core.imaging.photo import Photo
from relight_core.imaging.resampling import shrunk_size
from relight_core.imaging.write import Bands, FileStyle, cut, write_bands, write_exr_layers
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.results.layers import LAYERS, photo_layers, shrunk_picture

EXPORT = "Export"
FORMS = (".png", ".jpg", ".tif", ".exr")
SIDES = (None, 4096, 2048, 1080)
"""Longest sides to choose from; None is the photo's own size."""
PROFILES = ("srgb", "photo")
QUALITIES = (50, 100)
"""The lowest and the highest of a JPEG to choose from."""


@dataclass(frozen=True)
class ExportSettings:
    """How a picture is saved.

    Attributes:
        form: of FORMS.
        deep: 16 bits in PNG and TIFF, 32-bit floats in EXR; else 8 bits and halves.
        quality: of a JPEG, 1 to 100.
        longest_side: pixels, or None for the photo's own size.
        profile: of PROFILES, for all but EXR: colours are written in sRGB or, if the photo has one, in its own profile.
        layers: of relight_core.pipeline.results.layers.LAYERS, for EXR.
    """

    form: str = ".png"
    deep: bool = False
    quality: int = 92
    longest_side: int | None = None
    profile: str = "srgb"
    layers: tuple[str, ...] = LAYERS

    @property
    def bits(self) -> int:
        """For `write_image`."""
        if self.form == ".jpg":
            return 8
        if self.form == ".exr":
            return 32 if self.deep else 16
        return 16 if self.deep else 8


@dataclass(frozen=True, eq=False)
class ExportJob:
    """One file to write.

    Attributes:
        picture: what to save.
        exposure_ev: stops, baked into 8- and 16-bit files and noted in EXR ones.
        path: its suffix is that of the settings' form.
        settings: how.
        replaces: the user has agreed to replace what is there; else a number is added to the name.
    """

    picture: Picture
    exposure_ev: float
    path: Path
    settings: ExportSettings = field(default_factory=ExportSettings)
    replaces: bool = False


class Exporter(Jobs):
    """The jobs of a window, among them exports."""

    def submit(self, job: ExportJob) -> None:
        """Queue an export."""

        def work(control: JobControl) -> str:
            path = export(job, control.step)
            return f"Saved {legible(str(path))}"

        self.start(EXPORT, work)


def _unheeded(done: int, total: int) -> None:
    """Nobody asks how far it is."""


def export(job: ExportJob, step: Callable[[int, int], None] = _unheeded) -> Path:
    """Write the job's file; returns its path.

    Args:
        step: told how much of the work is done, of how much; what it raises leaves no file.

    Raises:
        InputError: a place or kind of file that can't be written, the photo itself among them.
    """
    photo = job.picture.opened.photo
    if job.replaces and photo.path is not None and is_same_file(from_home(job.path), photo.path):
        raise InputError(f"{job.path}: that is the photo itself; choose another name")
    note = export_note(job.picture.light.source.title, replace(job.picture.edit, exposure_ev=job.exposure_ev))

    def write(path: Path) -> None:
        write_relit(path, job.picture.relit, job.settings, job.exposure_ev, note, photo, step)

    return write_named(job.path, job.replaces, write)


def write_relit(
    path: Path,
    relit: RelitLike,
    settings: ExportSettings,
    exposure_ev: float,
    note: dict[str, str | float],
    photo: Photo,
    step: Callable[[int, int], None] = _unheeded,
) -> None:
    """Write a relit portrait as the settings say, replacing what is there.

    Args:
        note: what the file says of how it was made; see `export_note`.
        photo: whose Exif and, if the settings say so, profile the file has; EXR has neither.
        step: as of `export`.

    Raises:
        InputError: a place or kind of file that can't be written.
    """
    is_exr = settings.form == ".exr"
    if is_exr and (settings.layers or settings.longest_side is not None):
        _write_layers(path, relit, settings, note, step)
        return
    # Radiance carries no exposure; what the file says of it is enough.
    exposure_ev, icc = 0.0 if is_exr else exposure_ev, photo.icc if settings.profile == "photo" else None
    style = FileStyle(settings.bits, settings.quality, exposure_ev, icc, photo.exif, note)
    wide = is_exr or icc is not None
    if relit.full is not None and shrunk_size(relit.full.size, settings.longest_side) == relit.full.size:
        rows = _counted(relit.full.in_bands(wide=wide), relit.full.size[0], step)
        write_bands(path, relit.full.size, rows, relit.full.has_alpha, style)
        return
    image, alpha = shrunk_picture(relit, settings.longest_side, wide=wide)
    write_bands(path, image.shape[:2], cut(image, alpha), alpha is not None, style)


def _write_layers(
    path: Path,
    relit: RelitLike,
    settings: ExportSettings,
    note: dict[str, str | float],
    step: Callable[[int, int], None],
) -> None:
    """An EXR of the picture and its layers; to write it counts as much as to make them."""
    made, parts = count(), 1 + len(settings.layers)
    step(next(made), 2 * parts)
    layers = photo_layers(relit, settings.layers, settings.longest_side, lambda: step(next(made), 2 * parts))
    how = {"half": not settings.deep, "header": note}
    write_exr_layers(path, layers, **how, step=lambda row, rows: step(rows + row, 2 * rows))


def _counted(bands: Bands, height: int, step: Callable[[int, int], None]) -> Bands:
    """The same bands of rows, of which each is told before the next is asked for."""
    for rows, image, alpha in bands:
        step(rows.start, height)
        yield rows, image, alpha


def export_note(light: str, edit: Edit) -> dict[str, str | float]:
    """What a file says of how it was made."""
    return {
        "software": f"relight {__version__}",
        "relightLight": light,
        "relightYawDeg": float(edit.yaw_deg),
        "relightExposureEv": float(edit.exposure_ev),
        "relightSpecular": float(edit.specular),
        "relightShadow": float(edit.shadow),
        "relightSpecularTint": float(edit.specular_tint),
        "relightShadowSoftness": float(edit.shadow_softness),
        "relightStrength": float(edit.strength),
        "relightBackground": edit.background,
    }


def channel_layers(channels: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The channels of the face crop, which share a size; composition is the picture of the file."""
    crop_sized = {name: array for name, array in channels.items() if not name.endswith("_light")}
    return {"RGB" if name == "composition" else name: array for name, array in crop_sized.items()}


def default_export_path(photo_path: Path | None) -> Path:
    """<photo>-relit.png in the photo's folder for outputs; portrait-relit.png in the current one without a photo."""
    if photo_path is None:
        return current_folder() / "portrait-relit.png"
    return folder_for_outputs(photo_path) / f"{photo_path.stem}-relit.png"


def write_named(wish: Path, replaces: bool, write: Callable[[Path], None]) -> Path:
    """Write a file, over what is there or under the first free name as of `free_path`; returns its path.

    A name is taken when the file is complete: until then another window may take the one that was free.

    Args:
        write: writes the file, whole or not at all, to the path that it is given.

    Raises:
        InputError: what `write` raises, of the file's own name.
    """
    path = from_home(wish)
    if replaces:
        write(path)
        return path
    beside = path.with_name(f".{secrets.token_hex(8)}{path.suffix}")
    try:
        write(beside)
        return _named_free(beside, path)
    except InputError as error:
        raise InputError(str(error).replace(beside.name, path.name)) from error
    except OSError as error:
        raise InputError(f"{path}: can't be written ({error.strerror}); choose another place") from error
    finally:
        with suppress(OSError):
            beside.unlink(missing_ok=True)


def _named_free(beside: Path, wish: Path) -> Path:
    """Give a file the first free name; unlike a renaming, a link never replaces what took that name just now."""
    while True:
        path = free_path(wish)
        try:
            os.link(beside, path)
        except FileExistsError:
            continue
        except OSError:
            # Not every disk has links, cards and sticks for one.
            os.rename(beside, path)
        return path


def free_path(path: Path, ending: str = "") -> Path:
    """The path, or the first of path-2, path-3 ... that doesn't exist.

    Args:
        ending: what stays behind the number where the name ends with it, in whichever letters; else its suffix does.
    """
    path = from_home(path)
    behind = path.name[-len(ending) :] if ending and path.name.lower().endswith(ending) else path.suffix
    name = path.name.removesuffix(behind)
    number = 1
    candidate = path
    while os.path.lexists(candidate):
        number += 1
        candidate = path.with_name(f"{name}-{number}{behind}")
    return candidate
