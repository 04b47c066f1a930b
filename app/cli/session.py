"""What the relighting subcommands share: one Relighter, the light, the photo."""

from __future__ import annotations

import difflib
import os
import time
import warnings
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

from app.making import make_relighter
from relight_core.errors import InputError, NoFaceError

if TYPE_CHECKING:
    from app.document.document import LightRef, PhotoRef
    from relight_core.face.find import FaceBox
    from relight_core.imaging.photo import Photo
    from relight_core.lighting.environment import Environment
    from relight_core.lighting.light_edit import LightEdit
    from relight_core.pipeline.edit import Edit
    from relight_core.pipeline.relighter import Relighter


def sample_portrait() -> Path:
    """The public-domain portrait of Eileen Collins that scikit-image carries."""
    return Path(str(files("skimage") / "data" / "astronaut.png"))


class Session:
    """One command's Relighter, made when first needed so that bad input is told before it loads.

    Attributes:
        opening_ms: what it took to "read" the last photo and to "find" its faces.
        turn_deg: by how much the light was turned when it was saved; see `turned`.
    """

    def __init__(self) -> None:
        self.opening_ms: dict[str, float] = {}
        self.turn_deg = 0.0
        self._corrected: dict[str, PhotoRef] = {}

    @cached_property
    def relighter(self) -> Relighter:
        """The one Relighter of this command."""
        return make_relighter()

    def light(self, text: str, metered: bool = False) -> Environment:
        """The light that L names: a bundled rig, an .hdr or .exr panorama, a portrait's own light, or a saved one.

        A saved one is not turned yet: its turn is for `turned`.

        Args:
            metered: bring a panorama to the level that suits a photo; a saved light says that itself.

        Raises:
            InputError: L is none of these, or its file is bad.
        """
        from relight_core.lighting.light_edit import LightEdit, edit_light

        kind, self.turn_deg = light_kind(text), 0.0
        if kind == "saved":
            return self._saved_light(Path(text))
        base = self._base(kind, text)
        return edit_light(base, LightEdit(metered=metered)) if kind == "panorama" else base

    def drawn(self, light: LightRef, changed: LightEdit) -> Environment:
        """A light with all that was changed about it; the photo's own is that of the portrait that is open.

        Raises:
            InputError: its file is bad, or there is no portrait.
        """
        from relight_core.lighting.light_edit import edit_light

        return edit_light(self._base(light.kind, light.name), changed)

    def _base(self, kind: str, name: str) -> Environment:
        """A light of a kind as of LightSource, before anything is changed about it."""
        from app.engine.sources import BORROWED_AT, LightSource, base_light, no_light_to_borrow

        def estimate_own() -> Environment:
            return self.relighter.estimated_light(BORROWED_AT)

        def borrow(portrait: Path) -> Environment:
            try:
                self.open(portrait)
            except NoFaceError:
                raise no_light_to_borrow(portrait) from None
            return estimate_own()

        return base_light(LightSource(kind, name), borrow, estimate_own)

    def _saved_light(self, path: Path) -> Environment:
        """A light file's light, or a session's, with all that was changed about it."""
        from app.document.session_file import read_lent_light

        lent = read_lent_light(path)
        saved = lent.saved
        if lent.photo is not None:
            self.heed_corrections(lent.photo)
        for note in saved.notes:
            warnings.warn(f"{path}: {note}", stacklevel=2)
        self.turn_deg = saved.yaw_deg
        return self.drawn(saved.light, saved.light_edit)

    def turned(self, edit: Edit) -> Edit:
        """The edit with the turn that the light was saved with added to its own.

        As the window turns it: a map whose texels are moved beforehand is another one, and a coarse one shows them.
        """
        return replace(edit, yaw_deg=edit.yaw_deg + self.turn_deg)

    def heed_corrections(self, photo: PhotoRef) -> None:
        """Let the boxes and strokes that a saved session has of this photo count when it is opened."""
        self._corrected[os.path.realpath(photo.path)] = photo

    def open(
        self,
        path: Path,
        face_index: int | None = None,
        only: Sequence[Sequence[float]] = (),
        added: Sequence[Sequence[float]] = (),
        as_chosen: bool = False,
    ) -> Photo:
        """Read a photo and make it the Relighter's portrait.

        Boxes and strokes of a session count for the photo they were made on; see `heed_corrections`.

        Args:
            only: left, top, right and bottom of faces in photo pixels, where they are not to be looked for.
            added: the same of more faces, counted after those of `only`, of the session or those that are found.
            as_chosen: the session also says which face alone.

        Raises:
            InputError: not a photo, or no such face in it.
        """
        began = time.perf_counter()
        photo = _read(path)
        read_ms = (time.perf_counter() - began) * 1e3
        corrected = self._corrections_in(path, photo)
        if as_chosen:
            face_index = corrected.face_index
        began = time.perf_counter()
        boxes = self._boxes(photo, corrected, only, added)
        try:
            self.relighter.set_portrait(photo, face_index, boxes, corrected.strokes)
        except InputError as error:
            if boxes is None or boxes is not corrected.boxes:
                raise
            hint = "the light's session says where faces are in it, and --box says it anew"
            raise type(error)(f"{error}; {hint}") from None
        self.opening_ms = {"read": read_ms, "find": (time.perf_counter() - began) * 1e3}
        return photo

    def _boxes(
        self, photo: Photo, corrected: PhotoRef, only: Sequence[Sequence[float]], added: Sequence[Sequence[float]]
    ) -> Sequence[FaceBox] | None:
        """Where faces are, as of `open`; None is wherever they are found."""
        from relight_core.face.find import FaceBox

        boxes = [FaceBox(*box) for box in only] if only else corrected.boxes
        if not added:
            return boxes
        return [*(self._found(photo) if boxes is None else boxes), *(FaceBox(*box) for box in added)]

    def _corrections_in(self, path: Path, photo: Photo) -> PhotoRef:
        """What a saved session has of the photo that has been read; told, once, where that has another size now."""
        from app.document.document import PhotoRef
        from app.engine.resized import at_size, size_note, size_of

        place = os.path.realpath(path)
        saved = self._corrected.get(place)
        if saved is None:
            return PhotoRef(path)
        note = size_note(saved, size_of(photo))
        if note is not None:
            warnings.warn(f"{path}: {note}", stacklevel=3)
        self._corrected[place] = at_size(saved, size_of(photo))
        return self._corrected[place]

    def _found(self, photo: Photo) -> tuple[FaceBox, ...]:
        """The faces that are found by themselves in a photo, which becomes the portrait where there are any."""
        try:
            self.relighter.set_portrait(photo)
        except NoFaceError:
            return ()
        return self.relighter.people


def _read(path: Path) -> Photo:
    from relight_core.imaging.read import read_photo

    if path.suffix.lower() == ".json" and os.path.isfile(path):
        raise InputError(f"{path}: no photo; name the photo itself, and a session or light after --light")
    return read_photo(path)


def light_kind(text: str) -> str:
    """What L is: "rig", "panorama", "portrait" or "saved", a light or session of the editor's.

    Raises:
        InputError: neither a rig nor a file.
    """
    from app.engine.sources import LightSource
    from relight_core.lighting.rigs import rig_names

    kind = LightSource.named(text).kind
    if kind != "rig" and not os.path.lexists(text):
        raise InputError(_no_such_light(text, rig_names()))
    return "saved" if text.lower().endswith(".json") else kind


def light_files(text: str) -> list[Path]:
    """The files that L reads: none for a bundled rig, and for a saved light the picture it names, too.

    Raises:
        InputError: a saved light that can't be used.
    """
    if not os.path.exists(text):
        return []
    if light_kind(text) != "saved":
        return [Path(text)]
    from app.document.session_file import read_lent_light

    light = read_lent_light(Path(text)).saved.light
    return [Path(text), *([Path(light.name)] if light.source().is_from_file else [])]


def _no_such_light(text: str, rigs: list[str]) -> str:
    near = difflib.get_close_matches(text.lower().replace("_", "-").replace(" ", "-"), rigs, n=1)
    guess = f"did you mean {near[0]}? " if near else ""
    return (
        f"{text}: no bundled light and no file of that name; {guess}the bundled lights are "
        f"{', '.join(rigs)}, and an .hdr or .exr panorama or a portrait will do too"
    )
