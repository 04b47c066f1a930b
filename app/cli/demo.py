"""What the editor's command does where there is no display: the same picture in files."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from app.cli.channels import write_channels
from app.cli.outputs import check_place, make_folder
from app.cli.session import Session, light_files, light_kind
from app.cli.streams import say
from app.cli.turntable import write_turntable
from relight_core.imaging.files import KnownFiles
from relight_core.pipeline.edit import Edit

if TYPE_CHECKING:
    from app.document.document import PhotoRef
    from relight_core.lighting.environment import Environment

DEMO_LIGHTS = ("rembrandt", "soft-window", "golden-hour")
TURNING_LIGHT = "hard-side"


@dataclass(frozen=True)
class _Work:
    """What is relit.

    Attributes:
        photo: whose faces.
        lights: the name and the light of each picture.
        edit: the sliders.
    """

    photo: PhotoRef
    lights: list[tuple[str, Environment]]
    edit: Edit


def write_demo(photo: Path, light: str | None, folder: Path) -> None:
    """Write a photo relit by three lights (or by `light` alone), its channels and a turntable sheet.

    A session gives its photo, its sliders, and its light where `light` names none. Says on stdout what it has written.

    Raises:
        InputError: the photo or light is bad, or the folder can't be written to.
    """
    from relight_core.imaging.write import write_image

    session = Session()
    work = _work(session, photo, light)
    edit = work.edit
    make_folder(folder)
    inputs = KnownFiles([photo, work.photo.path, *light_files(light or str(photo))])
    session.open(work.photo.path, as_chosen=True)
    for name, environment in work.lights:
        output = folder / f"relit-{Path(name).stem}.png"
        check_place(output, inputs)
        relit = session.relighter.relight(environment, edit)
        write_image(output, relit.image, relit.alpha, exposure_ev=edit.exposure_ev)
        say(f"wrote {output}")
    write_channels(relit, edit, folder / "channels", inputs)
    say(f"wrote {folder / 'channels'}/")
    sheet = folder / "turntable.png"
    check_place(sheet, inputs)
    write_turntable(session, environment if len(work.lights) == 1 else session.light(TURNING_LIGHT), edit, sheet)
    say(f"wrote {sheet}")


def _work(session: Session, given: Path, light: str | None) -> _Work:
    """What the command line means by a photo or a session, and a light."""
    from app.document.document import PhotoRef

    if given.suffix.lower() == ".json":
        return _saved_work(session, given, light)
    names = [light] if light else DEMO_LIGHTS
    lights = [(name, session.light(name, metered=True)) for name in names]
    return _Work(PhotoRef(given), lights, session.turned(Edit(quality="final")))


def _saved_work(session: Session, given: Path, light: str | None) -> _Work:
    """A session's work, as the window opens it; `light` takes the place of its light."""
    from app.document.document import LightRef
    from app.document.session_file import read_session
    from app.engine.sources import LightSource
    from relight_core.pipeline.auto_quality import QualityChoice

    read = read_session(given)
    for note in read.told(light_follows=light is not None):
        warnings.warn(f"{given}: {note}", stacklevel=2)
    document, photo = read.document, read.document.photo
    session.heed_corrections(photo)
    edit = replace(document.edit, quality=QualityChoice(document.quality).at_rest())
    if light is None:
        if document.light.kind == "own":
            session.open(photo.path, as_chosen=True)
        environment = session.drawn(document.light, document.light_edit)
        return _Work(photo, [(str(given), environment)], edit)
    if light_kind(light) == "saved":
        return _Work(photo, [(light, session.light(light))], session.turned(replace(edit, yaw_deg=0.0)))
    source = LightSource.named(light)
    is_same = source.same_as(document.light.source())
    changed = document.light_edit if is_same else source.opened_around(document.light_edit)
    return _Work(photo, [(light, session.drawn(LightRef(source.kind, light), changed))], edit)
