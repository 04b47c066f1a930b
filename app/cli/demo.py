"""What the editor's command does where there is no display: the same picture in files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from app.cli.channels import write_channels
from app.cli.outputs import check_place, make_folder
from app.cli.session import Session, light_files
from app.cli.turntable import write_turntable
from relight_core.pipeline.edit import Edit

if TYPE_CHECKING:
    from app.document.document import PhotoRef

DEMO_LIGHTS = ("rembrandt", "soft-window", "golden-hour")
TURNING_LIGHT = "hard-side"


def write_demo(photo: Path, light: str | None, folder: Path) -> None:
    """Write a photo relit by three lights (or by `light` alone), its channels and a turntable sheet.

    A session gives its photo, its sliders, and its light where `light` names none. Says on stdout what it has written.

    Raises:
        InputError: the photo or light is bad, or the folder can't be written to.
    """
    from relight_core.imaging.write import write_image

    session = Session()
    opened, light, edit = _work(session, photo, light)
    make_folder(folder)
    inputs = [photo, opened.path, *light_files(light or "")]
    lights = [(name, session.light(name, metered=True)) for name in ([light] if light else DEMO_LIGHTS)]
    session.open(opened.path, opened.face_index)
    for name, environment in lights:
        output = folder / f"relit-{Path(name).stem}.png"
        check_place(output, inputs)
        relit = session.relighter.relight(environment, edit)
        write_image(output, relit.image, relit.alpha, exposure_ev=edit.exposure_ev)
        print(f"wrote {output}", flush=True)
    write_channels(relit, edit, folder / "channels", inputs)
    print(f"wrote {folder / 'channels'}/", flush=True)
    sheet = folder / "turntable.png"
    check_place(sheet, inputs)
    write_turntable(session, lights[0][1] if light else session.light(TURNING_LIGHT), edit, sheet)
    print(f"wrote {sheet}", flush=True)


def _work(session: Session, given: Path, light: str | None) -> tuple[PhotoRef, str | None, Edit]:
    """The photo, the light's name and the sliders that the command line means."""
    from app.document.document import PhotoRef

    if given.suffix.lower() != ".json":
        return PhotoRef(given), light, Edit(quality="final")
    from app.document.session_file import read_session

    document = read_session(given).document
    session.heed_boxes(document.photo)
    light = light or str(given)
    # A saved light comes turned as it was saved.
    edit = replace(document.edit, yaw_deg=0.0) if light.lower().endswith(".json") else document.edit
    return document.photo, light, edit
