"""Keeps what the user arranged from one run to the next."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

from app.settings import Looking, Settings, read_settings, write_settings
from app.ui.state import EditorState


class Memory:
    """The settings file and what it holds now.

    Args:
        path: the file; None remembers nothing.
    """

    def __init__(self, path: Path | None) -> None:
        self._path = path
        self._kept = read_settings(path) if path else Settings()

    @property
    def window_size(self) -> tuple[int, int] | None:
        """The last window's size, in units of the design."""
        return self._kept.window_size

    def recall(self, state: EditorState) -> None:
        """Put the remembered arrangement into the state; a window without any panel would tell nobody what to do."""
        kept = self._kept.panels
        state.panels, state.groups = kept if kept.any_shown else kept.all_shown(True), self._kept.groups
        for entry in fields(Looking):
            setattr(state.look, entry.name, getattr(self._kept.looking, entry.name))

    def keep(self, state: EditorState, window_size: tuple[int, int]) -> None:
        """Write the arrangement if it is another one than was written last."""
        now = Settings(state.panels, Looking.of(state.look), tuple(window_size), state.groups)
        if self._path is not None and now != self._kept:
            # Remembered even where writing fails, so that a full disk is told once and not in every frame.
            self._kept = now
            write_settings(self._path, now)
