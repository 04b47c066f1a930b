"""Questions and messages to the user, and wishes of the user to the window: plain records."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

_DIALOGS = ("open", "save", "folder")


@dataclass(frozen=True)
class Question:
    """A question with a few buttons; it waits in the viewport and blocks nothing.

    Attributes:
        key: identifies it; a new question of the same key replaces it.
        text: one or two plain sentences.
        choices: label and action of each button; Enter gives the newest question's first.
        calling_off: label of the choice that changes nothing, which Esc gives; empty if there is none.
    """

    key: str
    text: str
    choices: tuple[tuple[str, Callable[[], None]], ...]
    calling_off: str = ""


@dataclass
class FileRequest:
    """A file the user is asked for.

    Attributes:
        kind: "open" (one or more files), "save" (one that may not exist) or "folder".
        title: the dialog's title.
        start: the folder, or for "save" the file, to start from.
        suffixes: of the files to list, each with its dot; empty for all.
        then: called with the chosen paths, at least one; not called if the user cancels.
        text: what is typed in relight's own dialog.
        folder: the one that a path begins in that is not typed in full: where the dialog began, or that was clicked;
            empty for the current one.
        chosen: text that was filled in by clicking there, or the suggested name of a file to save.
        chosen_among: the text that the list was made for at that moment.
        row: selected row of the list there; 0 is the folder above, -1 the input line.
    """

    kind: str
    title: str
    start: Path
    then: Callable[[list[Path]], None]
    suffixes: Sequence[str] = ()
    text: str = ""
    folder: str = ""
    chosen: str = ""
    chosen_among: str = ""
    row: int = -1

    def __post_init__(self) -> None:
        if self.kind not in _DIALOGS:
            raise ValueError(f"no dialog of kind {self.kind!r}")
        self.text = self.text or str(self.start)
        if os.path.isabs(self.text):
            self.folder = os.path.dirname(self.text)
        if self.kind == "save":
            # Until a name is typed the whole folder is listed, not only files that begin like the suggested name.
            self.chosen, self.chosen_among = self.text, os.path.join(os.path.dirname(self.text), "")


@dataclass
class Asking:
    """What the window and the user ask each other.

    Attributes:
        wishes: what the window is to do after this frame: names of methods of app.window.deeds.Deeds.
        questions: open ones, oldest first.
        notices: messages to show, with whether each is an error.
        level: identifies the newest request to match the light's level to the face, while its picture is not there yet.
    """

    wishes: list[str] = field(default_factory=list)
    questions: list[Question] = field(default_factory=list)
    notices: list[tuple[str, bool]] = field(default_factory=list)
    level: object | None = None

    def wish(self, kind: str) -> None:
        """Ask the window to do something, as of `wishes`."""
        self.wishes.append(kind)

    def tell(self, text: str, is_error: bool = False) -> None:
        """Put a line into the status line, where it stays."""
        self.notices.append((text, is_error))

    def ask(self, question: Question) -> None:
        """Ask something."""
        self.drop(question.key)
        self.questions.append(question)

    def drop(self, key: str) -> None:
        """Take a question back."""
        self.questions = [question for question in self.questions if question.key != key]

    def answer(self, question: Question, index: int) -> None:
        """Give a question one of its answers, after which it is gone."""
        self.drop(question.key)
        question.choices[index][1]()

    def call_off(self) -> bool:
        """Give the newest question that has one its `calling_off` answer; False if there is no such question."""
        for question in reversed(self.questions):
            labels = [label for label, _ in question.choices]
            if question.calling_off in labels:
                self.answer(question, labels.index(question.calling_off))
                return True
        return False
