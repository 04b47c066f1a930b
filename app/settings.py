"""What is remembered between runs: the panels, what is switched on for looking, the window's size.

One JSON file in the user's configuration folder. A file that is damaged, or written by another version, never
stops the program: every value that is not what it should be is the default instead.
"""

from __future__ import annotations

import json
import logging
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path

from app.ui.layout import EDGES, SIDE_EM, STRIP_EM, OpenGroups, Panels
from app.ui.look import SCOPES, LookState
from app.user_folders import config_folder
from relight_core.errors import InputError
from relight_core.imaging.files import file_bytes, whole_file

VERSION = 1
_LIMITS = {"light_em": SIDE_EM, "effects_em": SIDE_EM, "filmstrip_em": STRIP_EM}
_WORDS = {"scope": SCOPES} | {f"{name}_at": edges for name, edges in EDGES.items()}
_SIZE_LIMITS = (200, 20000)
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Looking:
    """The part of app.ui.look.LookState that is remembered."""

    scope: str = LookState.scope
    light_ball: bool = LookState.light_ball
    timings: bool = LookState.timings
    probe: bool = LookState.probe

    @classmethod
    def of(cls, look: LookState) -> Looking:
        """What is to be remembered of it."""
        return cls(**{entry.name: getattr(look, entry.name) for entry in fields(cls)})


@dataclass(frozen=True)
class Settings:
    """Everything that is remembered; window_size is in units of the design, None for the first one."""

    panels: Panels = field(default_factory=Panels)
    looking: Looking = field(default_factory=Looking)
    window_size: tuple[int, int] | None = None
    groups: OpenGroups = field(default_factory=OpenGroups)


def settings_path() -> Path:
    """The file the editor keeps its settings in."""
    return config_folder() / "settings.json"


def read_settings(path: Path) -> Settings:
    """The settings in a file; the defaults for whatever is missing, damaged or out of range."""
    try:
        content = json.loads(file_bytes(path).decode("utf-8"))
    except (OSError, ValueError, RecursionError):
        return Settings()
    if not isinstance(content, dict) or content.get("version") != VERSION:
        return Settings()
    return Settings(
        _checked(Panels, content.get("panels")),
        _checked(Looking, content.get("looking")),
        _size(content.get("window_size")),
        _checked(OpenGroups, content.get("groups")),
    )


def write_settings(path: Path, settings: Settings) -> bool:
    """Keep the settings, whole or not at all; False, and a line in the log, where that can't be done."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(path) as part:
            part.write_text(json.dumps({"version": VERSION, **asdict(settings)}, indent=2) + "\n", encoding="utf-8")
    except (OSError, InputError) as error:
        _log.warning("settings are not kept: %s", error)
        return False
    return True


def _checked(kind: type, content: object):
    """A dataclass of numbers, switches and words from what JSON gave, field by field."""
    defaults = kind()
    if not isinstance(content, dict):
        return defaults
    values = {}
    for entry in fields(kind):
        default = getattr(defaults, entry.name)
        value = content.get(entry.name, default)
        values[entry.name] = value if _fits(entry.name, value, default) else default
    return kind(**values)


def _fits(name: str, value: object, default: object) -> bool:
    if isinstance(default, bool):
        return isinstance(value, bool)
    if isinstance(default, float):
        low, high = _LIMITS[name]
        return isinstance(value, int | float) and not isinstance(value, bool) and low <= value <= high
    return value in _WORDS[name]


def _size(content: object) -> tuple[int, int] | None:
    low, high = _SIZE_LIMITS
    if isinstance(content, list) and len(content) == 2:
        width, height = content
        if all(type(side) is int and low <= side <= high for side in (width, height)):
            return width, height
    return None
