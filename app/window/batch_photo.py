"""One photo of a batch: relit as a document says and written, with the lights that a batch needs for that."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from app.document.document import Document, LightRef
from app.engine.exporting import ExportSettings, export_note, write_relit
from app.engine.resized import size_note, size_of
from app.engine.snapshot import OpenLight
from app.engine.sources import BORROWED_AT, RelighterLike, base_light, borrowed_light
from relight_core.errors import InputError
from relight_core.imaging.files import KnownFiles
from relight_core.imaging.read import read_photo
from relight_core.lighting.environment import Environment
from relight_core.lighting.light_edit import LightEdit, edit_light
from relight_core.pipeline.auto_quality import QualityChoice

_KEPT_LIGHTS = 3
"""Photos that follow each other mostly share a light; a large panorama takes hundreds of megabytes."""


class BatchLights:
    """The lights of a batch, with what was changed about them.

    Args:
        in_force: the light that is open: used as it was read, whatever became of its file since.
    """

    def __init__(self, in_force: OpenLight) -> None:
        self._in_force = in_force
        self._drawn: dict[tuple[LightRef, LightEdit], Environment] = {}

    def of(self, document: Document, relighter: RelighterLike) -> Environment:
        """A document's light; not the photo's own, which none but its portrait tells.

        One that is borrowed makes its lender the relighter's portrait.

        Raises:
            InputError: its file is gone or bad.
        """
        known, edit = self._in_force, document.light_edit
        if document.light.source().same_as(known.source):
            return known.environment if edit == known.edit else edit_light(known.base, edit)
        key = document.light, edit
        if key not in self._drawn:
            base = base_light(
                document.light.source(),
                borrow=lambda lender: borrowed_light(relighter, read_photo(lender)),
                estimate_own=lambda: relighter.estimated_light(BORROWED_AT),
            )
            drawn = edit_light(base, edit)
            self._drawn = dict([*self._drawn.items(), (key, drawn)][-_KEPT_LIGHTS:])
        return self._drawn[key]


def relight_as(
    document: Document,
    lights: BatchLights,
    relighter: RelighterLike,
    output: Path,
    settings: ExportSettings,
    photos: KnownFiles,
) -> str | None:
    """Relight a document's photo as the document says, at its quality, and write it.

    Args:
        photos: all of the batch, none of which is written over.

    Returns:
        A line on what became of corrections that were made at another size of the photo; None where they fit.

    Raises:
        InputError: no photo, no face, no light, or a place that can't be written.
    """
    portrait, is_own = document.photo, document.light.kind == "own"
    if photos.named(output) is not None:
        raise InputError(f"{output}: one of the photos is there; move it to another folder")
    opened = read_photo(portrait.path)
    # Before the portrait is set, whose place a lender takes.
    environment = None if is_own else lights.of(document, relighter)
    wish = portrait.wish(opened)
    relighter.set_portrait(opened, wish.face_index, wish.boxes, wish.strokes)
    if is_own:
        environment = edit_light(relighter.estimated_light(BORROWED_AT), document.light_edit)
    channels = None if settings.form == ".exr" and settings.layers else ()
    edit = replace(document.edit, quality=QualityChoice(document.quality).at_rest(), channels=channels)
    # The exposure comes last, when the file is written.
    relit = relighter.relight(environment, replace(edit, exposure_ev=0.0))
    note = export_note(document.light.source().title, edit)
    write_relit(output, relit, settings, edit.exposure_ev, note, opened)
    resized = size_note(portrait, size_of(opened))
    return resized and f"{portrait.path}: {resized}"
