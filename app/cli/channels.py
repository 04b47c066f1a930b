"""Write every intermediate channel of one relighting into a folder.

Each channel is written as NAME.png, the way the window shows it. channels.exr holds all of the face crop's
channels as named layers in linear values, the composition as its RGB. source_light.exr and
target_light.exr hold the lights. Of several faces they are the largest one's, and layers.exr has those of all of them
in the photo's frame, the relit picture as its RGB; with --face they are that one's alone.
Files of the same names in the folder are replaced, all together at the end. Strength, exposure and background
change the finished picture only, so no channel depends on them.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from app.cli.arguments import add_one_photo, edit_from
from app.cli.outputs import check_folder, check_place, folder_filled_at_once
from app.cli.report import relit_record, reporting
from app.cli.session import Session, light_files
from relight_core import __version__
from relight_core.errors import InputError
from relight_core.imaging.files import KnownFiles
from relight_core.pipeline.edit import Edit

if TYPE_CHECKING:
    import numpy as np

    from relight_core.pipeline.results.relit import Relit

LIGHTS = ("source_light", "target_light")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of `relight channels`."""
    add_one_photo(parser, "DIR", "a folder", makes_pictures=False)


def run(arguments: argparse.Namespace) -> int:
    """Write the channels; returns the exit code."""
    folder, edit = arguments.output, edit_from(arguments)
    if "channels" in edit.forced_off:
        raise InputError("--force channels=off: leaves no channel to write; take it away")
    check_folder(folder, is_made=True)
    with reporting(arguments.json) as report:
        session = Session()
        light = session.light(arguments.light, arguments.meter)
        edit = session.turned(edit)
        session.open(arguments.photo, arguments.face, arguments.box, arguments.add_box)
        # The picture itself is not among the files.
        relit = session.relighter.relight(light, edit, longest_side_px=0)
        inputs = KnownFiles([arguments.photo, *light_files(arguments.light)])
        written = write_channels(relit, edit, folder, inputs)
        for path in written:
            report.line(f"wrote {path}")
        if len(relit.faces) > 1:
            report.line(
                f"layers.exr has all {len(relit.faces)} faces, the others the largest one; --face N chooses another"
            )
        record = relit_record(str(arguments.photo), str(folder), relit)
        report.record(record | {"files": [str(path) for path in written]})
    return 0


def write_channels(relit: Relit, edit: Edit, folder: Path, inputs: KnownFiles) -> list[Path]:
    """Write a Relit's channels into the folder: all files, or none.

    Returns:
        the files' paths.

    Raises:
        InputError: the folder can't be written to, or a file would replace one of the inputs.
    """
    from app.engine.exporting import channel_layers
    from relight_core.imaging.write import write_exr_layers, write_image
    from relight_core.pipeline.results.layers import LAYERS, photo_layers

    with folder_filled_at_once(folder) as scratch:
        for name, channel in relit.channels.items():
            _write_view(scratch / f"{name}.png", name, channel)
        header = {"software": f"relight {__version__}", "relightYawDeg": float(edit.yaw_deg)}
        write_exr_layers(scratch / "channels.exr", channel_layers(relit.channels), header=header)
        if len(relit.faces) > 1:
            write_exr_layers(scratch / "layers.exr", photo_layers(relit, LAYERS), header=header)
        for name in LIGHTS:
            if name in relit.channels:
                # Halves end where the sun of a panorama or a photo in units of its own may not.
                write_image(scratch / f"{name}.exr", relit.channels[name], bits=32)
        written = [folder / path.name for path in sorted(scratch.iterdir())]
        for path in written:
            check_place(path, inputs)
    return written


def _write_view(path: Path, name: str, channel: np.ndarray) -> None:
    from relight_core.imaging.colour import srgb_decode
    from relight_core.imaging.write import write_image
    from relight_core.pipeline.results.channel_view import channel_to_srgb

    write_image(path, srgb_decode(channel_to_srgb(name, channel)))
