"""Relighting many photos like the one that is open: which they are, and what becomes of pictures that are there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from app.engine.batch import photos_in
from app.engine.places import folder_for_outputs
from app.engine.sources import LightSource
from app.ui.asking import Asking, Question
from app.window.outputs import Outputs
from app.window.replacing import tried
from relight_core.imaging.files import KnownFiles

_FOLDER = "relit"


def photos_beside(folder: Path, light: LightSource) -> list[Path]:
    """The photos of a folder; the panorama that is the light is none of them.

    Raises:
        InputError: as of `photos_in`.
    """
    return photos_in(folder, KnownFiles([Path(light.name)] if light.kind == "panorama" else []))


def relight_many(photos: list[Path], outputs: Outputs, asking: Asking) -> None:
    """Relight photos into a folder of their own, after asking where it has pictures of them already."""
    folder = folder_for_outputs(photos[0]) / _FOLDER
    done = outputs.done_already(photos, folder)
    if not done:
        outputs.batch_over(photos, folder)
        return

    # The question is about files of this kind, whichever is chosen by the time it is answered.
    settings = outputs.settings

    def start(replaces: bool) -> Callable[[], None]:
        return lambda: tried(asking, lambda: outputs.batch_over(photos, folder, replaces, settings))

    rest = len(photos) - done
    only_the_rest = ((f"Relight the other {rest}", start(False)),) if rest else ()
    text = f"{done} of these {len(photos)} photos {'has a picture' if done == 1 else 'have pictures'} in {folder}."
    choices = (*only_the_rest, ("Replace", start(True)), ("Cancel", lambda: None))
    asking.ask(Question("batch", text, choices))
