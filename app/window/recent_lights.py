"""The panoramas and portraits whose light was used last, from one run to the next."""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Iterable
from pathlib import Path

from app.engine.sources import LIGHTS_FROM_FILES, LightSource
from app.ui.state import EditorState
from relight_core.errors import InputError
from relight_core.imaging.files import file_bytes, whole_file

MOST = 12
_log = logging.getLogger(__name__)


class RecentLights:
    """A small file of lights; a damaged one counts as empty.

    Args:
        path: the file.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._by_use: list[tuple[str, str]] = []
        self._in_file: list[tuple[str, str]] = []
        self._of_others: list[tuple[str, str]] = []
        self._away: list[tuple[str, str]] = []

    def recall(self, state: EditorState) -> None:
        """Put the lights that are there into the list, newest first; one whose disk is away stays in the file."""
        self._in_file = read_recent(self._path)
        listed = _newest(self._in_file)
        there = [entry for entry in listed if os.path.isfile(entry[1])]
        self._away = [entry for entry in listed if entry not in there]
        self._by_use = there[:MOST]
        known = [LightSource(*entry) for entry in self._by_use]
        new = [light for light in known if not any(light.same_as(other) for other in state.extra_lights)]
        state.extra_lights = [*state.extra_lights, *new]

    def keep(self, state: EditorState) -> None:
        """Write the list if it is another one than was written last; what other windows have added stays in it."""
        listed = _newest((light.kind, light.name) for light in state.extra_lights if light.is_from_file)
        # In the panel none moves under the hand; what is kept begins with the one that was used last.
        shown = state.snapshot.light and state.snapshot.light.source
        used = _newest([(shown.kind, shown.name)] if shown and shown.is_from_file else [])
        new = [entry for entry in listed if entry not in self._by_use]
        before = self._by_use[:MOST]
        self._by_use = _newest(entry for entry in (*used, *new, *self._by_use) if entry in listed)
        now = self._by_use[:MOST]
        if now == before:
            return
        self._in_file = self._among_those_of_others(now, new)
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            with whole_file(self._path) as part:
                part.write_text(json.dumps(self._in_file, indent=1) + "\n", encoding="utf-8")
        except (OSError, InputError) as error:
            _log.warning("recent lights are not kept: %s", error)

    def _among_those_of_others(self, own: list[tuple[str, str]], new: list[tuple[str, str]]) -> list[tuple[str, str]]:
        """This window's lights with those that others have put into the file, newest first.

        What was in the file and is no longer this window's was taken out of its list, and goes; what was not there when
        the list was read was never in it, and stays.
        """
        added = [entry for entry in read_recent(self._path) if entry not in self._in_file]
        self._of_others = _newest([*added, *self._of_others])[:MOST]
        self._away = [entry for entry in self._away if entry not in own]
        kept = (*own, *self._of_others, *self._away)
        stays = [entry for entry in self._in_file if entry in kept]
        return _newest([*own[:1], *new, *added, *stays, *own])[:MOST]


def _newest(entries: Iterable[tuple[str, str]]) -> list[tuple[str, str]]:
    """Kind and file of each light, every file once."""
    return list(dict.fromkeys((kind, os.path.abspath(name)) for kind, name in entries))


def read_recent(path: Path) -> list[tuple[str, str]]:
    """Kind and name of each light in the file; none where it is damaged."""
    try:
        content = json.loads(file_bytes(path).decode("utf-8"))
    except (OSError, ValueError, RecursionError):
        return []
    entries = content if isinstance(content, list) else []
    pairs = [entry for entry in entries if isinstance(entry, list) and len(entry) == 2]
    return [
        (kind, name)
        for kind, name in pairs
        if kind in LIGHTS_FROM_FILES and isinstance(name, str) and "\0" not in name and name
    ]
