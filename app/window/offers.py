"""Questions about work that is there already: of a saved session, of this run, of a run that was not closed."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from app.document.autosave import Leftover
from app.ui.asking import Question
from app.ui.open_work import KeptWork

Deed = Callable[[], None]


def saved_session_offer(photo: Path, saved: Path, resume: Deed, start_afresh: Deed) -> Question:
    """About the session file of a photo that was opened."""
    where = " beside it" if saved.parent == photo.absolute().parent else f", {saved}"
    choices = (("Continue", resume), ("Start afresh", start_afresh))
    return Question("session", f"{photo.name} has a saved session{where}.", choices)


def work_of_this_run_offer(work: KeptWork, resume: Deed, start_afresh: Deed) -> Question:
    """About a photo that came back with the settings of the one before."""
    where = f", saved in {work.session_path}" if work.session_path else ""
    text = f"{work.left.photo.path.name} has work of its own{where}; now it has the settings of the photo before."
    return Question("session", text, (("Continue", resume), ("Start afresh", start_afresh)))


def leftover_offer(leftover: Leftover, restore: Deed, discard: Deed) -> Question:
    """About work that relight ended without saving."""
    when = time.strftime("%H:%M on %d %B", time.localtime(leftover.saved_s))
    text = f"Your work on {leftover.document.photo.path.name}, of {when}, was not saved before relight ended."
    text = " ".join([text, *(f"{note[0].upper()}{note[1:]}." for note in leftover.notes)])
    return Question(f"leftover {leftover.path.name}", text, (("Restore", restore), ("Discard", discard)))
