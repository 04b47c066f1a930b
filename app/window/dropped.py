"""What a file is for that was dropped, or named on the command line."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path

from app.document.json_fields import kind_of
from app.document.session_file import read_lent_light, read_session
from app.engine.batch import photos_in
from app.engine.sources import PHOTO_SUFFIXES, LightSource
from app.ui.photo_queue import PhotoQueue
from app.ui.state import EditorState
from app.window.replacing import put_or_ask
from relight_core.errors import InputError
from relight_core.imaging.files import is_same_file, legible
from relight_core.imaging.formats.exr import exr_size
from relight_core.imaging.formats.raster import RAW_SUFFIXES

_USABLE = "a photo (JPEG, PNG, TIFF, HEIC, WebP, EXR, raw), a panorama (.hdr, .exr) or a session"


def take_files(state: EditorState, paths: Sequence[Path], x: float, y: float, as_light: bool = False) -> None:
    """Open dropped files: photos as portraits, the first panorama as the light, a session as it was saved.

    On the light panel, or `as_light`, the first file is a light: a portrait there lends the one it was taken in.
    Several photos, or a folder of them, become a queue; beside a session they wait while its photo opens. What can't
    be used is told; the rest stays as it is.

    Args:
        x, y: where they were dropped, in window units.
    """
    x0, y0, x1, y1 = state.light_panel
    try:
        if as_light or (x0 <= x < x1 and y0 <= y < y1):
            use_as_light(state, paths[0])
            _tell(state, _left_out(paths[1:], "open one light at a time"))
        else:
            _open(state, paths)
    except InputError as error:
        state.asking.tell(str(error), True)


def open_named(state: EditorState, paths: Sequence[Path], light: str | None) -> None:
    """Open what the command line names: one file as a photo, all else as if it were dropped, and then the light.

    Args:
        light: a rig's name or a file; it takes the place of a session's light.
    """
    is_one_photo = len(paths) == 1 and paths[0].suffix.lower() != ".json" and not os.path.isdir(paths[0])
    try:
        if is_one_photo:
            state.open_photo(paths[0])
        elif paths:
            _open(state, paths, light is not None)
        if light is not None:
            _use_named_light(state, light)
    except InputError as error:
        state.asking.tell(str(error), True)


def _use_named_light(state: EditorState, light: str) -> None:
    if light.lower().endswith(".json"):
        use_as_light(state, Path(light))
    else:
        state.choose_light(LightSource.named(light))


def use_as_light(state: EditorState, path: Path) -> None:
    """Make a file the light: a panorama, a portrait to borrow from, a light file, or a session's light.

    Raises:
        InputError: a folder, or a light file or session that can't be read.
    """
    if os.path.isdir(path):
        raise InputError(f"{path}: is a folder; drop a panorama or a portrait on the light panel")
    if path.suffix.lower() == ".json":
        saved = read_lent_light(path).saved
        state.use_light(saved.light, saved.light_edit, saved.yaw_deg)
        _tell_notes(state, path, saved.notes)
    else:
        state.open_light(LightSource.named(str(path)))


def open_session(
    state: EditorState, path: Path, light_follows: bool = False, then: Callable[[], None] = lambda: None
) -> None:
    """Open a session file, under the first light where its own can't be had; asks where unsaved work would be replaced.

    The file goes on naming that light then: saving asks before it replaces it.

    Args:
        light_follows: another light takes the place of the session's, so that none stands in for it.
        then: called once it was asked for, which is never where the user keeps the work that is there.

    Raises:
        InputError: it can't be read, or its photo isn't there.
    """
    session = read_session(path)

    def put() -> None:
        state.open_session(session.document, None if session.lost_light else path)
        _tell_notes(state, path, session.told(light_follows))
        then()

    put_or_ask(state, session.document, str(path), put, lambda: None)


def _open(state: EditorState, paths: Sequence[Path], light_follows: bool = False) -> None:
    files, notes = _files(paths)
    ours = [path for path in files if path.suffix.lower() == ".json"]
    lights = [path for path in files if path not in ours and is_panorama(path)]
    photos = [path for path in files if path not in ours and path not in lights]
    if len(files) > 1:
        # Photo libraries put notes of their own beside every photo.
        foreign = [path for path in ours if kind_of(path) is None]
        ours = [path for path in ours if path not in foreign]
        notes += _left_out(foreign, f"relight opens {_USABLE}")
    if len(photos) > 1:
        odd = [path for path in photos if path.suffix.lower() not in PHOTO_SUFFIXES + RAW_SUFFIXES]
        photos = [path for path in photos if path not in odd]
        notes += _left_out(odd, f"relight opens {_USABLE}")
    notes += _left_out(ours[1:], "open one session or light file at a time")
    notes += _left_out(lights[1:], "open one panorama at a time")
    _tell(state, notes)
    session = next((path for path in ours[:1] if kind_of(path) != "light"), None)

    def open_rest() -> None:
        if lights:
            state.open_light(LightSource.named(str(lights[0])))
        if photos and session is not None:
            state.queue = _queue_with(state.photo.path, photos)
        elif photos:
            state.open_photos(photos)

    if session is not None:
        open_session(state, session, light_follows or bool(lights), open_rest)
        return
    if ours:
        use_as_light(state, ours[0])
    open_rest()


def _queue_with(opened: Path, photos: Sequence[Path]) -> PhotoQueue:
    """The photos as a queue in which the one that is opened has its place, at the front if it is none of them."""
    paths = [opened if is_same_file(path, opened) else path for path in photos]
    paths = paths if opened in paths else [opened, *paths]
    return PhotoQueue(tuple(paths), paths.index(opened))


def _files(paths: Sequence[Path]) -> tuple[list[Path], list[str]]:
    """The files, with those in folders, each once, and why folders were left out.

    Raises:
        InputError: no file is left.
    """
    files: list[Path] = []
    notes = []
    for path in paths:
        try:
            files += photos_in(path) if os.path.isdir(path) else [path]
        except InputError as error:
            if len(paths) == 1:
                raise
            notes.append(str(error))
    if not files:
        raise InputError(". ".join(notes))
    once: dict[str, Path] = {}
    for path in files:
        once.setdefault(os.path.abspath(path), path)
    return list(once.values()), notes


def _left_out(paths: Sequence[Path], what_to_do: str) -> list[str]:
    more = f" and {len(paths) - 1} more" if len(paths) > 1 else ""
    return [f"{paths[0].name}{more} left out; {what_to_do}"] if paths else []


def _tell(state: EditorState, notes: Sequence[str]) -> None:
    """All in one message, since the status line shows the newest alone."""
    if notes:
        state.asking.tell(legible(". ".join(notes)), True)


def _tell_notes(state: EditorState, path: Path, notes: Sequence[str]) -> None:
    if notes:
        state.asking.tell(legible(f"{path.name}: {'; '.join(notes)}"), True)


def is_panorama(path: Path) -> bool:
    """Whether a file is a light: .hdr always, .exr if it is twice as wide as high."""
    suffix = path.suffix.lower()
    if suffix != ".exr":
        return suffix == ".hdr"
    try:
        width, height = exr_size(path)
    except InputError:
        return False
    return width == 2 * height
