"""Relighting many photos: which they are, and what becomes of those not opened and of pictures that are there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from app.engine.batch import photos_in
from app.engine.places import folder_for_outputs
from app.engine.sources import LightSource
from app.ui.asking import Asking, Question
from app.ui.state import EditorState
from app.window.outputs import Outputs
from app.window.own_work import own_work
from app.window.replacing import tried
from relight_core.imaging.files import KnownFiles

_FOLDER = "relit"


def photos_beside(folder: Path, light: LightSource) -> list[Path]:
    """The photos of a folder; the panorama that is the light is none of them.

    Raises:
        InputError: as of `photos_in`.
    """
    return photos_in(folder, KnownFiles([Path(light.name)] if light.kind == "panorama" else []))


def relight_as_left(state: EditorState, outputs: Outputs) -> None:
    """Relight each photo of the queue as it was left, after asking what becomes of those without work of their own."""
    photos, asking = list(state.queue.paths), state.asking
    known = [photo for photo in photos if own_work(state, photo) is not None]

    def start(chosen: list[Path]) -> Callable[[], None]:
        return lambda: tried(asking, lambda: relight_many(chosen, outputs, asking, as_left=True))

    if len(known) == len(photos):
        start(photos)()
        return
    only_known = ((f"Only the other {len(known)}", start(known)),) if known else ()
    unknown = len(photos) - len(known)
    were, them = ("was", "it") if unknown == 1 else ("were", "them")
    text = f"{unknown} of these {len(photos)} photos {were} neither opened nor saved yet: relight {them} like this one?"
    choices = ((f"Relight all {len(photos)}", start(photos)), *only_known, ("Cancel", lambda: None))
    asking.ask(Question("batch", text, choices, calling_off="Cancel"))


def relight_many(photos: list[Path], outputs: Outputs, asking: Asking, as_left: bool = False) -> None:
    """Relight photos into a folder of their own, after asking where it has pictures of them already, or gets them now.

    Args:
        as_left: as of `Outputs.batch_over`.
    """
    folder = folder_for_outputs(photos[0]) / _FOLDER
    there, coming = outputs.done_already(photos, folder)
    done = there + coming
    if not done:
        outputs.batch_over(photos, folder, as_left=as_left)
        return

    # The question is about files of this kind, whichever is chosen by the time it is answered.
    settings = outputs.settings

    def start(replaces: bool) -> Callable[[], None]:
        return lambda: tried(asking, lambda: outputs.batch_over(photos, folder, replaces, settings, as_left))

    rest = len(photos) - done
    only_the_rest = ((f"Relight the other {rest}", start(False)),) if rest else ()
    have = "has a picture" if done == 1 else "have pictures"
    or_will = ", or will once the batch before is done" if coming else ""
    text = f"{done} of these {len(photos)} photos {have} in {folder}{or_will}."
    choices = (*only_the_rest, ("Replace", start(True)), ("Cancel", lambda: None))
    asking.ask(Question("batch", text, choices, calling_off="Cancel"))
