"""What the editor's command does where there is no display: the same picture in files."""

from __future__ import annotations

from pathlib import Path

from app.cli.channels import write_channels
from app.cli.outputs import check_place, make_folder
from app.cli.session import Session, light_files
from app.cli.turntable import write_turntable
from relight_core.pipeline.edit import Edit

DEMO_LIGHTS = ("rembrandt", "soft-window", "golden-hour")
TURNING_LIGHT = "hard-side"


def write_demo(photo: Path, light: str | None, folder: Path) -> None:
    """Write a photo relit by three lights (or by `light` alone), its channels and a turntable sheet.

    Says on stdout what it has written.

    Raises:
        InputError: the photo or light is bad, or the folder can't be written to.
    """
    from relight_core.imaging.write import write_image

    make_folder(folder)
    inputs = [photo, *light_files(light or "")]
    edit = Edit(quality="final")
    session = Session()
    lights = [(name, session.light(name, metered=True)) for name in ([light] if light else DEMO_LIGHTS)]
    session.open(photo)
    for name, environment in lights:
        output = folder / f"relit-{Path(name).stem}.png"
        check_place(output, inputs)
        relit = session.relighter.relight(environment, edit)
        write_image(output, relit.image, relit.alpha)
        print(f"wrote {output}", flush=True)
    write_channels(relit, edit, folder / "channels", inputs)
    print(f"wrote {folder / 'channels'}/", flush=True)
    sheet = folder / "turntable.png"
    check_place(sheet, inputs)
    write_turntable(session, lights[0][1] if light else session.light(TURNING_LIGHT), edit, sheet)
    print(f"wrote {sheet}", flush=True)
