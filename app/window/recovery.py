"""Unsaved work: kept while it changes, and what earlier runs have left of it offered."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from app.document.autosave import Autosave, Leftover, leftovers
from app.document.document import Document
from app.engine.sources import PhotoSource
from app.ui.open_work import KeptWork
from app.ui.photo_works import is_waiting
from app.ui.state import EditorState
from app.window.offers import leftover_offer
from app.window.replacing import put_or_ask

_OFFERS = 3
"""Questions about unsaved work that are asked at a time."""


class Recovery:
    """Keeps the work of a state that no session file holds, and asks about the work that was kept before.

    Args:
        state: whose work.
        folder: where it is kept.
    """

    def __init__(self, state: EditorState, folder: Path) -> None:
        self._state = state
        self._pool = ThreadPoolExecutor(max_workers=1, thread_name_prefix="relight-autosave")
        self._autosave = Autosave(folder, self._pool.submit)
        self._restoring: tuple[PhotoSource, Leftover] | None = None
        self._restored: list[Leftover] = []
        self._seen: dict[Path, KeptWork] = {}
        self._closed = False
        self._told_problem: str | None = None
        self._unoffered = leftovers(folder, lambda line: state.asking.tell(line, True))
        for _ in range(_OFFERS):
            self._offer_next()

    @property
    def due(self) -> bool:
        """Whether something still waits to be written, so that `keep` has to be called now and then."""
        return self._autosave.due

    @property
    def fails(self) -> bool:
        """Whether there is work, on whichever photo, that could not be written."""
        return self._autosave.fails

    def keep(self, now_s: float) -> None:
        """Look at the work, once a frame."""
        # During a drag, too: a key may open the next photo while the hand still holds a slider.
        self._update(now_s)
        problem = self._autosave.problem
        if problem != self._told_problem:
            self._told_problem = problem
            if problem is not None:
                self._state.asking.tell(f"Unsaved work is not kept for recovery: {problem}", True)
        self._look_after_restored()

    def keep_now(self) -> bool:
        """Write unsaved work at once and wait for it; False if there is none, or it could not be written."""
        self._update(time.monotonic())
        self._autosave.try_again()
        self.wait()
        return self._autosave.keeps

    def wait(self) -> None:
        """Block until all that was given is written, or could not be."""
        self._pool.submit(lambda: None).result()

    def forget_saved(self, document: Document) -> None:
        """A session file holds this document: neither it nor what it was restored from need be kept."""
        self._autosave.note_saved(document)
        saved = [leftover for leftover in self._restored if leftover.document.photo.path == document.photo.path]
        for leftover in saved:
            self._restored.remove(leftover)
            self._pool.submit(leftover.forget)

    def close(self) -> None:
        """Let go of everything; unsaved work stays in its file. Safe to call twice."""
        if not self._closed:
            self._update(time.monotonic())
            self._autosave.flush()
            self._look_after_restored()
            self._autosave.close()
        self._closed = True
        self._pool.shutdown(wait=True)

    def _update(self, now_s: float) -> None:
        """While another photo than the one that is open is wanted, nothing that is set is work on either.

        What was kept of a photo that came back with other settings stays, too, until it is worked on.
        """
        self._give_what_was_left(now_s)
        if self._state.is_at_work() and not is_waiting(self._state):
            self._autosave.update(self._state.document(), self._state.is_unsaved(), now_s)
        else:
            self._autosave.flush()

    def _give_what_was_left(self, now_s: float) -> None:
        """A photo may have been left in the same frame as it was changed, so that nobody has looked at that change."""
        for photo, work in self._state.works.items():
            if self._seen.get(photo) is not work:
                self._seen[photo] = work
                if work.left != work.document:
                    self._autosave.update(work.left, True, now_s)
                    self._autosave.flush()

    def _offer_next(self) -> None:
        if self._unoffered:
            self._offer(self._unoffered.pop(0))

    def _offer(self, leftover: Leftover) -> None:
        def put() -> None:
            self._state.open_session(leftover.document, None)
            self._look_after_restored()
            self._restoring = self._state.photo, leftover
            self._offer_next()

        def restore() -> None:
            put_or_ask(self._state, leftover.document, leftover.path.name, put, lambda: self._offer(leftover))

        def discard() -> None:
            leftover.forget()
            self._offer_next()

        self._state.asking.ask(leftover_offer(leftover, restore, discard))

    def _look_after_restored(self) -> None:
        """Forget work that was restored once it is kept anew; offer it again where its photo did not open."""
        if self._restoring is not None:
            wish, leftover = self._restoring
            opened = self._state.snapshot.opened
            if opened is not None and opened.source is wish:
                self._restored.append(leftover)
                self._restoring = None
            elif self._state.photo is not wish:
                self._offer(leftover)
                self._restoring = None
        if self._autosave.due:
            # What was given of that photo may still be the work before.
            return
        given = [leftover for leftover in self._restored if self._autosave.is_given(leftover.document.photo.path)]
        for leftover in given:
            self._restored.remove(leftover)
            self._pool.submit(self._forget_if_kept, leftover)

    def _forget_if_kept(self, leftover: Leftover) -> None:
        """Called once the writing is over: only then is the work in a file of our own."""
        if self._autosave.holds(leftover.document.photo.path):
            leftover.forget()
