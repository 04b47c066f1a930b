"""Write one face under a light that turns once around it: a sheet in steps of 30 degrees, or the photo as a film."""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from app.cli.arguments import add_one_photo, edit_from
from app.cli.outputs import check_place
from app.cli.report import counting, relit_record, reporting
from app.cli.session import Session, light_files
from relight_core.errors import InputError
from relight_core.imaging.files import KnownFiles
from relight_core.pipeline.edit import Edit

if TYPE_CHECKING:
    from relight_core.face.find import FaceBox
    from relight_core.lighting.environment import Environment
    from relight_core.pipeline.per_photo.person import Canvas
    from relight_core.pipeline.results.relit import Relit

STEPS = 12
_FILM_SUFFIX = ".mp4"
_COLUMNS = 4
_CELL_PX = 320
_REACH = 1.1
_FINER = 2
"""Pixels are made so many times as fine as the sheet's, which is sharper for it."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of `relight turntable`."""
    add_one_photo(parser, "OUT", "a picture file for the sheet, or an .mp4 for a film of 5 seconds")


def run(arguments: argparse.Namespace) -> int:
    """Write the sheet or the film; returns the exit code."""
    from relight_core.imaging.write import check_output

    is_film = arguments.output.suffix.lower() == _FILM_SUFFIX
    if not is_film:
        try:
            check_output(arguments.output)
        except InputError as error:
            raise InputError(f"{error}, or an {_FILM_SUFFIX} for a film") from error
    check_place(arguments.output, KnownFiles([arguments.photo, *light_files(arguments.light)]))
    with reporting(arguments.json) as report:
        session = Session()
        light = session.light(arguments.light, arguments.meter)
        session.open(arguments.photo, arguments.face, arguments.box, arguments.add_box)
        edit = session.turned(replace(edit_from(arguments), channels=()))
        write = write_film_of_turn if is_film else write_turntable
        last = write(session, light, edit, arguments.output)
        report.line(f"wrote {arguments.output}")
        report.record(relit_record(str(arguments.photo), str(arguments.output), last))
    return 0


def write_turntable(session: Session, light: Environment, edit: Edit, output: Path) -> Relit:
    """Relight the session's portrait with the light at 12 yaws from edit.yaw_deg on, and write the sheet.

    It shows the surroundings of the face, and where a background was taken away the sheet's ground.

    Returns:
        the last step's Relit.

    Raises:
        InputError: the file can't be written.
    """
    from relight_core.imaging.contact_sheet import contact_sheet, on_ground
    from relight_core.imaging.photo import Photo
    from relight_core.imaging.view_transform import apply_view
    from relight_core.imaging.write import write_image

    pictures, canvas = [], None
    for step in range(STEPS):
        yaw_deg = edit.yaw_deg + step * 360.0 / STEPS
        # Of the whole picture nothing is made: the sheet shows a part of it, and that small.
        relit = session.relighter.relight(light, replace(edit, yaw_deg=yaw_deg), longest_side_px=0)
        window = _around(relit.faces[0], relit.size)
        canvas = canvas or _fine_enough(relit.full.canvas, window)
        image, alpha = replace(relit.full, canvas=canvas).part(_on_canvas(window, canvas))
        srgb = apply_view(image, edit.exposure_ev)
        pictures.append((f"yaw {yaw_deg % 360.0:g}°", srgb if alpha is None else on_ground(srgb, alpha)))
    write_image(output, Photo.from_srgb(contact_sheet(pictures, _COLUMNS, _CELL_PX)).linear)
    return relit


def write_film_of_turn(session: Session, light: Environment, edit: Edit, output: Path) -> Relit:
    """Relight the session's photo with the light at each frame's yaw, from edit.yaw_deg on, and write the film.

    How far it is is told where stderr is a terminal.

    Returns:
        the Relit of the first frame, but for its picture.

    Raises:
        InputError: the film can't be written.
    """
    from app.engine.film import write_film
    from app.engine.turntable import FILM_PX, FRAMES, turning

    frames = turning(session.relighter, light, edit, FILM_PX)
    with counting("relighting") as step:
        write_film(output, frames, FRAMES, step)
    return session.relighter.relight(light, edit, longest_side_px=0)


def _around(box: FaceBox, size: tuple[int, int]) -> tuple[int, int, int, int]:
    """What of a photo lies within _REACH times the box's longer side of its middle: x0, y0, x1, y1 in pixels.

    Args:
        size: (height, width) of the photo.
    """
    reach = _REACH * max(box.x1 - box.x0, box.y1 - box.y0)
    middle_x, middle_y = (box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2
    left, top = (max(0, round(edge - reach)) for edge in (middle_x, middle_y))
    return left, top, min(size[1], round(middle_x + reach)), min(size[0], round(middle_y + reach))


def _fine_enough(canvas: Canvas, window: tuple[int, int, int, int]) -> Canvas:
    """The photo, or a copy of it in which a window has about _FINER times the pixels of its cell of the sheet."""
    from relight_core.pipeline.per_photo.person import shrunk

    side = max(window[2] - window[0], window[3] - window[1])
    return shrunk(canvas, math.ceil(max(canvas.size) * _FINER * _CELL_PX / side))


def _on_canvas(window: tuple[int, int, int, int], canvas: Canvas) -> tuple[int, int, int, int]:
    """A window of the photo in pixels of a canvas, of which it has at least one."""
    x0, y0, x1, y1 = window
    (height, width), (photo_height, photo_width) = canvas.size, canvas.photo_size
    left, top = min(round(x0 * width / photo_width), width - 1), min(round(y0 * height / photo_height), height - 1)
    right, bottom = round(x1 * width / photo_width), round(y1 * height / photo_height)
    return left, top, max(right, left + 1), max(bottom, top + 1)
