"""What the panels ask of the window: files, dialogs, sessions. One method for each kind of wish."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from functools import partial
from pathlib import Path

from app.document.document import Document
from app.document.light_file import LIGHT_SUFFIX, SavedLight, write_light
from app.document.session_file import (
    SESSION_SUFFIX,
    free_session_path,
    holds_work,
    saved_session,
    session_path,
    write_session,
)
from app.engine.exporting import free_path
from app.engine.places import current_folder
from app.engine.snapshot import Picture
from app.engine.sources import PICTURE_SUFFIXES
from app.faults import error_line
from app.ui.asking import FileRequest
from app.ui.export_name import export_to, form_named, named_as
from app.ui.file_dialogs import FileDialogs
from app.ui.light_edits import match_face
from app.ui.open_work import KeptWork
from app.ui.photo_works import note_saved, resume, session_of_photo
from app.ui.state import EditorState
from app.window.batching import photos_beside, relight_as_left, relight_many
from app.window.dropped import take_files, use_as_light
from app.window.offers import saved_session_offer, work_of_this_run_offer
from app.window.outputs import Outputs
from app.window.recent_lights import RecentLights
from app.window.recovery import Recovery
from app.window.replacing import check_place, put_or_ask, tried, write_or_ask
from relight_core.errors import InputError
from relight_core.imaging.files import legible

_log = logging.getLogger(__name__)
_NOWHERE = (-1.0, -1.0)


class Deeds:
    """Carries out the wishes of a state.

    Args:
        state: whose wishes.
        say: tells a line, and whether it is an error.
        folder: where unsaved work and recent lights are kept; None keeps neither.
        dialogs: the file dialogs.
        outputs: makes files of pictures.
        when_finished: as of app.window.finished.Finished.then; None takes the picture that is there.
    """

    def __init__(
        self,
        state: EditorState,
        say: Callable[[str, bool], None],
        folder: Path | None,
        dialogs: FileDialogs | None = None,
        outputs: Outputs | None = None,
        when_finished: Callable[..., None] | None = None,
    ) -> None:
        self._state, self._say = state, say
        self._dialogs = dialogs or FileDialogs()
        self._outputs = outputs
        self._when_finished = when_finished or (lambda run, *_, **__: run(state.snapshot.picture))
        self._recent = RecentLights(folder / "recent-lights.json") if folder else None
        self._recovery = Recovery(state, folder / "unsaved") if folder else None
        self._photo: object | None = None
        if self._recent is not None:
            self._recent.recall(state)

    @property
    def waiting(self) -> bool:
        """Whether `act` has to be called now and then although nothing happens."""
        return self._dialogs.waiting or (self._recovery is not None and self._recovery.due)

    def act(self, now_s: float) -> None:
        """Do what was asked for in this frame, and look after unsaved work."""
        asking = self._state.asking
        wishes, asking.wishes = asking.wishes, []
        for wish in wishes:
            self._attempt(wish, getattr(self, wish))
        self._attempt("file dialog", self._dialogs.poll)
        self._look_for_a_session()
        if self._recent is not None:
            self._recent.keep(self._state)
        if self._recovery is not None:
            self._recovery.keep(now_s)
        notices, asking.notices = asking.notices, []
        for text, is_error in notices:
            self._say(text, is_error)

    def keep_now(self) -> bool:
        """Write unsaved work at once and wait for it; False if there is none, or no place to keep it."""
        return self._recovery is not None and self._recovery.keep_now()

    def would_lose_work(self) -> bool:
        """Whether there is unsaved work, on whichever photo, that can't be kept for the next start."""
        self.keep_now()
        return self._recovery is not None and self._recovery.fails

    def close(self) -> None:
        """Let go of everything; unsaved work stays in its file. Safe to call twice."""
        self._dialogs.close()
        if self._recovery is not None:
            self._recovery.close()

    def open_file(self) -> None:
        """Choose files to open, as if they were dropped on the picture."""
        suffixes = (*PICTURE_SUFFIXES, ".json")
        self._ask("open", "Open a photo, a light or a session", suffixes, self._take)

    def open_light(self) -> None:
        """Choose a light."""
        self._ask("open", "Open a light", (*PICTURE_SUFFIXES, ".json"), lambda paths: self._take_light(paths[0]))

    def save_session(self) -> None:
        """Save to the session's file; the first time beside the photo."""
        document, start, save = self._session_saver()
        self._put_or_ask(document, lambda: save(start))

    def save_session_as(self) -> None:
        """Choose where to save the session."""
        document, start, save = self._session_saver()
        self._put_or_ask(document, lambda: self._ask_place("Save the session", start, SESSION_SUFFIX, save))

    def save_light(self) -> None:
        """Choose where to save the light alone."""
        document = self._state.document()
        if document.light.kind == "own":
            raise InputError("The photo's own light belongs to that photo; save the session instead")
        saved = SavedLight(document.light, document.light_edit, document.edit.yaw_deg)

        def write(path: Path) -> None:
            check_place(path, "light")
            write_light(path, saved)
            self._state.asking.tell(f"Saved {legible(str(path))}")

        start = self._folder() / f"{document.light.source().title.lower().replace(' ', '-')}{LIGHT_SUFFIX}"
        free = partial(free_path, ending=LIGHT_SUFFIX)
        self._ask_place("Save the light", start, LIGHT_SUFFIX, lambda path: self._write_or_ask(path, write, free))

    def export_as(self) -> None:
        """Choose where to save the picture as it is now, whichever photo is open by the time the place is known."""
        form, write = self._state.export.form, self._outputs.export_writer()
        photo = self._state.photo

        def save_there(paths: list[Path]) -> None:
            path = named_as(paths[0], form_named(paths[0]) or form)
            opened = self._state.snapshot.opened
            if opened is not None and opened.source.path == photo.path:
                export_to(self._state, path)
            write_or_ask(self._state.asking, path, write)

        self._ask("save", "Export the picture", (form,), save_there, self._outputs.suggested(form))

    def copy_picture(self) -> None:
        """Put the picture on the clipboard."""
        self._outputs.copy_picture()

    def turntable_film(self) -> None:
        """Choose where to save the turning light as a film."""
        start, write = self._outputs.suggested(".mp4", "-turntable"), self._outputs.film_writer()
        asking = self._state.asking
        self._ask_place("Save the turntable as a film", start, ".mp4", lambda path: write_or_ask(asking, path, write))

    def turntable_pictures(self) -> None:
        """Save the turning light as numbered pictures in a new folder beside the photo."""
        self._outputs.film_writer()(self._outputs.suggested("", "-turntable"), False)

    def match_face(self) -> None:
        """Set the light's level by the face, once the picture under the light as it is now is there."""
        if self._state.snapshot.picture is None:
            return
        asking = self._state.asking
        asking.level = wish = object()

        def give_up() -> None:
            asking.level = None if asking.level is wish else asking.level

        def match(picture: Picture) -> None:
            if asking.level is wish:
                match_face(self._state, picture)
            give_up()

        self._when_finished(match, makes_file=False, otherwise=give_up)

    def batch(self) -> None:
        """Relight the queue's other photos, or those of a folder, as this one is."""
        queue = self._state.queue.paths
        if len(queue) > 1:
            self._batch_over(list(queue))
        else:
            self._ask("folder", "Relight all photos of a folder like this one", (), self._batch_there)

    def batch_as_left(self) -> None:
        """Relight each of the queue's photos as it was left."""
        relight_as_left(self._state, self._outputs)

    def _attempt(self, name: str, deed: Callable[[], None]) -> None:
        try:
            deed()
        except InputError as error:
            self._state.asking.tell(str(error), True)
        except Exception as error:
            _log.error("%s failed", name, exc_info=error)
            self._state.asking.tell(error_line(error), True)

    def _ask(
        self,
        kind: str,
        title: str,
        suffixes: tuple[str, ...],
        then: Callable[[list[Path]], None],
        start: Path | None = None,
    ) -> None:
        folder = os.path.join(self._folder(), "")
        request = FileRequest(kind, title, start or Path(folder), then, suffixes, "" if start else folder)
        self._state.picking = self._dialogs.ask(request) or self._state.picking

    def _folder(self) -> Path:
        photo = self._state.document().photo
        return photo.path.absolute().parent if photo else current_folder()

    def _ask_place(self, title: str, start: Path, suffix: str, then: Callable[[Path], None]) -> None:
        """Ask for one file to write, whose name gets the suffix where it has none like it."""
        self._ask("save", title, (suffix,), lambda paths: then(named_as(paths[0], suffix)), start)

    def _write_or_ask(
        self, path: Path, write: Callable[[Path], None], free: Callable[[Path], Path] = free_path, there: str = ""
    ) -> None:
        write_or_ask(self._state.asking, path, lambda chosen, _: write(chosen), free, there)

    def _put_or_ask(self, document: Document, put: Callable[[], None]) -> None:
        put_or_ask(self._state, document, "what is set", put, lambda: None)

    def _batch_there(self, paths: list[Path]) -> None:
        self._tried(lambda folder: self._batch_over(photos_beside(folder, self._state.light)), paths[0])

    def _batch_over(self, photos: list[Path]) -> None:
        relight_many(photos, self._outputs, self._state.asking)

    def _take(self, paths: list[Path]) -> None:
        take_files(self._state, paths, *_NOWHERE)

    def _take_light(self, path: Path) -> None:
        self._tried(lambda chosen: use_as_light(self._state, chosen), path)

    def _session_saver(self) -> tuple[Document, Path, Callable[[Path], None]]:
        """The work as it is now, where its session goes by itself, and what saves it, whichever photo is open by then.

        It asks before it replaces anything but the session's own file, and that, too, where other work was put there.

        Raises:
            InputError: there is no photo.
        """
        document = self._state.document()
        if document.photo is None:
            raise InputError("There is no photo to save a session of; open one first")
        photo = document.photo.path
        own, held = session_of_photo(self._state) or (None, None)

        def write(path: Path) -> None:
            self._write_session(path, document)

        def save(path: Path) -> None:
            if path == own and holds_work(path, held):
                self._tried(write, path)
                return
            there = f"{path.name} holds other work than it did when it was opened or saved here." if path == own else ""
            self._write_or_ask(path, write, lambda taken: free_session_path(taken, photo), there)

        return document, own or session_path(photo), save

    def _write_session(self, path: Path, document: Document) -> None:
        check_place(path, "session")
        state = self._state
        write_session(path, document)
        note_saved(state, path, document)
        if self._recovery is not None:
            self._recovery.forget_saved(document)
        state.asking.tell(f"Saved {legible(str(path))}")

    def _tried(self, act: Callable[[Path], None], path: Path) -> None:
        tried(self._state.asking, lambda: act(path))

    def _look_for_a_session(self) -> None:
        """Offer the work of its own that a photo has: of this run, else the session that lies beside it."""
        opened = self._state.snapshot.opened
        if opened is None or opened.photo is self._photo:
            return
        self._photo = opened.photo
        self._state.asking.drop("session")
        path = opened.source.path
        if self._state.waiting is not None:
            self._offer_work_of_this_run(self._state.waiting)
            return
        if path is None or self._state.session_path is not None or self._state.kept != self._state.document():
            return
        saved = saved_session(path)
        if saved is None:
            return

        def start_afresh() -> None:
            self._state.started_afresh.add(path.absolute())

        self._state.asking.ask(saved_session_offer(path, saved, lambda: self._take([saved]), start_afresh))

    def _offer_work_of_this_run(self, work: KeptWork) -> None:
        def start_afresh() -> None:
            if self._state.waiting is work:
                self._state.waiting = None

        def go_on() -> None:
            self._put_or_ask(work.left, lambda: resume(self._state, work))

        self._state.asking.ask(work_of_this_run_offer(work, go_on, start_afresh))
