"""How pictures were saved last, from one run to the next."""

from __future__ import annotations

import json
import logging
from dataclasses import asdict
from pathlib import Path

from app.engine.exporting import FORMS, PROFILES, QUALITIES, SIDES, ExportSettings
from app.ui.state import EditorState
from relight_core.errors import InputError
from relight_core.imaging.files import file_bytes, whole_file
from relight_core.pipeline.results.layers import LAYERS

_log = logging.getLogger(__name__)


class LastExport:
    """A small file of settings; whatever of it is damaged or unknown counts as not set.

    It is no part of app.settings, which a window writes as a whole when it rests or closes: the settings of one window
    would then replace those that another one saved a picture with since.

    Args:
        path: the file; None remembers nothing.
    """

    def __init__(self, path: Path | None) -> None:
        self._path = path

    def recall(self, state: EditorState) -> None:
        """Let the next picture be saved as the last one was."""
        if self._path is not None:
            state.export = read_last_export(self._path)

    def keep(self, settings: ExportSettings) -> None:
        """Write the settings of a picture that is being saved, unless they are in the file; the newest window wins."""
        if self._path is None or read_last_export(self._path) == settings:
            return
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            with whole_file(self._path) as part:
                part.write_text(json.dumps(asdict(settings), indent=2) + "\n", encoding="utf-8")
        except (OSError, InputError) as error:
            _log.warning("how pictures were saved is not kept: %s", error)


def read_last_export(path: Path) -> ExportSettings:
    """The settings in a file; the defaults for whatever is missing, damaged or not to be chosen here."""
    try:
        content = json.loads(file_bytes(path).decode("utf-8"))
    except (OSError, ValueError, RecursionError):
        return ExportSettings()
    if not isinstance(content, dict):
        return ExportSettings()
    kept = {name: content[name] for name, fits in _FITTING.items() if name in content and fits(content[name])}
    if isinstance(listed := content.get("layers"), list):
        kept["layers"] = tuple(name for name in LAYERS if name in listed)
    return ExportSettings(**kept)


def _is_quality(value: object) -> bool:
    low, high = QUALITIES
    return type(value) is int and low <= value <= high


_FITTING = {
    "form": lambda value: value in FORMS,
    "deep": lambda value: isinstance(value, bool),
    "quality": _is_quality,
    "longest_side": lambda value: value is None or (type(value) is int and value in SIDES),
    "profile": lambda value: value in PROFILES,
}
