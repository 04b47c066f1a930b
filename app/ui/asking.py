"""What the program asks the user, what it tells, and what the user asks of the window: plain records."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

_DIALOGS = ("open", "save", "folder")


@dataclass(frozen=True)
class Question:
    """A line with a few buttons; it waits in the viewport and blocks nothing.

    Attributes:
        key: names it; asking the same again replaces it.
        text: one or two plain sentences.
        choices: label and what is done of each button; the first is the one that Enter gives.
        calling_off: the label of the one that changes nothing, which Esc gives, if there is one.
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
        title: what for.
        start: the folder, or for "save" the file, to start from.
        suffixes: of the files that are of use, each with its dot; none for all.
        then: given what was chosen, at least one path; not called when the user thought better of it.
        text: what is typed in our own dialog.
        chosen: the text that was clicked together there, or the suggested one of a file to save.
        chosen_among: what the list was made for then.
        row: of the list there, where the arrow keys have gone; 0 is the folder above, -1 the line that is typed in.
    """

    kind: str
    title: str
    start: Path
    then: Callable[[list[Path]], None]
    suffixes: Sequence[str] = ()
    text: str = ""
    chosen: str = ""
    chosen_among: str = ""
    row: int = -1

    def __post_init__(self) -> None:
        if self.kind not in _DIALOGS:
            raise ValueError(f"no dialog of kind {self.kind!r}")
        self.text = self.text or str(self.start)
        if self.kind == "save":
            # All of the folder is listed until a name is typed, not what is called like the file that is to be made.
            self.chosen, self.chosen_among = self.text, os.path.join(os.path.dirname(self.text), "")


@dataclass
class Asking:
    """The talk between the window and the user.

    Attributes:
        wishes: to be done after this frame, of what only the window can do: names of methods of app.window.deeds.Deeds.
        questions: open ones, oldest first.
        notices: lines to tell, with whether each is an error.
        level: names the newest wish for a light's level that its picture has to tell and does not yet, if any.
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
        """Answer the newest question that can be called off with just that; False where there is none."""
        for question in reversed(self.questions):
            labels = [label for label, _ in question.choices]
            if question.calling_off in labels:
                self.answer(question, labels.index(question.calling_off))
                return True
        return False
