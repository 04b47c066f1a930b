"""An editor without a window and an engine, for what a state and its deeds do together."""

from __future__ import annotations

from dataclasses import replace

from opened_things import open_light, opened_for

from app.ui.file_dialogs import FileDialogs
from app.ui.state import EditorState
from app.window.deeds import Deeds


class Editor:
    """A state whose every wish for a photo or a light comes true at once, and the deeds that go with it."""

    def __init__(self, folder, state=None, outputs=None):
        self.state = state or EditorState()
        self.said = []
        self.deeds = Deeds(
            self.state, lambda text, is_error: self.said.append((text, is_error)), folder, FileDialogs(False), outputs
        )
        self.now_s = 0.0

    def live(self, seconds=20):
        for _ in range(seconds):
            self.now_s += 1.0
            self._answer()
            self.state.remember(self.now_s)
            self.deeds.act(self.now_s)
        if self.deeds._recovery is not None:
            self.deeds._recovery.wait()

    def _answer(self):
        state, now = self.state, self.state.snapshot
        opened, light = now.opened, now.light
        if state.photo is not None and (opened is None or opened.source is not state.photo):
            opened = opened_for(state.photo)
        if light is None or not light.source.same_as(state.light):
            light = open_light(state.light)
        if (opened, light) != (now.opened, now.light):
            state.accept(replace(now, opened=opened, light=light))

    def answer_question(self, label, seconds=20):
        question = self.state.asking.questions[0]
        act = dict(question.choices)[label]
        self.state.asking.drop(question.key)
        act()
        self.live(seconds)


def unsaved_files(folder):
    return list((folder / "unsaved").glob("*.json")) if (folder / "unsaved").exists() else []
