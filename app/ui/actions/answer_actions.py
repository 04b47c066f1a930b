"""The answers to what is asked as commands, for the palette alone: only while a question is open there are any."""

from __future__ import annotations

from app.ui.actions.action import Action
from app.ui.asking import Question
from app.ui.state import EditorState
from relight_core.imaging.files import legible


def answer_actions(state: EditorState) -> tuple[Action, ...]:
    """One for each answer that can be given now; the question asked last comes first."""
    questions = reversed(state.asking.questions)
    return tuple(_give(question, index) for question in questions for index in range(len(question.choices)))


def _give(question: Question, index: int) -> Action:
    def run(state: EditorState) -> None:
        state.asking.answer(question, index)

    label = question.choices[index][0]
    return Action(f"Answer: {label}", "Questions", (), legible(question.text).rstrip("."), run)
