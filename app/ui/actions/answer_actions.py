"""The answers to what is asked, and Cancel of long work, as commands, for the palette alone: there are few of them."""

from __future__ import annotations

from app.engine.jobs import JobStatus
from app.ui.actions.action import Action
from app.ui.asking import Question
from app.ui.state import EditorState
from relight_core.imaging.files import legible


def answer_actions(state: EditorState) -> tuple[Action, ...]:
    """One for each answer that can be given now; the question asked last comes first, and what runs after them."""
    questions = reversed(state.asking.questions)
    answers = (_give(question, index) for question in questions for index in range(len(question.choices)))
    job = state.job
    return (*answers, *([_cancel(job)] if job is not None and not job.cancelling else []))


def _give(question: Question, index: int) -> Action:
    def run(state: EditorState) -> None:
        state.asking.answer(question, index)

    label = question.choices[index][0]
    return Action(f"Answer: {label}", "Questions", (), legible(question.text).rstrip("."), run)


def _cancel(job: JobStatus) -> Action:
    def run(state: EditorState) -> None:
        state.cancel_wanted = job

    return Action(f"Cancel: {job.name}", "Questions", (), "Stops it; what is half done is taken away", run)
