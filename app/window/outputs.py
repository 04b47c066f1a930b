"""Making files of pictures: export, copy, turntable, batch. The work itself runs as jobs on another thread."""

from __future__ import annotations

import logging
import os
import tempfile
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from app.document.document import Document
from app.engine.batch import Outcome, batch_tasks, reasons, relight_each, summary
from app.engine.exporting import (
    Exporter,
    ExportJob,
    ExportSettings,
    free_path,
    write_named,
)
from app.engine.film import write_film
from app.engine.jobs import JobControl
from app.engine.snapshot import Picture
from app.engine.sources import RelighterLike
from app.engine.turntable import FILM_PX, FRAMES, turning, write_pictures
from app.ui.export_name import form_named, place_for
from app.ui.photo_works import portrait_of
from app.ui.state import EditorState
from app.window.batch_photo import BatchLights, relight_as
from app.window.clipboard import copy_png
from app.window.last_export import LastExport
from app.window.own_work import document_of, own_work
from app.window.promise import Promise
from relight_core.errors import InputError
from relight_core.imaging.files import KnownFiles, legible
from relight_core.imaging.write import write_image
from relight_core.pipeline.results.layers import shrunk_picture

_log = logging.getLogger(__name__)


class Outputs:
    """Starts jobs from what the state holds now, once the picture of that is finished.

    Args:
        state: what is shown and set.
        exporter: runs the jobs.
        make_relighter: makes one for jobs that relight, so that the window's own stays free.
        when_finished: as of app.window.finished.Finished.then; None takes the picture that is there.
        folder: where it is kept how pictures were saved last; None keeps nothing.
    """

    def __init__(
        self,
        state: EditorState,
        exporter: Exporter,
        make_relighter: Callable[[], RelighterLike],
        when_finished: Callable[..., None] | None = None,
        folder: Path | None = None,
    ) -> None:
        self._state, self._exporter, self._make_relighter = state, exporter, make_relighter
        self._when_finished = when_finished or (lambda task, **_: task(state.snapshot.picture))
        # What each batch makes that has not ended; the jobs' thread takes it off.
        self._coming: list[list[Path]] = []
        self._last = LastExport(folder and folder / "last-export.json")
        self._last.recall(state)

    def export(self, suffix: str) -> None:
        """Save the picture where the panel says now, as a kind of file; nothing if there is no picture."""
        if self._state.snapshot.picture is not None:
            chosen, exposure_ev = self._state.export, self._state.edit.exposure_ev
            place = place_for(self._state, self._state.photo, suffix)

            def save(picture: Picture) -> None:
                self._exporter.submit(ExportJob(picture, exposure_ev, place, replace(chosen, form=suffix)))
                # Of another kind by a key of its own it is for once.
                self._last.keep(chosen)

            self._when_finished(save)

    def export_writer(self) -> Callable[[Path, bool], None]:
        """A function that saves the picture as wanted and set now, even if that changes before its place is known.

        A path with the suffix of another kind of picture makes a file of that kind.

        Raises:
            InputError: there is no picture.
        """
        self._need_picture()
        settings, exposure_ev, promise = self._state.export, self._state.edit.exposure_ev, self._promise()

        def save(path: Path, replaces: bool) -> None:
            named = replace(settings, form=form_named(path) or settings.form)

            def submit(picture: Picture) -> None:
                self._exporter.submit(ExportJob(picture, exposure_ev, path, named, replaces))
                self._last.keep(named)

            promise.then(submit)

        return save

    def copy_picture(self) -> None:
        """Put the picture on the clipboard, at its own size, 8 bits."""
        self._need_picture()
        exposure_ev = self._state.edit.exposure_ev

        def start(picture: Picture) -> None:
            def work(control: JobControl) -> str:
                with tempfile.TemporaryDirectory(prefix="relight-") as folder:
                    path = Path(folder) / "picture.png"
                    write_image(path, *shrunk_picture(picture.relit, None), exposure_ev=exposure_ev)
                    copy_png(path.read_bytes())
                return "Copied the picture"

            self._exporter.start("Copy", work)

        self._when_finished(start)

    def film_writer(self) -> Callable[[Path, bool], None]:
        """A function that saves the turntable of what is wanted now: an .mp4 file, or a new folder of pictures.

        Raises:
            InputError: there is no picture.
        """
        self._need_picture()
        chosen, exposure_ev, promise = self._state.export, self._state.edit.exposure_ev, self._promise()

        def save(path: Path, replaces: bool) -> None:
            def start(picture: Picture) -> None:
                self._start_film(path, replaces, picture, chosen.longest_side or FILM_PX, exposure_ev)
                self._last.keep(chosen)

            promise.then(start)

        return save

    def _promise(self) -> Promise:
        promise = Promise()
        self._when_finished(promise.keep, otherwise=promise.give_up)
        return promise

    def _start_film(self, wish: Path, replaces: bool, picture: Picture, side: int, exposure_ev: float) -> None:
        photo = picture.opened.photo
        wished = picture.opened.source.on(photo)
        light, edit = picture.light.environment, replace(picture.edit, exposure_ev=exposure_ev)

        def work(control: JobControl) -> str:
            relighter = self._make_relighter()
            relighter.set_portrait(photo, wished.face_index, wished.boxes, wished.strokes)
            control.step(0, FRAMES)
            is_film = wish.suffix.lower() == ".mp4"
            frames = turning(relighter, light, edit, side, for_film=is_film)
            if is_film:
                path = write_named(wish, replaces, lambda place: write_film(place, frames, FRAMES, control.step))
            else:
                # What was asked for before may have taken the name meanwhile.
                path = free_path(wish)
                write_pictures(path, frames, FRAMES, control.step, _write_frame)
            return f"Saved {legible(str(path))}"

        self._exporter.start("Turntable", work)

    @property
    def settings(self) -> ExportSettings:
        """How pictures are saved, as the panel says now."""
        return self._state.export

    def batch_over(
        self,
        photos: list[Path],
        folder: Path,
        replaces: bool = False,
        settings: ExportSettings | None = None,
        as_left: bool = False,
    ) -> None:
        """Relight photos like the open one, into a folder.

        Args:
            replaces: replace results that exist already; otherwise they are kept.
            settings: how to save; None is as the panel says now.
            as_left: relight each photo by its own work, if it has some.
        """
        self._need_picture()
        settings = settings or self._state.export
        works, originals = {photo: self._work_on(photo, as_left) for photo in photos}, KnownFiles(photos)
        tasks = batch_tasks(photos, folder, settings.form)
        coming = [output for _, output in tasks]
        self._coming.append(coming)

        def start(picture: Picture) -> None:
            lights = BatchLights(picture.light)

            def one(relighter: RelighterLike, photo: Path, output: Path) -> str | None:
                return relight_as(document_of(works[photo], photo), lights, relighter, output, settings, originals)

            self._start_batch(tasks, one, replaces, then=partial(self._coming.remove, coming))
            self._last.keep(settings)

        self._when_finished(start, otherwise=partial(self._coming.remove, coming))

    def _work_on(self, photo: Path, as_left: bool) -> Document | Path:
        own = own_work(self._state, photo) if as_left else None
        return own or replace(self._state.document(), photo=portrait_of(self._state, photo))

    def _start_batch(
        self,
        tasks: list[tuple[Path, Path]],
        one: Callable[[RelighterLike, Path, Path], str | None],
        replaces: bool,
        then: Callable[[], None],
    ) -> None:
        folder = tasks[0][1].parent

        def work(control: JobControl) -> str:
            try:
                return relight(control)
            finally:
                then()

        def relight(control: JobControl) -> str:
            _make_folder(folder)
            relighter = self._make_relighter()
            # Asked again when its turn comes: another window may make it meanwhile, and nobody agreed to replace that.
            kept_if = None if replaces else lambda _, output: os.path.lexists(output)
            kept = [task for task in tasks if kept_if and kept_if(*task)]
            outcomes = [Outcome(*task, "kept") for task in kept]
            control.step(len(kept), len(tasks), len(kept))
            left = [task for task in tasks if task not in kept]
            for outcome in relight_each(left, partial(one, relighter), kept_if):
                outcomes.append(outcome)
                if outcome.fault:
                    _log.error("Batch: %s\n%s", outcome.error, outcome.fault)
                control.step(len(outcomes), len(tasks), sum(outcome.state == "kept" for outcome in outcomes))
            said = legible(f"{summary(outcomes)}. They are in {folder}")
            notes = [outcome.result for outcome in outcomes if outcome.result]
            if any(outcome.state == "failed" for outcome in outcomes):
                raise InputError(said, *reasons(outcomes), *notes)
            return "\n".join([said, *notes])

        self._exporter.start("Batch", work)

    def done_already(self, photos: list[Path], folder: Path) -> tuple[int, int]:
        """How many of the photos have a picture in the folder, and how many others get one by an earlier batch."""
        coming = {output for outputs in self._coming.copy() for output in outputs}
        outputs = [output for _, output in batch_tasks(photos, folder, self._state.export.form)]
        missing = [output for output in outputs if not os.path.lexists(output)]
        return len(outputs) - len(missing), sum(output in coming for output in missing)

    def suggested(self, suffix: str, ending: str = "") -> Path:
        """A free name, beside the photo, for an output of what is wanted now, be that photo open yet or not."""
        path = place_for(self._state, self._state.photo, self._state.export.form)
        return free_path(path.with_name(f"{path.stem}{ending}{suffix}"))

    def _need_picture(self) -> None:
        if self._state.snapshot.picture is None:
            raise InputError("There is no relit picture yet; open a photo first")


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: can't be made ({error.strerror}); choose another folder") from error


def _write_frame(path: Path, frame: np.ndarray) -> None:
    from relight_core.imaging.photo import Photo

    alpha = frame[..., 3].astype(np.float32) / 255 if frame.shape[2] == 4 else None
    write_image(path, Photo.from_srgb(frame[..., :3]).linear, alpha)
