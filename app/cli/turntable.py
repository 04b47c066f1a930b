"""Write a sheet of one face under a light that turns once around it, in steps of 30 degrees."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from app.cli.arguments import add_one_photo, edit_from
from app.cli.outputs import check_place
from app.cli.report import relit_record, reporting
from app.cli.session import Session, light_files
from relight_core.pipeline.edit import Edit

if TYPE_CHECKING:
    import numpy as np

    from relight_core.face.find import FaceBox
    from relight_core.lighting.environment import Environment
    from relight_core.pipeline.results.relit import Relit

STEPS = 12
_COLUMNS = 4
_CELL_PX = 320
_REACH = 1.1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of `relight turntable`."""
    add_one_photo(parser, "SHEET", "a picture file")


def run(arguments: argparse.Namespace) -> int:
    """Write the sheet; returns the exit code."""
    from relight_core.imaging.write import check_output

    check_output(arguments.output)
    check_place(arguments.output, [arguments.photo, *light_files(arguments.light)])
    with reporting(arguments.json) as report:
        session = Session()
        light = session.light(arguments.light, arguments.meter)
        session.open(arguments.photo, arguments.face, arguments.box)
        edit = replace(edit_from(arguments), channels=())
        last = write_turntable(session, light, edit, arguments.output)
        report.line(f"wrote {arguments.output}")
        report.record(relit_record(str(arguments.photo), str(arguments.output), last))
    return 0


def write_turntable(session: Session, light: Environment, edit: Edit, output: Path) -> Relit:
    """Relight the session's portrait with the light at 12 yaws from edit.yaw_deg on, and write the sheet.

    It shows the surroundings of the face.

    Returns:
        the last step's Relit.

    Raises:
        InputError: the file can't be written.
    """
    from app.cli.sheet import contact_sheet
    from relight_core.imaging.photo import Photo
    from relight_core.imaging.view_transform import apply_view
    from relight_core.imaging.write import write_image

    pictures = []
    for step in range(STEPS):
        yaw_deg = edit.yaw_deg + step * 360.0 / STEPS
        relit = session.relighter.relight(light, replace(edit, yaw_deg=yaw_deg))
        shown = _around(relit.image, relit.faces[0])
        pictures.append((f"yaw {yaw_deg:g}°", apply_view(shown, edit.exposure_ev)))
    write_image(output, Photo.from_srgb(contact_sheet(pictures, _COLUMNS, _CELL_PX)).linear)
    return relit


def _around(image: np.ndarray, box: FaceBox) -> np.ndarray:
    """The part of a photo within _REACH times the box's longer side of its middle."""
    reach = _REACH * max(box.x1 - box.x0, box.y1 - box.y0)
    middle_x, middle_y = (box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2
    left, top = (max(0, round(edge - reach)) for edge in (middle_x, middle_y))
    return image[top : round(middle_y + reach), left : round(middle_x + reach)]
